// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "pose_stage.hpp"
#include "stereogrid/io/run_folder/run_record.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::app {

/// The first frame of a run that is not finished.
[[nodiscard]] std::size_t first_to_do(const io::RunRecord& record);

/// Where a run goes on: behind the frame of its checkpoint, which pipeline and odometry load, or at its first frame.
/// What was finished after that goes through the pipeline again, to the same results.
[[nodiscard]] std::size_t first_frame_of(const io::RunRecord& record, Pipeline& pipeline, PoseStage& poses);

}  // namespace stereogrid::app
