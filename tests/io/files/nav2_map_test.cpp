// SPDX-License-Identifier: Apache-2.0
//
// Maps are loaded again by the rules of Nav2's map_server (nav2_map_server/src/map_io.cpp).
#include "stereogrid/io/nav2_map.hpp"

#include <limits>

#include "stereogrid/io/file.hpp"
#include "stereogrid/occupancy_values.hpp"
#include "support.hpp"

namespace stereogrid::io::testing {
namespace {

using Nav2Map = FolderTest;

constexpr GridGeometry geometry{-3.3, 12.25, 0.15, 5, 4};

Image<float> some_cells() {
  Image<float> cells{5, 4, 0.5F};
  const float nan{std::numeric_limits<float>::quiet_NaN()};
  const float values[]{0, 0.1F, 0.349F, 0.35F, 0.36F, 0.44F, 0.46F, 0.54F, 0.56F, 0.64F, 0.65F, 0.66F, 1, nan};
  std::copy(std::begin(values), std::end(values), cells.begin());
  return cells;
}

/// The number behind a key at the beginning of a line.
std::string value_of(const std::string& yaml, const std::string& key) {
  const std::size_t begin{("\n" + yaml).find("\n" + key + ": ")};
  if (begin == std::string::npos) return "";
  const std::size_t value{begin + key.size() + 2};
  return yaml.substr(value, yaml.find('\n', value) - value);
}

/// mode trinary: 100, 0 or −1 of each cell, from the corner of the smallest x and y.
std::vector<std::int8_t> loaded(const fs::path& image_path, double occupied_thresh, double free_thresh) {
  const Image<std::uint8_t> image{read_grey(image_path)};
  std::vector<std::int8_t> data;
  for (const auto [x, y] : raster(image)) {
    const double occupied{(255 - image(x, image.height() - y - 1)) / 255.0};
    data.push_back(occupied > occupied_thresh ? 100 : occupied < free_thresh ? 0 : -1);
  }
  return data;
}

TEST_F(Nav2Map, IsLoadedAsItWas) {
  const Image<float> cells{some_cells()};
  write_nav2_map(folder / "lot.yaml", geometry, cells.view());
  const std::string yaml{read_text(folder / "lot.yaml", largest_bytes::settings)};
  EXPECT_EQ(value_of(yaml, "image"), "\"lot.pgm\"");
  EXPECT_EQ(value_of(yaml, "mode"), "trinary");
  EXPECT_EQ(value_of(yaml, "negate"), "0");
  EXPECT_EQ(std::stod(value_of(yaml, "resolution")), 0.15);
  EXPECT_EQ(value_of(yaml, "origin"), "[-3.3, 12.25, 0]");
  const std::vector<std::int8_t> data{loaded(folder / "lot.pgm", std::stod(value_of(yaml, "occupied_thresh")),
                                             std::stod(value_of(yaml, "free_thresh")))};
  EXPECT_EQ(data, occupancy_values(cells.view(), OccupancyScale::trinary));
  EXPECT_EQ(data[0], 0);
  EXPECT_EQ(data[12], 100);
  EXPECT_EQ(data[13], -1);
  EXPECT_EQ(data[19], -1);
}

TEST_F(Nav2Map, HasTheHighestYOnTop) {
  Image<float> cells{5, 4, 0.5F};
  cells(1, 3) = 0.9F;
  cells(4, 0) = 0.1F;
  write_nav2_map(folder / "a map.yml", geometry, cells.view());
  const Image<std::uint8_t> image{read_grey(folder / "a map.pgm")};
  EXPECT_EQ(image(1, 0), 0);
  EXPECT_EQ(image(4, 3), 254);
  EXPECT_EQ(image(0, 0), 205);
}

TEST_F(Nav2Map, RefusesWhatCannotBeOne) {
  const Image<float> cells{some_cells()};
  GridGeometry other{geometry};
  other.nx = 4;
  expect_error([&] { write_nav2_map(folder / "a.yaml", other, cells.view()); }, {"a.yaml", "size"});
  expect_error([&] { write_nav2_map(folder / "a.yaml", {}, {}); }, {"at least one"});
  expect_error([&] { write_nav2_map(folder / "a.pgm", geometry, cells.view()); }, {"end in .yaml"});
  expect_error<DeviceError>([&] { write_nav2_map(folder / "no" / "a.yaml", geometry, cells.view()); }, {"a.pgm"});
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

}  // namespace
}  // namespace stereogrid::io::testing
