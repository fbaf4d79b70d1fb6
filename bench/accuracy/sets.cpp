// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "accuracy/sets.hpp"

#include <memory>
#include <utility>

#include "backend/cpu.hpp"
#include "images/levelling.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/io/scan.hpp"
#include "stereogrid/io/truth.hpp"

namespace stereogrid::bench {
namespace {

namespace fs = std::filesystem;

constexpr int kitti_disparities{128};

std::shared_ptr<const io::Recording> open(const fs::path& folder) {
  return io::open_recording({{folder}, {}, ""});
}

/// Builds a frame of KITTI's drives or pairs; the road is fitted to the truth itself.
TruthFrame measured(const io::Recording& recording, std::size_t index, std::vector<TruthPoint> points) {
  TruthFrame truth;
  truth.frame = recording.load(index);
  remove_hidden(recording.rig(), points);
  truth.plane = fit_road(recording.rig(), points);
  label_by_height(recording.rig(), truth.plane, points);
  keep_comparable(recording.rig(), kitti_disparities, points);
  truth.points = std::move(points);
  return truth;
}

TruthSet lidar_set(const fs::path& folder, const std::string& group) {
  const auto recording{open(folder)};
  const auto camera_from_velodyne{recording->contents().calibration.camera_from_velodyne};
  if (!camera_from_velodyne) {
    throw InputError{recording->contents().calibration_file.string(), "does not say where the lidar is.",
                     "A line Tr is needed."};
  }
  std::vector<std::size_t> indices;
  for (std::size_t i{0}; i < recording->size(); ++i) {
    if (!recording->contents().frames[i].scan.empty()) indices.push_back(i);
  }
  const auto load{[=](std::size_t place) {
    const std::size_t index{indices.at(place)};
    const auto scan{io::read_scan(recording->contents().frames[index].scan)};
    return measured(*recording, index, points_of_scan(scan, *camera_from_velodyne, recording->rig()));
  }};
  return {folder.filename().string(), group, recording->rig(), kitti_disparities, 1, indices.size(), load};
}

TruthSet disparity_set(const fs::path& folder, const std::string& group) {
  const auto recording{open(folder)};
  const auto load{[=](std::size_t index) {
    const auto file{folder / "disp_occ_0" / (recording->name(index) + ".png")};
    const Image<float> disparity{io::read_truth_disparity(file)};
    if (disparity.width() != recording->rig().width_px || disparity.height() != recording->rig().height_px)
      throw InputError{file.string(), "has another size than the images.", "Take the truth of these images."};
    return measured(*recording, index, points_of_image(disparity));
  }};
  return {folder.filename().string(), group, recording->rig(), kitti_disparities, 2, recording->size(), load};
}

void level(const Levelling& levelling, Cpu& cpu, Image<std::uint8_t>& image) {
  const Rig& rig{levelling.level_rig()};
  const Image<std::uint8_t> pitched{std::exchange(image, {rig.width_px, rig.height_px})};
  levelling.apply(cpu, pitched.view(), image.view());
}

TruthSet scene_set(const fs::path& folder) {
  const auto recording{open(folder)};
  const auto reader{std::make_shared<io::TruthReader>(recording->contents().truth_folder)};
  const auto levelling{std::make_shared<Levelling>(recording->rig())};
  const auto cpu{std::make_shared<Cpu>(0)};
  const Rig& rig{levelling->level_rig()};
  const int disparities{rig.width_px < 1000 ? 64 : kitti_disparities};
  const auto load{[=](std::size_t index) {
    TruthFrame truth;
    truth.frame = recording->load(index);
    truth.points = points_of_scene(reader->frame(recording->name(index)));
    if (levelling->is_needed()) {
      level(*levelling, *cpu, truth.frame.left);
      level(*levelling, *cpu, truth.frame.right);
      turn_level(recording->rig(), levelling->level_rig(), truth.points);
    }
    const Rig& level_rig{levelling->level_rig()};
    truth.plane =
        road_plane(level_rig, {level_rig.camera_height_m, level_rig.camera_pitch_rad, level_rig.camera_roll_rad});
    keep_comparable(level_rig, disparities, truth.points);
    return truth;
  }};
  return {folder.filename().string(), "synthetic", rig, disparities, 4, recording->size(), load};
}

}  // namespace

std::vector<TruthSet> open_sets(const fs::path& data) {
  std::vector<TruthSet> sets;
  for (const char* const name : {"kitti_odo04", "kitti_raw0009"}) {
    if (fs::is_directory(data / name)) sets.push_back(lidar_set(data / name, name));
  }
  const fs::path pairs{data / "kitti_pairs"};
  if (fs::is_directory(pairs / "obj_stereo_rcnn")) sets.push_back(lidar_set(pairs / "obj_stereo_rcnn", "kitti_pairs"));
  if (fs::is_directory(pairs / "stereo2015_000046"))
    sets.push_back(disparity_set(pairs / "stereo2015_000046", "kitti_pairs"));
  for (const char* const name : {"A-static-occlusion", "B-crossing", "C-street", "D-pitched", "E-kitti-like"}) {
    if (fs::is_directory(data / "synthetic" / name)) sets.push_back(scene_set(data / "synthetic" / name));
  }
  return sets;
}

}  // namespace stereogrid::bench
