// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"

#include <numeric>

#include "observation/rays/rays.hpp"
#include "observation/rays/simd.hpp"

namespace stereogrid {
namespace {

constexpr int rows_grain{8};

/// Columns of a grid that are tested together for being hidden, in rows_grain rows.
constexpr int tile_columns{16};

/// Bins of which a thread sums over all columns.
constexpr int sum_bins{32};

// Bins begin … end − 1.
void sum_columns(int begin, int end, RayWorkspace& space) {
  for (int u{1}; u <= space.width; ++u) {
    const PackedRays* const before{space.sums.row(u - 1)};
    PackedRays* const sums{space.sums.row(u)};
    for (int k{begin}; k < end; ++k) sums[k] += before[k];
  }
}

// Calls work(range) for the tiles of some rows that are not hidden, neighbours together; the others become ½.
template <class Work>
void for_visible(const HiddenCells& hidden, const CellRange& rows, View<float> cells, const Work& work) {
  CellRange visible{rows.x_begin, rows.y_begin, rows.x_begin, rows.y_end};
  for (int x{rows.x_begin}; x < rows.x_end; x += tile_columns) {
    const int end{std::min(x + tile_columns, rows.x_end)};
    if (!hidden.are_hidden(x, rows.y_begin, end - 1, rows.y_end - 1)) {
      visible.x_end = end;
      continue;
    }
    if (visible.x_begin < visible.x_end) work(visible);
    visible.x_begin = visible.x_end = end;
    for (int y{rows.y_begin}; y < rows.y_end; ++y) std::fill(cells.row(y) + x, cells.row(y) + end, 0.5f);
  }
  if (visible.x_begin < visible.x_end) work(visible);
}

}  // namespace

void count_rays(Cpu& cpu, const Matches& matches, const Rig& rig, const Ground& ground, const UDisparityConfig& config,
                RayWorkspace& space) {
  space.place(rig, ground, config);
  const int blocks{(space.width + ray_block_columns - 1) / ray_block_columns};
  cpu.for_ranges(blocks, 1, [&](int first, int last) {
    for (int block{first}; block < last; ++block) {
      const int begin{block * ray_block_columns};
      const int end{std::min(begin + ray_block_columns, space.width)};
      const AmbiguousPixels ambiguous{count_ray_block(matches, begin, end, space)};
      for (int u{begin}; u < end; ++u) {
        std::partial_sum(space.sums.row(u + 1), space.sums.row(u + 1) + space.bins + 1, space.sums.row(u + 1));
        if (ambiguous[static_cast<std::size_t>(u - begin)] >= least_ambiguous) space.stop_at_pattern(matches, u);
      }
    }
  });
  cpu.for_ranges(space.bins + 1, sum_bins, [&](int begin, int end) { sum_columns(begin, end, space); });
}

void project_rays(Cpu& cpu, const RayWorkspace& space, const BinGeometry& geometry, const GridInVehicle& grid,
                  View<float> cells) {
  const RaySums<Host> sums{space.sums.view()};
  const HiddenCells hidden{sums, geometry, grid};
  const CellsInView in_view{geometry, grid, space.blur_px};
  const int strips{(cells.height + rows_grain - 1) / rows_grain};
  cpu.for_ranges(strips, 1, [&](int begin, int end) {
    for (int strip{begin}; strip < end; ++strip) {
      const CellRange rows{0, strip * rows_grain, cells.width, std::min((strip + 1) * rows_grain, cells.height)};
      for_visible(hidden, rows, cells, [&](const CellRange& range) {
        project_ray_cells(sums, columns_max(space.height), in_view, range, cells);
      });
    }
  });
}

}  // namespace stereogrid
