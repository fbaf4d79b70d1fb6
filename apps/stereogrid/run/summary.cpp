// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "run/summary.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <optional>
#include <string>

#include "cli/console.hpp"
#include "diagnostics/frame_tally.hpp"
#include "run/lidar_stage.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/run_folder/stages.hpp"

namespace stereogrid::app {
namespace {

std::ptrdiff_t frames_of_stereo_alone(const io::RunRecord& record) {
  return std::ranges::count_if(record.finished(), [](const io::FrameSummary& frame) {
    return std::ranges::any_of(frame.warnings,
                               [](const Warning& warning) { return warning.text.starts_with(stereo_alone); });
  });
}

}  // namespace

void warn_of_frames(const io::RunRecord& record, const Input& input, const Pipeline& pipeline) {
  FrameTally tally;
  for (const io::FrameSummary& frame : record.finished()) tally.add(frame);
  const auto frame_at = [&](std::size_t index) -> std::optional<StereoFrame> {
    if (interrupted() != 0) return std::nullopt;
    try {
      return input.source->load(index);
    } catch (const InputError&) {
      return std::nullopt;
    } catch (const DeviceError&) {  // the run's own error reports it
      return std::nullopt;
    }
  };
  const Complaints complaints{
      complaints_of(tally, {input, pipeline.config(), input.source->rig(), pipeline.next_rig(), frame_at})};
  for (const std::string& text : complaints.texts) spdlog::warn("{}", text);
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
