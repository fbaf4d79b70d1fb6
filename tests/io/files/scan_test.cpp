// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/recording.hpp"

#include <cmath>
#include <limits>
#include <span>

#include "stereogrid/io/truth.hpp"
#include "support.hpp"

namespace stereogrid::io::testing {
namespace {

using Scan = FolderTest;
using TruthDisparity = FolderTest;

void put_floats(const fs::path& path, const std::vector<float>& values) {
  const auto bytes{std::as_bytes(std::span{values})};
  put(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

TEST_F(Scan, ReadsPointsInOrder) {
  put_floats(folder / "a.bin", {1, 2, 3, 0.5F, -4, 5.25F, -6, 0});
  const auto points{read_scan(folder / "a.bin")};
  ASSERT_EQ(points.size(), 2U);
  EXPECT_EQ(points[0].y_m, 2);
  EXPECT_EQ(points[0].reflectance, 0.5F);
  EXPECT_EQ(points[1].x_m, -4);
  EXPECT_EQ(points[1].z_m, -6);
}

TEST_F(Scan, LeavesOutWhatDidNotReturn) {
  const float none{std::numeric_limits<float>::quiet_NaN()};
  const float far{std::numeric_limits<float>::infinity()};
  put_floats(folder / "a.bin", {none, 2, 3, 0, 1, far, 3, 0, 1, 2, none, 0, 7, 8, 9, none});
  const auto points{read_scan(folder / "a.bin")};
  ASSERT_EQ(points.size(), 1U);
  EXPECT_EQ(points[0].x_m, 7);
  put_floats(folder / "b.bin", {none, none, none, none});
  expect_error([&] { return read_scan(folder / "b.bin"); }, {"b.bin", "finite"});
}

TEST_F(Scan, Findings) {
  const auto refused{[&](const fs::path& path, std::initializer_list<std::string_view> parts) {
    expect_error([&] { return read_scan(path); }, parts);
  }};
  refused(folder / "none.bin", {"none.bin", "no such file"});
  refused(folder.path(), {"is a folder"});
  put(folder / "empty.bin", "");
  refused(folder / "empty.bin", {"empty.bin", "is empty"});
  put(folder / "cut.bin", std::string(35, '\0'));
  refused(folder / "cut.bin", {"cut.bin", "35 bytes", "cut off"});
}

TEST_F(Scan, OfADriveLiesAheadOfTheSensor) {
  const auto data{data_folder()};
  if (!data) GTEST_SKIP() << "no data sets on this machine (STEREOGRID_DATA)";
  const auto points{read_scan(*data / "kitti_odo04" / "velodyne" / "000000.bin")};
  EXPECT_GT(points.size(), 10000U);
  for (const ScanPoint& point : points) {
    ASSERT_GT(point.x_m, 0);
    ASSERT_LT(std::abs(point.z_m), 50);
  }
}

TEST_F(TruthDisparity, IsScaled) {
  Image<std::uint16_t> scaled{3, 2};
  scaled(1, 0) = 640;
  scaled(2, 1) = 65535;
  write_png(folder / "d.png", scaled);
  const Image<float> disparity{read_truth_disparity(folder / "d.png")};
  EXPECT_EQ(disparity.width(), 3);
  EXPECT_EQ(disparity(0, 0), 0);
  EXPECT_EQ(disparity(1, 0), 2.5F);
  EXPECT_EQ(disparity(2, 1), 65535 / 256.0F);
  write_png(folder / "nothing.png", Image<std::uint16_t>{3, 2});
  EXPECT_EQ(read_truth_disparity(folder / "nothing.png"), (Image<float>{3, 2}));
}

TEST_F(TruthDisparity, Findings) {
  const auto refused{[&](const char* name, std::initializer_list<std::string_view> parts) {
    expect_error([&] { return read_truth_disparity(folder / name); }, parts);
  }};
  refused("none.png", {"none.png", "no such file"});
  write_png(folder / "bytes.png", Image<std::uint8_t>{4, 4, 77});
  refused("bytes.png", {"bytes.png", "8-bit"});
  write_png(folder / "colour.png", RgbImage{4, 4, Image<std::uint8_t>{12, 4, 77}});
  refused("colour.png", {"colour.png", "colour"});
  put(folder / "text.png", "nonsense");
  refused("text.png", {"text.png"});
}

}  // namespace
}  // namespace stereogrid::io::testing
