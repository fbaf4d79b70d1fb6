// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "input.hpp"
#include "stereogrid/io/run_folder/run_record.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::app {

/// Prints the results of a run to stdout; silent under --quiet.
void print_summary(const io::RunRecord& record, double frames_per_second);

/// Logs what is wrong with the frames of the run and the remedy, as `info` does.
void warn_of_frames(const io::RunRecord& record, const Input& input, const Pipeline& pipeline);

}  // namespace stereogrid::app
