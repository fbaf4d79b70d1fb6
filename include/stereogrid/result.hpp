// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "stereogrid/camera.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/obstacle.hpp"

namespace stereogrid {

/// Images between the stages of a frame, of the camera FrameResult::level_rig. H, W: image size; D: disparities.
/// u-disparity images have a row per bin d and a column per image column u.
struct StageImages {
  Image<float> obstacle_disparity;   ///< (H, W) px, 0 = none
  Image<float> road_disparity;       ///< (H, W) px, 0 = none
  Image<float> match_confidence;     ///< (H, W) probability that the disparity is right to a pixel, 0 = none
  std::vector<int> possible;         ///< (D) N_P, eq. 10
  Image<std::uint16_t> visible;      ///< (D, W) N_V, eq. 11
  Image<std::uint16_t> observed;     ///< (D, W) N_O
  Image<float> visibility;           ///< (D, W) P(V), eq. 11
  Image<float> obstacle_confidence;  ///< (D, W) P(C), eq. 13
  Image<float> road_confidence;      ///< (D, W) P(R), eq. 15
  Image<float> occupancy;            ///< (D, W) P(T), eq. 14
  Image<float> occupancy_smooth;     ///< (D, W) after the Gaussian
};

/// Wall-clock milliseconds. On the CPU some stages go on at the same time, and share its threads: they add up to more
/// than `total` has.
struct StageTimes {
  double odometry{0};  ///< not the pipeline's: for callers who find the poses from the images
  double match{0};
  double ground{0};
  double count{0};
  double project{0};
  double filter{0};
  double flow{0};  ///< points followed in the images
  double track{0};
  double total{0};
};

/// The filtered grid some time later, if everything goes on as it moves and nothing more is seen. What is not seen is
/// forgotten with filter.forgetting_s.
struct Prediction {
  double horizon_s{0};
  Image<float> occupancy;        ///< P(occupied) in the cells of FrameResult::vehicle: where the vehicle is now
  Image<float> world_occupancy;  ///< in the cells of FrameResult::world
};

/// What a program should know about a frame before it relies on the grids.
enum class FrameStatus {
  clock_gap,            ///< more than motion.gap_max_s since the frame before: everything remembered was forgotten
  clock_stepped_back,   ///< stamped before the frame before: everything remembered was forgotten
  pose_missing,         ///< no pose: the last motion was carried on, or the vehicle taken to stand still. In every such
                        ///< frame; before any frame has had a pose in the first one only, as that may be intended
  pose_jump,            ///< the pose was not where the vehicle can be: the frame of the poses was moved
  few_matches,          ///< left and right image hardly match
  road_unknown,         ///< ground plane not found, or the ground falls away: observed grid and stages are unknown
  extrinsics_disagree,  ///< a plane in view contradicts the extrinsics, which are kept; the warning has both
  too_close,            ///< a tracked obstacle is too close to be matched or fills the view: kept as it was seen last
};
constexpr std::array<std::string_view, 8> names_of(FrameStatus) {
  return {"clock_gap",   "clock_stepped_back", "pose_missing",        "pose_jump",
          "few_matches", "road_unknown",       "extrinsics_disagree", "too_close"};
}

/// What is known after a frame.
struct FrameResult {
  Rig rig;                     ///< of this frame: as given, or with extrinsics that an earlier frame found
  Rig level_rig;               ///< of the level images that the stages use (LevelMapping); `rig` unless that is pitched
  Ground ground;               ///< used by the stages of this frame, as the camera of `level_rig` sees it
  Pose2 world_from_vehicle;    ///< world: the vehicle frame of the first frame
  double obstacle_density{0};  ///< share of the pixels matched as obstacle
  double road_density{0};      ///< share of the pixels matched as road
  Image<float> observed;       ///< P(T_X) of this frame alone, in the cells of `vehicle.geometry`
  Image<float>
      elevation_m;  ///< above `ground` in the cells of `vehicle.geometry`, NaN = unseen; empty: ground.model plane
  Image<float> elevation_sigma_m;  ///< standard deviation, NaN = unseen
  Image<TerrainClass> terrain;     ///< class of the ground
  GridLayers vehicle;              ///< filtered, re-sampled into the vehicle frame; its geometry is always the same
  GridLayers world;                ///< filtered, world-aligned; its geometry moves with the vehicle in whole cells
  std::vector<Prediction> predictions;  ///< one for each of PipelineOptions::horizons_s
  std::vector<Obstacle> obstacles;
  StageImages stages;  ///< empty: see PipelineOptions::stages
  StageTimes timing_ms;
  std::vector<FrameStatus> status;  ///< each at most once, in the order of FrameStatus; empty: nothing special
  std::vector<std::string> warnings;
};

}  // namespace stereogrid
