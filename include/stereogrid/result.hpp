// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "stereogrid/camera.hpp"
#include "stereogrid/exposure.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/obstacle.hpp"

namespace stereogrid {

/// Images between the stages of a frame, for the camera FrameResult::level_rig. H, W: image size; D: disparities.
/// u-disparity images have a row per bin d and a column per image column u.
struct StageImages {
  Image<float> obstacle_disparity;   ///< (H, W) px, 0 = none
  Image<float> road_disparity;       ///< (H, W) px, 0 = none
  Image<float> match_confidence;     ///< (H, W) probability that the disparity is right to a pixel, 0 = none
  Image<std::uint8_t> ambiguous;     ///< (H, W) 1: a textured obstacle pixel whose match is not unique, else 0
  std::vector<int> possible;         ///< (D) N_P, eq. 10
  Image<std::uint16_t> visible;      ///< (D, W) N_V, eq. 11
  Image<std::uint16_t> observed;     ///< (D, W) N_O
  Image<float> visibility;           ///< (D, W) P(V), eq. 11
  Image<float> obstacle_confidence;  ///< (D, W) P(C), eq. 13
  Image<float> road_confidence;      ///< (D, W) P(R), eq. 15
  Image<float> occupancy;            ///< (D, W) P(T), eq. 14
  Image<float> occupancy_smooth;     ///< (D, W) after the Gaussian
};

/// Wall-clock milliseconds. On the CPU some stages run in parallel on the same threads; their sum may exceed `total`.
struct StageTimes {
  double odometry{0};  ///< set by callers that use visual odometry
  double match{0};
  double ground{0};
  double count{0};
  double project{0};
  double filter{0};
  double flow{0};  ///< feature tracking
  double track{0};
  double total{0};
};

/// Filtered grid after a time, if all motion continues and nothing is observed. Cells decay with filter.decay_time_s.
struct Prediction {
  double horizon_s{0};
  Image<float> occupancy;        ///< P(occupied) in the cells of FrameResult::vehicle, relative to the present vehicle
  Image<float> world_occupancy;  ///< in the cells of FrameResult::world
};

/// Conditions that limit the use of a frame's grids.
enum class FrameStatus {
  clock_gap,            ///< more than motion.gap_max_s since the frame before: all state was reset, or a camera's
  clock_stepped_back,   ///< stamp before that of the last frame: likewise; the warning names one of several cameras
  pose_missing,         ///< no pose: the last motion continues. Before the first pose the vehicle is assumed to be
                        ///< static, and only the first frame has the flag
  pose_jump,            ///< implausible pose change: the pose frame was shifted
  few_matches,          ///< left and right image hardly match, or there is no disparity
  road_unknown,         ///< ground plane not found, or the ground falls away: observed grid and stages are unknown
  extrinsics_disagree,  ///< a plane in view contradicts the extrinsics, which are kept; the warning has both
  too_close,  ///< a tracked obstacle is too close to be matched or fills the view: its last observation is kept
  gpu_lost,   ///< the GPU has failed: BackEnd::automatic continues on the CPU, and all state was reset
};
constexpr std::array<std::string_view, 9> names_of(FrameStatus) {
  return {"clock_gap",    "clock_stepped_back",  "pose_missing", "pose_jump", "few_matches",
          "road_unknown", "extrinsics_disagree", "too_close",    "gpu_lost"};
}

[[nodiscard]] inline bool has_any(const std::vector<FrameStatus>& status, std::initializer_list<FrameStatus> wanted) {
  return std::ranges::find_first_of(status, wanted) != status.end();
}

/// Reason of FrameResult::speed_limit_mps: hazards that the frame could not show beyond a range.
enum class SpeedReason {
  none,      ///< no limit: ground.model is plane
  noise,     ///< low obstacles and steps: their height is within the noise
  ditches,   ///< the camera sees too few rows of the far wall
  drops,     ///< the disparity jumps too little at a drop of a step
  descents,  ///< a gap with lower ground behind it may be a slope
  frame,     ///< the frame shows nothing: its grids are from memory
};
constexpr std::array<std::string_view, 6> names_of(SpeedReason) {
  return {"none", "noise", "ditches", "drops", "descents", "frame"};
}

/// Message about a frame.
struct Warning {
  std::string text;
  std::optional<FrameStatus> status{};  ///< condition that it describes; none: the grids are not limited
  friend bool operator==(const Warning&, const Warning&) = default;
};

/// Result of a frame.
struct FrameResult {
  Rig rig;                     ///< rig of this frame: as given, or with estimated extrinsics
  Rig level_rig;               ///< rig of the level images of the stages (LevelMapping); equal to `rig` unless that is
                               ///< pitched
  Ground ground;               ///< ground of this frame's stages, relative to the camera of `level_rig`
  Pose2 world_from_vehicle;    ///< world frame: the vehicle frame of the first frame
  double obstacle_density{0};  ///< share of the pixels matched as obstacle
  double road_density{0};      ///< share of the pixels matched as road
  Image<float> observed;       ///< P(T_X) of this frame alone, in the cells of `vehicle.geometry`
  Image<float>
      elevation_m;  ///< m above `ground` in the cells of `vehicle.geometry`, NaN = unseen; empty: ground.model plane
  Image<float> elevation_sigma_m;  ///< standard deviation, NaN = unseen
  Image<TerrainClass> terrain;     ///< class of the ground
  Image<CellWitness> witness;      ///< evidence of free cells; empty: ground.model plane
  Image<float> world_elevation_m;  ///< m above `ground` over all frames, in the cells of `world.geometry`, NaN = never
                                   ///< seen; empty: ground.model plane
  Image<float> world_elevation_sigma_m;                             ///< standard deviation, NaN = never seen
  Image<TerrainClass> world_terrain;                                ///< drops and obstacles of all frames, free ground
  double speed_limit_mps{std::numeric_limits<double>::infinity()};  ///< a faster vehicle cannot stop within the range
                                                                    ///< of hazards (docs/terrain.md)
  SpeedReason speed_limit_reason{SpeedReason::none};
  GridLayers vehicle;                   ///< filtered, in the vehicle frame, corrected by `observed`; constant geometry
  GridLayers world;                     ///< filtered, world-aligned; its geometry moves with the vehicle in whole cells
  std::vector<Prediction> predictions;  ///< one for each of PipelineOptions::horizons_s
  std::vector<Obstacle> obstacles;
  StageImages stages;  ///< empty: see PipelineOptions::stages
  StageTimes timing_ms;
  std::vector<FrameStatus> status;  ///< each at most once, in the order of FrameStatus; empty: none
  std::vector<Warning> warnings;
  Exposure exposure;  ///< exposure of both images; equal without a right one
  /// With several cameras, one for each of Pipeline::rigs(), else empty. Each has what its camera alone gives: rigs,
  /// ground, densities, stages, status, warnings, exposure, and in the cells of `vehicle.geometry` the observed grid
  /// and the terrain of the frame, and the speed limit, whose smallest is the result's own. Ground, rigs, densities and
  /// stages of the first camera are the result's own; a status of the cameras only if all of them have it.
  std::vector<FrameResult> cameras;
  bool has_images{true};    ///< false: one of `cameras` that has no images in this frame, and observes nothing
  std::string camera_name;  ///< name of one of `cameras` (PipelineOptions::camera_names), else empty

  /// Adds a status and its message. No `text`: an earlier frame has the message.
  void add(FrameStatus condition, std::optional<std::string> text) {
    status.push_back(condition);
    if (text) warnings.push_back({std::move(*text), condition});
  }
};

/// Rigs of a frame's cameras, one at least.
[[nodiscard]] inline std::vector<Rig> rigs_of(const FrameResult& result) {
  if (result.cameras.empty()) return {result.rig};
  std::vector<Rig> rigs;
  for (const FrameResult& camera : result.cameras) rigs.push_back(camera.rig);
  return rigs;
}

}  // namespace stereogrid
