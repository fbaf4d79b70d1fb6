// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "input/layout/input_layout.hpp"
#include "input/poses/kitti_text.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/io/json_text.hpp"
#include "stereogrid/io/npz.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/io/truth.hpp"

namespace stereogrid::io {
namespace {

using Json = nlohmann::json;

constexpr double most_m{1e8};  // and m/s, rad, rad/s: more is no street

const char* const mend{"Simulate the recording again, or remove its truth folder."};

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& what) {
  throw InputError{printable_path(path), what, mend};
}

TruthZone parse_zone(const Json& json) {
  const auto corner{[&json](const char* name) {
    return Point2{number_of(json.at(name).at(0), name, most_m), number_of(json.at(name).at(1), name, most_m)};
  }};
  return {json.at("kind"), json.at("is_hazard").get<bool>(), corner("low"), corner("high")};
}

TruthGrid parse_grid(const Json& json) {
  TruthGrid grid;
  grid.geometry = grid_geometry(json);
  grid.height_min_m = number(json, "height_min_m", most_m);
  grid.height_max_m = number(json, "height_max_m", most_m);
  if (!json.contains("zones")) return grid;
  for (const Json& zone : json.at("zones")) grid.zones.push_back(parse_zone(zone));
  return grid;
}

Pose2 parse_pose(const Json& json) {
  return {number(json, "x_m", most_m), number(json, "y_m", most_m), number(json, "yaw_rad", most_m)};
}

TruthObject parse_object(const Json& json) {
  TruthObject object;
  object.id = whole_number(json, "id", 0, std::numeric_limits<std::int32_t>::max());
  object.kind = json.at("kind");
  object.world_from_object = parse_pose(json);
  object.vx_mps = number(json, "vx_mps", most_m);
  object.vy_mps = number(json, "vy_mps", most_m);
  object.height_m = number(json, "height_m", most_m);
  for (std::size_t i{0}; i < 3; ++i) object.size_m[i] = number_of(json.at("size_m").at(i), "size_m", most_m);
  for (const Json& point : json.at("footprint")) {
    const auto coordinate{[&point](std::size_t i) { return number_of(point.at(i), "footprint", most_m); }};
    object.footprint.push_back({coordinate(0), coordinate(1)});
  }
  object.pixels = whole_number(json, "pixels", 0, std::numeric_limits<std::int64_t>::max());
  return object;
}

FrameTruth parse_frame(const Json& json) {
  FrameTruth truth;
  truth.name = json.at("name");
  truth.stamp_ns = whole_number(json, "stamp_ns", -largest_stamp_ns, largest_stamp_ns);
  const Json& ego = json.at("ego");  // no braces: they would make a list of it
  truth.ego = {parse_pose(ego), number(ego, "vx_mps", most_m), number(ego, "vy_mps", most_m),
               number(ego, "yaw_rate_radps", most_m)};
  const auto optional{[&ego](const char* name) { return ego.contains(name) ? number(ego, name, most_m) : 0.0; }};
  truth.ego.z_m = optional("z_m");
  truth.ego.pitch_rad = optional("pitch_rad");
  truth.ego.roll_rad = optional("roll_rad");
  truth.ego.camera_height_m = optional("camera_height_m");
  truth.ego.camera_pitch_rad = optional("camera_pitch_rad");
  truth.ego.camera_roll_rad = optional("camera_roll_rad");
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

  [[nodiscard]] bool has(const char* name) const { return arrays_.contains(name); }

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
    fail(path, "has another size than " + printable_path(files.disparity) + ".");
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
    throw InputError{printable_path(path), "has 8-bit values, no disparity of a pixel or more.",
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
  read_json<Json>(printable_path(grid_file), read_text(grid_file, largest_bytes::json), "", mend,
                  [this](const Json& json) { grid_ = parse_grid(json); });
  const std::string text{read_text(objects_file, largest_bytes::json)};
  for (const std::string_view line : lines_of(text)) {
    read_json<Json>(printable_path(objects_file), line, fmt::format("line {} ", names_.size() + 1), mend,
                    [this](const Json& json) { names_.push_back(json.at("name")); });
    if (lines_.emplace(names_.back(), line).second) continue;
    fail(objects_file, "names frame " + names_.back() + " twice.");
  }
}

FrameTruth TruthReader::objects(const std::string& name) const {
  const auto line{lines_.find(name)};
  const auto file{folder_ / "objects.jsonl"};
  if (line == lines_.end()) fail(file, "has no frame " + name + ".");
  FrameTruth truth;
  read_json<Json>(printable_path(file), line->second, fmt::format("frame {} ", name), mend,
                  [&truth](const Json& json) { truth = parse_frame(json); });
  return truth;
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
  if (!cells.has("terrain")) return truth;
  cells.take("terrain", truth.terrain);
  cells.take("elevation", truth.elevation_m);
  cells.take("step", truth.step_m);
  return truth;
}

}  // namespace stereogrid::io
