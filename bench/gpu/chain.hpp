// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "stereogrid/config.hpp"

namespace stereogrid::bench {

struct Case {
  int width;
  int height;
  int disparities;
  MatchingMethod method;
};

/// A stage's time.
struct StageResult {
  std::string name;
  double median_ms;
};

struct ChainResult {
  Case what;
  std::vector<StageResult> stages;  ///< on the device's clock
  double device_median_ms;          ///< all of them, without transfers
  double device_p99_ms;
};

/// Runs the frame pipeline `frames` times.
ChainResult run_chain(const Case& what, int frames);

/// A kernel in a frame.
struct KernelResult {
  std::string name;
  double median_us;  ///< all its launches in a frame, each between two time marks
};

/// Every kernel of a frame without graphs, over `frames` frames.
std::vector<KernelResult> run_kernels(const Case& what, int frames);

/// The filter alone, on a window of cells × cells.
StageResult run_filter(int cells, int repetitions);

}  // namespace stereogrid::bench
