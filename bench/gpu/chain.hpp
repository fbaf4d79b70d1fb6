// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "backend/cuda.hpp"
#include "stereogrid/config.hpp"

namespace stereogrid::bench {

struct Case {
  int width;
  int height;
  int disparities;
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

/// Measured limits of this card.
struct Limits {
  double copy_gb_per_s;    ///< read and written within the device's memory
  double upload_gb_per_s;  ///< from pinned memory
  double download_gb_per_s;
  double add_per_s;   ///< 32-bit integer additions
  double popc_per_s;  ///< bits of a 32-bit word counted
  double launch_us;   ///< empty kernel in a graph, including the wait
  double node_us;     ///< each further kernel of a graph, from the end of the one before
  double marked_us;   ///< empty kernel between two time marks
};

Limits measure_limits(Cuda& cuda);

}  // namespace stereogrid::bench
