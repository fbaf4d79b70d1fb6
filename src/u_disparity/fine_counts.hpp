// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "held_bytes.hpp"
#include "matching/matches.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/result.hpp"
#include "u_disparity/rows.hpp"

namespace stereogrid {

/// N_V and N_O of some columns where bins are finer than a pixel: a disparity between two bins belongs to both by how
/// near it is to them. Plain code: only `bins_per_px` above 1 pays for it.
class FineCounts {
 public:
  static constexpr int columns{16};  ///< at a time: those of a cache line

  explicit FineCounts(int bins);

  /// Fills the columns, at most `columns`, of N_V and N_O in `stages` and of the bins with road in `has_road`.
  void count(const Matches& matches, const BinRows& rows, const UDisparityConfig& config, ColumnRange range,
             StageImages& stages, Image<std::uint8_t>& has_road);

  [[nodiscard]] std::size_t held_bytes() const { return held_bytes_of(visible_, observed_); }

 private:
  using Changes = std::array<std::int32_t, columns>;

  void add_pixel(const Matches& matches, const BinRows& rows, const UDisparityConfig& config, int u, int v, int column);
  void total(ColumnRange range, StageImages& stages);

  std::vector<Changes> visible_;   // [bin] rays of this bin that the one before has not, in parts of parts
  std::vector<Changes> observed_;  // [bin] likewise
};

}  // namespace stereogrid
