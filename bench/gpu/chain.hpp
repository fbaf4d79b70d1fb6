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
  double p99_ms;
};

struct ChainResult {
  Case what;
  std::vector<StageResult> stages;  ///< on the device's clock
  double total_median_ms;           ///< images in, grids and obstacles out, on the host's clock
  double total_p99_ms;
  double device_median_ms;  ///< without transfers and host
};

/// Runs the frame pipeline `frames` times.
ChainResult run_chain(const Case& what, int frames);

/// A kernel in a frame.
struct KernelResult {
  std::string name;
  double launches;   ///< a frame
  double median_us;  ///< all kernels, each between two time marks
};

/// Every kernel of a frame without graphs, the one that takes longest first, over `frames` frames.
std::vector<KernelResult> run_kernels(const Case& what, int frames);

/// Frames per second of `cameras` pipelines, each in a thread of its own, and the device a frame ahead of the host.
double run_batch(const Case& what, int cameras, int frames);

/// The filter alone, on a window of cells × cells.
StageResult run_filter(int cells, int repetitions);

}  // namespace stereogrid::bench
