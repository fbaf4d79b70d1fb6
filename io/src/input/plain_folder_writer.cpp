// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <nlohmann/json.hpp>

#include "input/layout/input_layout.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/calibration.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/io/json_text.hpp"
#include "stereogrid/io/npz.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/io/truth.hpp"

namespace stereogrid::io {
namespace {

using Json = nlohmann::ordered_json;

/// To five decimals: micrometres say nothing and would treble the file.
double rounded(double number) {
  return std::round(number * 1e5) / 1e5;
}

Json grid_json(const TruthGrid& grid) {
  Json json{{"x_min_m", grid.geometry.x_min_m},
            {"y_min_m", grid.geometry.y_min_m},
            {"cell_size_m", grid.geometry.cell_size_m},
            {"nx", grid.geometry.nx},
            {"ny", grid.geometry.ny},
            {"height_min_m", grid.height_min_m},
            {"height_max_m", grid.height_max_m}};
  for (const TruthZone& zone : grid.zones) {
    json["zones"].push_back({{"kind", zone.kind},
                             {"is_hazard", zone.is_hazard},
                             {"low", {rounded(zone.low.x), rounded(zone.low.y)}},
                             {"high", {rounded(zone.high.x), rounded(zone.high.y)}}});
  }
  return json;
}

Json object_json(const TruthObject& object) {
  Json footprint = Json::array();  // no braces: they would make a list in a list
  for (const Point2& point : object.footprint) footprint.push_back({rounded(point.x), rounded(point.y)});
  return {{"id", object.id},
          {"kind", object.kind},
          {"x_m", rounded(object.world_from_object.x_m)},
          {"y_m", rounded(object.world_from_object.y_m)},
          {"yaw_rad", rounded(object.world_from_object.yaw_rad)},
          {"vx_mps", rounded(object.vx_mps)},
          {"vy_mps", rounded(object.vy_mps)},
          {"height_m", rounded(object.height_m)},
          {"size_m", {rounded(object.size_m[0]), rounded(object.size_m[1]), rounded(object.size_m[2])}},
          {"footprint", footprint},
          {"pixels", object.pixels}};
}

Json ego_json(const TruthEgo& ego) {
  Json json{{"x_m", ego.world_from_vehicle.x_m},
            {"y_m", ego.world_from_vehicle.y_m},
            {"yaw_rad", ego.world_from_vehicle.yaw_rad},
            {"vx_mps", ego.vx_mps},
            {"vy_mps", ego.vy_mps},
            {"yaw_rate_radps", ego.yaw_rate_radps}};
  if (ego.camera_height_m <= 0) return json;
  json["z_m"] = ego.z_m;
  json["pitch_rad"] = ego.pitch_rad;
  json["roll_rad"] = ego.roll_rad;
  json["camera_height_m"] = ego.camera_height_m;
  json["camera_pitch_rad"] = ego.camera_pitch_rad;
  json["camera_roll_rad"] = ego.camera_roll_rad;
  return json;
}

Json frame_json(const FrameTruth& truth) {
  Json objects = Json::array();
  for (const TruthObject& object : truth.objects) objects.push_back(object_json(object));
  return {{"name", truth.name}, {"stamp_ns", truth.stamp_ns}, {"ego", ego_json(truth.ego)}, {"objects", objects}};
}

/// The same numbers in a smaller type. Only called where they fit.
template <class To, class From>
Image<To> narrowed(const Image<From>& image) {
  Image<To> copy{image.width(), image.height()};
  std::ranges::transform(image, copy.begin(), [](From value) { return static_cast<To>(value); });
  return copy;
}

template <class To, class From>
bool fits(const Image<From>& image) {
  return std::ranges::all_of(image, [](From value) { return value >= 0 && value <= std::numeric_limits<To>::max(); });
}

/// Keeps the narrowed copies alive until they are written.
class CellArrays {
 public:
  template <class T>
  void add(const char* name, const Image<T>& image) {
    arrays_.emplace_back(name, image);
  }

  /// As 8, 16 or 32 bits, `at_least_16`: not as 8.
  void add_narrowed(const char* name, const Image<std::int32_t>& image, bool at_least_16) {
    if (!at_least_16 && fits<std::uint8_t>(image)) {
      arrays_.emplace_back(name, bytes_.emplace_back(narrowed<std::uint8_t>(image)));
    } else if (fits<std::uint16_t>(image)) {
      arrays_.emplace_back(name, words_.emplace_back(narrowed<std::uint16_t>(image)));
    } else {
      arrays_.emplace_back(name, image);
    }
  }

  void add_velocity(const Image<float>& x, const Image<float>& y) {
    velocity_.assign(x.begin(), x.end());
    velocity_.insert(velocity_.end(), y.begin(), y.end());
    const std::vector<std::size_t> shape{2, static_cast<std::size_t>(x.height()), static_cast<std::size_t>(x.width())};
    arrays_.emplace_back("velocity", shape, velocity_);
  }

