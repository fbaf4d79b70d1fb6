// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/road_plane.hpp"
#include "memory_bytes.hpp"
#include "observation/u_disparity/model.hpp"
#include "stereogrid/config.hpp"

namespace stereogrid {

/// Rows between two heights above the road at disparity d, in the column u0; the image may end before. eq. 9.
RowRange rows_between(const Rig& rig, const Ground& ground, double lower_m, double upper_m, double d);

/// Rows from the road up to `obstacle_height_m` that are in the image: S_P(d) of eq. 9.
RowRange possible_rows(const Rig& rig, const Ground& ground, double obstacle_height_m, double d, int image_height);

/// Columns begin … end − 1.
struct ColumnRange {
  int begin;
  int end;
};

/// Which rows belong to which bins. With roll the road tilts in the image and the rows of a bin with it: in column u
/// they lie `shift[u]` lower than in the column u0.
struct BinRows {
  BinRows(int width, int height, int bins);

  /// For the road of a frame. `shift` stays 0 unless the configuration follows the roll.
  void place(const Rig& rig, const Ground& ground, const UDisparityConfig& config);

  /// Cuts the columns into blocks with one shift, of at most `widest` columns.
  void cut(int widest);
  /// Bins that the pixels of column u lie in the rows of, from row 0 on.
  [[nodiscard]] const BinRange* bins(int u) const { return bins_of_row.data() + first_row(u); }
  /// Bins in which they are high enough above the road to be part of an obstacle.
  [[nodiscard]] const BinRange* upright_bins(int u) const { return upright_bins_of_row.data() + first_row(u); }

  [[nodiscard]] std::size_t memory_bytes() const {
    return memory_bytes_of(shift, rows, upright_rows, bins_of_row, upright_bins_of_row, blocks);
  }

  int height;
  int margin;                                 ///< rows that a column may be shifted by
  std::vector<std::int32_t> shift;            ///< (W)
  std::vector<RowRange> rows;                 ///< (D) in the column u0, the image may end before
  std::vector<RowRange> upright_rows;         ///< (D) likewise, above the least height of an obstacle
  std::vector<BinRange> bins_of_row;          ///< (height + 2·margin), from row −margin on
  std::vector<BinRange> upright_bins_of_row;  ///< likewise
  std::vector<ColumnRange> blocks;

 private:
  [[nodiscard]] int first_row(int u) const { return margin - shift[static_cast<std::size_t>(u)]; }
};

}  // namespace stereogrid
