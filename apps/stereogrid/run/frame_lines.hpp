// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "stereogrid/pipeline.hpp"

namespace stereogrid::app {

/// A line of frames.jsonl (docs/format.md), without the end of line.
[[nodiscard]] std::string frame_line(const StereoFrame& frame, const FrameResult& result);

/// No drive has as many frames.
constexpr std::int64_t largest_index{1'000'000'000};

/// What going on with a run has to know of a frame that is done.
struct FrameSummary {
  std::size_t index{0};
  Pose2 world_from_vehicle;
  StageTimes timing_ms;
  std::vector<std::string> warnings;
  std::vector<FrameStatus> status;
};

struct FinishedFrames {
  std::vector<FrameSummary> frames;
  std::int64_t largest_id{0};
};

/// Frames stand in frames.jsonl in their order, each once. Throws InputError without file where `index` is below
/// `least`, one more than that of the line before.
void check_order(std::size_t least, std::size_t index);

/// Reads frames.jsonl; a missing file has no frames. A torn last line is cut off the file. Throws InputError, and
/// DeviceError where that cannot be done.
[[nodiscard]] FinishedFrames read_frame_lines(const std::filesystem::path& path);

}  // namespace stereogrid::app
