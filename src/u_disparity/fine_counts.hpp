// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "matching/matches.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/pipeline.hpp"
#include "u_disparity/rows.hpp"

namespace stereogrid {

/// N_V and N_O of one column where bins are finer than a pixel: a disparity between two bins belongs to both by how
/// near it is to them. One column after the other, in plain code: only `bins_per_px` above 1 pays for it.
class FineCounts {
 public:
  explicit FineCounts(int bins);

  /// Fills column u of N_V and N_O in `stages` and of the bins with road in `has_road`.
  void count(const Matches& matches, const BinRows& rows, const UDisparityConfig& config, int u, StageImages& stages,
             Image<std::uint8_t>& has_road);

 private:
  void add_pixel(const Matches& matches, const UDisparityConfig& config, int u, int v, BinRange bins, BinRange upright);

  std::vector<std::int32_t> visible_;   // [bin] rays of this bin that the one before has not, in parts of parts
  std::vector<std::int32_t> observed_;  // [bin] likewise
};

}  // namespace stereogrid
