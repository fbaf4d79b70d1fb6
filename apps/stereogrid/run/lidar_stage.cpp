// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "run/lidar_stage.hpp"

#include "stereogrid/error.hpp"
#include "stereogrid/evaluation/lidar_grid.hpp"

namespace stereogrid::app {

const char* const stereo_alone{"stereo alone: "};

LidarStage::LidarStage(bool wanted, const Input& input, const GridGeometry& grid)
    : wanted_{wanted}, sweeps_{input.recording}, grid_{grid} {
  if (wanted) {
    sweeps_.require(input.recording == nullptr ? "Leave --fuse out."
                                               : "Put KITTI's folder velodyne/ (raw drives: velodyne_points/) beside "
                                                 "the images, or leave --fuse out.");
  }
}

std::optional<std::string> LidarStage::add_grid(StereoFrame& frame, const Rig& rig) const {
  if (!wanted_) return std::nullopt;
  try {
    const std::vector<evaluation::CameraPoint> points{sweeps_.of(static_cast<std::size_t>(frame.index))};
    if (points.empty()) return std::string{stereo_alone} + "no lidar sweep";
    frame.other_grids.push_back(
        {grid_, evaluation::lidar_grid(points, sweeps_.lidar_in_camera(), rig, grid_, rig.camera_height_m)});
    return std::nullopt;
  } catch (const InputError& error) {
    return stereo_alone + std::string{error.what()};
  }
}

}  // namespace stereogrid::app
