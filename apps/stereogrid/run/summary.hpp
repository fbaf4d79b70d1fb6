// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "input.hpp"
#include "run/run.hpp"
#include "stereogrid/io/run_folder/run_record.hpp"

namespace stereogrid::app {

/// Wall-clock seconds of a run.
struct RunSeconds {
  double total{0};
  double reading{0};  ///< in which the pipeline waited for the input
  double writing{0};  ///< in which the pipeline waited for the files of results
};

/// A word of a command line, in quotes if the shell needs them.
[[nodiscard]] std::string shell_word(const std::string& word);

/// Numbers of frames and times of a run, and the commands for its results. `frames`: number of those that this
/// run has processed.
[[nodiscard]] std::string summary_of(const RunOptions& options, const Input& input, const io::RunRecord& record,
                                     int frames, const RunSeconds& seconds, bool is_complete);

}  // namespace stereogrid::app
