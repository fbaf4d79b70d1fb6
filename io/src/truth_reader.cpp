// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "kitti_text.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/io/npz.hpp"
#include "stereogrid/io/truth.hpp"
#include "truth_layout.hpp"

namespace stereogrid::io {
namespace {

using Json = nlohmann::json;

const char* const mend{"Simulate the recording again, or remove its truth folder."};

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& what) {
  throw InputError{path.string(), what, mend};
}

TruthGrid parse_grid(const Json& json) {
  TruthGrid grid;
  grid.geometry.x_min_m = json.at("x_min_m");
  grid.geometry.y_min_m = json.at("y_min_m");
  grid.geometry.cell_size_m = json.at("cell_size_m");
  grid.geometry.nx = json.at("nx");
  grid.geometry.ny = json.at("ny");
  grid.height_min_m = json.at("height_min_m");
  grid.height_max_m = json.at("height_max_m");
  return grid;
}

Pose2 parse_pose(const Json& json) {
  return {json.at("x_m"), json.at("y_m"), json.at("yaw_rad")};
}

TruthObject parse_object(const Json& json) {
  TruthObject object;
  object.id = json.at("id");
  object.kind = json.at("kind");
  object.world_from_object = parse_pose(json);
  object.vx_mps = json.at("vx_mps");
  object.vy_mps = json.at("vy_mps");
  object.height_m = json.at("height_m");
  for (std::size_t i{0}; i < 3; ++i) object.size_m[i] = json.at("size_m").at(i);
  for (const Json& point : json.at("footprint")) object.footprint.push_back({point.at(0), point.at(1)});
  object.pixels = json.at("pixels");
  return object;
}

FrameTruth parse_frame(const Json& json) {
  FrameTruth truth;
  truth.name = json.at("name");
  truth.stamp_ns = json.at("stamp_ns");
  const Json& ego = json.at("ego");  // no braces: they would make a list of it
  truth.ego = {parse_pose(ego), ego.at("vx_mps"), ego.at("vy_mps"), ego.at("yaw_rate_radps")};
  for (const Json& object : json.at("objects")) truth.objects.push_back(parse_object(object));
  return truth;
}

Image<std::uint8_t> narrowed(const Image<std::uint16_t>& wide) {
  Image<std::uint8_t> image{wide.width(), wide.height()};
  std::ranges::transform(wide, image.begin(), [](int value) { return static_cast<std::uint8_t>(value); });
  return image;
}

/// The cells of one frame, with the checks of their shapes.
class Cells {
 public:
  Cells(const std::filesystem::path& path, const GridGeometry& geometry)
      : path_{path}, geometry_{geometry}, arrays_{read_npz(path)} {}

  template <class T>
  void take(const char* name, Image<T>& image) const {
    image = array(name, {rows(), columns()}).to_image<T>();
  }

  void take_velocity(Image<float>& x, Image<float>& y) const {
    const auto values{array("velocity", {2, rows(), columns()}).to<float>()};
    x = y = Image<float>{geometry_.nx, geometry_.ny};
    std::copy_n(values.begin(), x.size(), x.begin());
    std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(x.size()), y.size(), y.begin());
  }

 private:
  [[nodiscard]] std::size_t rows() const { return static_cast<std::size_t>(geometry_.ny); }
  [[nodiscard]] std::size_t columns() const { return static_cast<std::size_t>(geometry_.nx); }

  [[nodiscard]] const NpyArray& array(const char* name, const std::vector<std::size_t>& shape) const {
    const auto found{arrays_.find(name)};
    if (found == arrays_.end()) fail(path_, fmt::format("has no array '{}'.", name));
    if (found->second.shape != shape)
      fail(path_, fmt::format("has an array '{}' that is not as grid.json says.", name));
    return found->second;
  }

  std::filesystem::path path_;
  GridGeometry geometry_;
  std::map<std::string, NpyArray> arrays_;
};

void read_images(const TruthFiles& files, FrameTruth& truth) {
  truth.disparity = read_truth_disparity(files.disparity);
  truth.label = narrowed(read_u16(files.label));
  truth.instance = read_u16(files.instance);
  truth.seen_by_both = narrowed(read_u16(files.seen_by_both));
  const auto check{[&](const std::filesystem::path& path, const auto& image) {
    if (image.width() == truth.disparity.width() && image.height() == truth.disparity.height()) return;
    fail(path, "has another size than " + files.disparity.string() + ".");
  }};
  check(files.label, truth.label);
  check(files.instance, truth.instance);
  check(files.seen_by_both, truth.seen_by_both);
}

}  // namespace

Image<float> read_truth_disparity(const std::filesystem::path& path) {
  const Image<std::uint16_t> scaled{read_u16(path)};
  const int largest{scaled.empty() ? 0 : *std::ranges::max_element(scaled)};
  if (largest != 0 && largest <= 255) {
    throw InputError{path.string(), "has 8-bit values, no disparity of a pixel or more.",
                     "Disparity images of ground truth are 16-bit PNG, disparity × 256."};
  }
  Image<float> disparity{scaled.width(), scaled.height()};
  std::ranges::transform(scaled, disparity.begin(),
                         [](std::uint16_t value) { return static_cast<float>(value) / disparity_scale; });
  return disparity;
}

TruthReader::TruthReader(const std::filesystem::path& folder) : folder_{folder} {
  const auto grid_file{folder / "grid.json"};
  const auto objects_file{folder / "objects.jsonl"};
  const std::string grid_text{read_file(grid_file)};
  try {
    grid_ = parse_grid(Json::parse(grid_text));
  } catch (const Json::exception& error) {
    fail(grid_file, std::string{"is not understood ("} + error.what() + ").");
  }
  if (grid_.geometry.nx <= 0 || grid_.geometry.ny <= 0) fail(grid_file, "describes no cells.");
  const std::string text{read_file(objects_file)};
  for (const std::string_view line : lines_of(text)) {
    try {
      names_.push_back(Json::parse(line).at("name"));
    } catch (const Json::exception& error) {
      fail(objects_file, fmt::format("line {} is not understood ({}).", names_.size() + 1, error.what()));
    }
    if (!lines_.emplace(names_.back(), line).second) fail(objects_file, "names frame " + names_.back() + " twice.");
  }
}

FrameTruth TruthReader::objects(const std::string& name) const {
  const auto line{lines_.find(name)};
  if (line == lines_.end()) fail(folder_ / "objects.jsonl", "has no frame " + name + ".");
  try {
    return parse_frame(Json::parse(line->second));
  } catch (const Json::exception& error) {
    fail(folder_ / "objects.jsonl", fmt::format("frame {} is not understood ({}).", name, error.what()));
  }
}

FrameTruth TruthReader::frame(const std::string& name) const {
  FrameTruth truth{objects(name)};
  const TruthFiles files{folder_, name};
  read_images(files, truth);
  const Cells cells{files.cells, grid_.geometry};
  cells.take("state", truth.state);
  cells.take("occupied", truth.occupied);
  cells.take("owner", truth.owner);
  cells.take("pixels", truth.pixels);
  cells.take("seen_object", truth.seen_object);
  cells.take("free_points", truth.free_points);
  cells.take("low", truth.low);
  cells.take_velocity(truth.velocity_x, truth.velocity_y);
  return truth;
}

}  // namespace stereogrid::io
