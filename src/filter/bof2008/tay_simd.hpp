// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "filter/filter.hpp"

namespace stereogrid {

constexpr int tile_columns{256};
constexpr int tile_rows{4};

/// Cells that are worked on together: their masses stay in the cache from prediction to update.
struct LatticeTile {
  const FilterStep& step;
  const FilterTables& tables;
  const FilterState& before;
  FilterState& after;  ///< its working memory describes `before`
  Scroll scroll;
  int x_begin;  ///< up to tile_columns columns
  int x_end;
  int y_begin;  ///< up to tile_rows rows
  int y_end;

  [[nodiscard]] int columns() const { return x_end - x_begin; }
};

/// VelocitySums of the cells in a tile's row.
struct TileSums {
  float mass[tile_columns];
  float x[tile_columns];
  float y[tile_columns];
  float xx[tile_columns];
  float xy[tile_columns];
  float yy[tile_columns];

  [[nodiscard]] VelocitySums at(int column) const {
    return {mass[column], x[column], y[column], xx[column], xy[column], yy[column]};
  }
};

/// tay2008's prediction and likelihood: `after.velocity` gets l(k), not yet normalised; the rest, for a row of the
/// tile.
struct TayRow {
  float likelihood_occupied[tile_columns];  ///< given
  float likelihood_empty[tile_columns];     ///< given
  float evidence[tile_columns];             ///< Σ l(k)
  float standing[tile_columns];             ///< β_occ of standstill
  TileSums sums;                            ///< over β_occ(k)
};
void predict_tay(const LatticeTile& tile, TayRow* rows);

/// P(v_k) of row y; `scale`: of each of the tile's columns.
void normalise(const LatticeTile& tile, int y, const float* scale);

}  // namespace stereogrid
