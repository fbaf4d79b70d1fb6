// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "run/summary.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>

#include "console.hpp"
#include "run/lidar_stage.hpp"
#include "stereogrid/io/calibration.hpp"
#include "stereogrid/io/run_folder/stages.hpp"

namespace stereogrid::app {
namespace {

std::ptrdiff_t frames_of_stereo_alone(const io::RunRecord& record) {
  return std::ranges::count_if(record.finished(), [](const io::FrameSummary& frame) {
    return std::ranges::any_of(frame.warnings, [](const std::string& text) { return text.starts_with(stereo_alone); });
  });
}

}  // namespace

void warn_of_unknown_frames(const io::RunRecord& record, const Rig& rig, const Rig& mounted) {
  constexpr double degrees{57.29577951308232};
  const std::size_t all{record.finished().size()};
  const std::size_t unknown{record.frames_with(FrameStatus::road_unknown)};
  const std::size_t unmatched{record.frames_with(FrameStatus::few_matches)};
  if (unknown > 0 && mounted != rig) {
    spdlog::warn(
        "in {} of {} frames it is not known where the road is, and the grid is unknown. The camera is not mounted as "
        "was assumed. Without such a beginning: add to calibration.yaml\n{}",
        unknown, all, io::mount_line(mounted));
  } else if (unknown > 0) {
    spdlog::warn(
        "in {} of {} frames it is not known where the road is, and the grid is unknown. The mounting may be wrong: "
        "{:.3g} m "
        "above the road and a pitch of {:.1f}° are assumed. Measure them and write them to calibration.yaml: "
        "mount.camera_height_m, mount.camera_pitch_rad.",
        unknown, all, rig.camera_height_m, rig.camera_pitch_rad * degrees);
  }
  if (unmatched > 0) {
    spdlog::warn(
        "in {} of {} frames left and right image hardly match, and the grid is unknown. stereogrid info looks for the "
        "reason: images swapped, of different instants, not rectified, dark.",
        unmatched, all);
  }
}

void print_summary(const io::RunRecord& record, double frames_per_second) {
  if (!spdlog::should_log(spdlog::level::info)) return;
  const io::FrameRange& range{record.range()};
  tell("{} frames, {} of {} skipped, {:.2f} frames per second\n", record.finished().size(), record.skipped().size(),
       range.end - range.first, frames_per_second);
  tell("median ms per frame:");
  for (const io::StageField& stage : io::stage_fields) {
    tell(" {} {:.1f}", stage.name, record.timing(stage.milliseconds).p50);
  }
  const std::ptrdiff_t alone{frames_of_stereo_alone(record)};
  if (alone > 0) tell("\n{} of {} frames had no lidar", alone, record.finished().size());
  tell("\nresults in {}\n", record.folder().string());
}

}  // namespace stereogrid::app
