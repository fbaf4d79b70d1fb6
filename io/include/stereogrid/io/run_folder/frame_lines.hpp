// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "stereogrid/export.hpp"
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
  std::optional<Extrinsics> extrinsics{};  ///< none: not in the file of an older version
};

// Both read frames.jsonl: frames in their order, without duplicates. Throw InputError.

/// A missing file has no frames. An incomplete last line is removed from the file; DeviceError if that fails.
[[nodiscard]] STEREOGRID_EXPORT std::vector<FrameSummary> take_finished_frames(const std::filesystem::path& path);
/// The file must be complete. Names are file names without duplicates.
[[nodiscard]] STEREOGRID_EXPORT std::vector<RunFrame> read_run_frames(const std::filesystem::path& path);

}  // namespace stereogrid::io
