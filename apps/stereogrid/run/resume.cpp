// SPDX-License-Identifier: Apache-2.0
#include "run/resume.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "stereogrid/error.hpp"
#include "stereogrid/io/run_folder/checkpoint.hpp"

namespace stereogrid::app {
namespace {

/// The frame after which a run's folder has saved what pipeline and odometry load; none: nothing there, or it does not
/// fit.
template <class Fits>
std::optional<std::size_t> load(const std::filesystem::path& folder, Pipeline& pipeline, PoseStage& poses,
                                std::vector<std::string>& warnings, Fits fits) {
  const std::vector<std::byte> nothing{pipeline.save_state()};
  try {
    const std::optional<io::Checkpoint> saved{io::read_checkpoint(folder)};
    if (!saved || !fits(saved->index) || saved->odometry.has_value() != poses.takes_time()) return std::nullopt;
    pipeline.load_state(saved->pipeline);
    if (saved->odometry) poses.load(*saved->odometry);
    return saved->index;
  } catch (const InputError& error) {
    warnings.emplace_back(error.what());
    pipeline.load_state(nothing);
    return std::nullopt;
  }
}

/// True if the state saved after a frame precedes all frames that must be written.
bool leaves_nothing_out(const io::RunRecord& record, std::size_t saved_after) {
  for (std::size_t index{first_to_do(record)}; index <= saved_after; ++index) {
    if (record.is_written(index) && !record.is_skipped(index)) return false;
  }
  return true;
}

std::string why_skipped(const FrameSource& source, std::size_t index) {
  try {
    static_cast<void>(source.load(index));
  } catch (const InputError& error) {
    return error.what();
  }
  return "it could not be used then; the run was stopped before it had noted why.";
}

}  // namespace

std::size_t first_to_do(const io::RunRecord& record) {
  const std::vector<io::FrameSummary>& finished{record.finished()};
  return finished.empty() ? record.range().first : finished.back().index + 1;
}

Continuation continuation_of(const io::RunRecord& record, Pipeline& pipeline, PoseStage& poses, std::size_t warm_up) {
  const std::size_t next{first_to_do(record)};
  const std::size_t first{record.range().first};
  Continuation continuation{first - std::min(first, warm_up)};
  std::vector<std::string>& warnings{continuation.warnings};
  if (next == record.range().end) return {next};
  if (next > first || record.every() > 1) {
    const auto own{load(record.folder(), pipeline, poses, warnings, [&](std::size_t i) {
      return i >= first && i < record.range().end && leaves_nothing_out(record, i);
    })};
    if (own) {
      continuation.first = *own + 1;
      continuation.note =
          fmt::format("continuing with frame {}, from the state after frame {}", std::max(next, *own + 1), *own);
      return continuation;
    }
    if (next > first) {
      continuation.note =
          fmt::format("continuing with frame {}; no matching state: processing from frame {} again", next, first);
    }
  }
  return continuation;
}

void recall_skipped(const FrameSource& source, io::RunRecord& record) {
  for (const std::size_t index : record.unaccounted()) {
    record.add_skipped({index, source.name(index), why_skipped(source, index)});
  }
}

}  // namespace stereogrid::app
