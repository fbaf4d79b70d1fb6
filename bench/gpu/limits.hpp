// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/cuda.hpp"

namespace stereogrid::bench {

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