  [[nodiscard]] std::span<const NpzArray> arrays() const { return arrays_; }

 private:
  std::vector<NpzArray> arrays_;
  std::deque<Image<std::uint8_t>> bytes_;  // a deque: what arrays_ points at must not move
  std::deque<Image<std::uint16_t>> words_;
  std::vector<float> velocity_;
};

void write_cells(const std::filesystem::path& path, const FrameTruth& truth) {
  CellArrays cells;
  cells.add("state", truth.state);
  cells.add("occupied", truth.occupied);
  cells.add_narrowed("owner", truth.owner, false);
  cells.add_narrowed("pixels", truth.pixels, true);
  cells.add_narrowed("seen_object", truth.seen_object, false);
  cells.add("free_points", truth.free_points);
  cells.add("low", truth.low);
  cells.add_velocity(truth.velocity_x, truth.velocity_y);
  if (!truth.terrain.empty()) {
    cells.add("terrain", truth.terrain);
    cells.add("elevation", truth.elevation_m);
    cells.add("step", truth.step_m);
  }
  write_npz(path, cells.arrays());
}

Image<std::uint16_t> scaled(const Image<float>& disparity) {
  Image<std::uint16_t> image{disparity.width(), disparity.height()};
  std::ranges::transform(disparity, image.begin(), [](float d) {
    return static_cast<std::uint16_t>(std::clamp(std::round(d * disparity_scale), 0.0F, 65535.0F));
  });
  return image;
}

void write_truth(const std::filesystem::path& folder, const FrameTruth& truth) {
  const TruthFiles files{folder, truth.name};
  write_png(files.disparity, scaled(truth.disparity));
  write_png(files.label, truth.label);
  if (fits<std::uint8_t>(truth.instance)) {
    write_png(files.instance, narrowed<std::uint8_t>(truth.instance));
  } else {
    write_png(files.instance, truth.instance);
  }
  write_png(files.seen_by_both, truth.seen_by_both);
  write_cells(files.cells, truth);
}

void refuse_a_full_folder(const std::filesystem::path& folder) {
  for (const char* const part : {"left", "right"}) {
    if (has_entries(folder / part)) {
      throw InputError{printable_path(folder), "already holds a recording.", "Remove it, or choose another folder."};
    }
  }
}

std::string camera_folder(std::size_t camera) {
  return "camera" + std::to_string(camera);
}

}  // namespace

PlainFolderWriter::PlainFolderWriter(const std::filesystem::path& folder, std::span<const Rig> rigs,
                                     std::optional<TruthGrid> truth)
    : PlainFolderWriter{rigs.size() == 1 ? folder : folder / camera_folder(0), rigs.front(), truth} {
  for (std::size_t camera{1}; camera < rigs.size(); ++camera)
    others_.emplace_back(folder / camera_folder(camera), rigs[camera]);
}

PlainFolderWriter::PlainFolderWriter(const std::filesystem::path& folder, const Rig& rig,
                                     std::optional<TruthGrid> truth)
    : folder_{folder}, rig_{rig}, truth_{truth} {
  refuse_a_full_folder(folder);
  create_folder(folder / "left");
  create_folder(folder / "right");
  if (!truth_) return;
  for (const char* const part : {"disparity", "label", "instance", "seen_by_both", "cells"}) {
    create_folder(folder / "truth" / part);
  }
}

void PlainFolderWriter::write(const StereoFrame& frame, const FrameTruth* truth) {
  if (truth_ && truth != nullptr) {
    write_truth(folder_ / "truth", *truth);
    objects_ += json_text(frame_json(*truth)) + "\n";
  }
  write_png(folder_ / "left" / (frame.name + ".png"), frame.left);
  write_png(folder_ / "right" / (frame.name + ".png"), frame.right);
  poses_.push_back({frame.name, frame.stamp_ns, frame.world_from_vehicle.value_or(Pose2{})});
  for (const StereoFrame& other : frame.others) {
    if (!others_.empty()) others_.at(static_cast<std::size_t>(other.camera - 1)).write(other);
  }
}

void PlainFolderWriter::finish() {
  if (truth_) {
    write_file(folder_ / "truth" / "grid.json", json_text(grid_json(*truth_)));
    write_file(folder_ / "truth" / "objects.jsonl", objects_);
  }
  write_poses_csv(folder_ / "poses.csv", poses_);
  write_calibration_yaml(folder_ / "calibration.yaml", rig_);
  if (others_.empty()) return;
  std::vector<std::string> folders{camera_folder(0)};
  for (PlainFolderWriter& other : others_) {
    folders.push_back(camera_folder(folders.size()));
    other.finish();
  }
  write_cameras_yaml(folder_.parent_path() / "calibration.yaml", folders);
}

}  // namespace stereogrid::io
