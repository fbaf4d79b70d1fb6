// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "stereogrid/export.hpp"
#include "stereogrid/obstacle.hpp"
#include "stereogrid/pipeline.hpp"
#include "stereogrid/result.hpp"

namespace stereogrid::io {

/// A line of frames.jsonl (docs/format.md), without the end of line. `rig`: Pipeline::rig() before the frame.
/// `compact`: obstacles, densities and times rounded as docs/format.md says.
[[nodiscard]] STEREOGRID_EXPORT std::string frame_line(const StereoFrame& frame, const FrameResult& result,
                                                       const Rig& rig, bool compact = false);

/// No drive has as many frames.
inline constexpr std::int64_t largest_index{1'000'000'000};

/// The part of a frame's result that the summary of a run needs.
struct FrameSummary {
  std::size_t index{0};
  StageTimes timing_ms;
  std::vector<Warning> warnings;
  std::vector<FrameStatus> status;
  std::string name{};
  Ground ground{};                                ///< FrameResult::ground
  bool is_known{true};                            ///< at least one cell of the observed grid is known
  std::optional<std::string> exposure_warning{};  ///< one of `warnings`; none: equal exposures
};
/// Summary of one frame.
[[nodiscard]] STEREOGRID_EXPORT FrameSummary summary_of(const StereoFrame& frame, const FrameResult& result);

/// Extrinsics of the camera in a frame's line.
struct Extrinsics {
  double camera_height_m{0};
  double camera_pitch_rad{0};
  double camera_roll_rad{0};
};

/// A frame of a finished run, without its grids. Obstacles of older versions have no outlines.
struct RunFrame {
  std::size_t index{0};  ///< in the input
  std::string name;
  std::int64_t stamp_ns{0};
  Pose2 world_from_vehicle;
  StageTimes timing_ms;  ///< 0: stage missing in an older version
  std::vector<Obstacle> obstacles;
  std::vector<FrameStatus> status{};
  double speed_limit_mps{std::numeric_limits<double>::infinity()};
  SpeedReason speed_limit_reason{SpeedReason::none};  ///< none: not in the file of an older version, too
  std::optional<Extrinsics> extrinsics{};             ///< none: not in the file of an older version
};

// Both read frames.jsonl: frames in their order, without duplicates. Throw InputError.

/// A missing file has no frames. An incomplete last line is removed from the file; DeviceError if that fails.
[[nodiscard]] STEREOGRID_EXPORT std::vector<FrameSummary> take_finished_frames(const std::filesystem::path& path);
/// The file must be complete. Names are file names without duplicates.
[[nodiscard]] STEREOGRID_EXPORT std::vector<RunFrame> read_run_frames(const std::filesystem::path& path);

/// A field of an obstacle in frames.jsonl.
struct ObstacleField {
  const char* name;
  bool is_required{true};  ///< false: missing in runs of older versions, which leave the default
  double largest{1e6};     ///< largest magnitude of a number that is read
  double steps{1000};      ///< compact lines round numbers to 1/steps
};

/// Calls visit(ObstacleField, member) for every field, in the order of frames.jsonl (docs/format.md).
template <class AnyObstacle, class Visit>
void visit_fields(AnyObstacle& o, Visit&& visit) {
  constexpr double longest_s{1e10};  // between any two stamps
  visit(ObstacleField{"id"}, o.id);
  visit(ObstacleField{"x_m"}, o.x_m);
  visit(ObstacleField{"y_m"}, o.y_m);
  visit(ObstacleField{"vx_mps"}, o.vx_mps);
  visit(ObstacleField{"vy_mps"}, o.vy_mps);
  visit(ObstacleField{"length_m"}, o.length_m);
  visit(ObstacleField{"width_m"}, o.width_m);
  visit(ObstacleField{.name = "yaw_rad", .steps = 10'000}, o.yaw_rad);
  visit(ObstacleField{.name = "age_s", .largest = longest_s}, o.age_s);
  visit(ObstacleField{"occupancy"}, o.occupancy);
  visit(ObstacleField{"confirmed"}, o.confirmed);
  visit(ObstacleField{"moving", false}, o.moving);
  visit(ObstacleField{"coasting", false}, o.coasting);
  visit(ObstacleField{"unseen_s", false, longest_s}, o.unseen_s);
  visit(ObstacleField{.name = "position_covariance", .is_required = false}, o.position_covariance);
  visit(ObstacleField{.name = "velocity_covariance", .is_required = false}, o.velocity_covariance);
  visit(ObstacleField{"kind", false}, o.kind);
  visit(ObstacleField{"height_m", false}, o.height_m);
  visit(ObstacleField{"outline_m", false}, o.outline);
  visit(ObstacleField{"yaw_rate_radps", false}, o.yaw_rate_radps);
  visit(ObstacleField{"length_sigma_m", false}, o.length_sigma_m);
  visit(ObstacleField{"width_sigma_m", false}, o.width_sigma_m);
  visit(ObstacleField{"yaw_sigma_rad", false}, o.yaw_sigma_rad);
}

struct StageField {
  std::string_view name;
  double StageTimes::*milliseconds;
};

/// The names that timings carry in every file.
constexpr std::array<StageField, 9> stage_fields{{{"odometry", &StageTimes::odometry},
                                                  {"match", &StageTimes::match},
                                                  {"ground", &StageTimes::ground},
                                                  {"count", &StageTimes::count},
                                                  {"project", &StageTimes::project},
                                                  {"filter", &StageTimes::filter},
                                                  {"flow", &StageTimes::flow},
                                                  {"track", &StageTimes::track},
                                                  {"total", &StageTimes::total}}};

}  // namespace stereogrid::io
