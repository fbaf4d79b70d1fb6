// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "run/resume.hpp"

#include <spdlog/spdlog.h>

#include <optional>
#include <vector>

#include "stereogrid/error.hpp"
#include "stereogrid/io/run_folder/checkpoint.hpp"

namespace stereogrid::app {

std::size_t first_to_do(const io::RunRecord& record) {
  const std::vector<io::FrameSummary>& finished{record.finished()};
  return finished.empty() ? record.range().first : finished.back().index + 1;
}

std::size_t first_frame_of(const io::RunRecord& record, Pipeline& pipeline, PoseStage& poses) {
  const std::size_t next{first_to_do(record)};
  const std::size_t first{record.range().first};
  if (next == first || next == record.range().end) return next;
  const std::vector<std::byte> nothing{pipeline.save_state()};
  try {
    const std::optional<io::Checkpoint> saved{io::read_checkpoint(record.folder())};
    const bool fits{saved && saved->index >= first && saved->index < next &&
                    saved->odometry.has_value() == poses.takes_time()};
    if (fits) {
      pipeline.load_state(saved->pipeline);
      if (saved->odometry) poses.load(*saved->odometry);
      spdlog::info("going on with frame {}, from what was saved after frame {}", next, saved->index);
      return saved->index + 1;
    }
    spdlog::info("going on with frame {}; nothing saved fits: beginning with frame {} again", next, first);
  } catch (const InputError& error) {
    spdlog::warn("{} The frames are worked through from the first one on again.", error.what());
    pipeline.load_state(nothing);
  }
  return first;
}

}  // namespace stereogrid::app
