// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "frame_stages.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/io/run_folder/run_record.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::app {

/// The first frame of a run that is not finished.
[[nodiscard]] std::size_t first_to_do(const io::RunRecord& record);

/// First frame to process, and messages for the user.
struct Continuation {
  std::size_t first{0};
  std::string note{};  ///< empty: a new run, or a complete one
  std::vector<std::string> warnings{};
};

/// Continues after the checkpoint that pipeline and odometry load, or at the beginning of the run. Frames completed
/// after the checkpoint are processed again, with the same results. `warm_up`: frames processed before the first one,
/// unwritten.
[[nodiscard]] Continuation continuation_of(const io::RunRecord& record, Pipeline& pipeline, PoseStage& poses,
                                           std::size_t warm_up);

/// Adds the skipped frames that the files of a killed run do not list: those missing between completed ones. Loads them
/// again for the reason.
void recall_skipped(const FrameSource& source, io::RunRecord& record);

}  // namespace stereogrid::app
