// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/cuda.hpp"

namespace stereogrid::bench {

/// What this card can do at best, measured.
struct Limits {
  double copy_gb_per_s;    ///< read and written within the device's memory
  double upload_gb_per_s;  ///< from pinned memory
  double download_gb_per_s;
  double add_per_s;   ///< 32-bit integer additions
  double popc_per_s;  ///< bits of a 32-bit word counted
  double launch_us;   ///< of an empty kernel in a graph, and waiting for it
  double node_us;     ///< of each further kernel of a graph, from the end of the one before
  double marked_us;   ///< of an empty kernel between two marks of time
};

Limits measure_limits(Cuda& cuda);

}  // namespace stereogrid::bench
