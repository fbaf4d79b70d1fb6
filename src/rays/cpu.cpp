// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"

#include <algorithm>

#include "rays/hidden.hpp"
#include "rays/project_simd.hpp"
#include "rays/rays.hpp"

namespace stereogrid {
namespace {

constexpr int rows_grain{8};

/// Columns of a grid of which it is asked together whether they are hidden, in rows_grain rows.
constexpr int tile_columns{16};

// Columns begin … end − 1: the counts of each bin.
void count_block(const Matches& matches, int begin, int end, const RaySpace& space, PackedRays* counts) {
  const UprightRange upright{space.upright};
  const int bins{space.bins};
  for (int v{0}; v < space.height; ++v) {
    const float* obstacle{matches.obstacle.row(v)};
    const float* road{matches.road.row(v)};
    const RayRow* rows{space.rows.data() + v + space.margin};
    for (int u{begin}; u < end; ++u) {
      PackedRays* const column{counts + ray_columns + (u - begin)};
      count_ray(obstacle[u], road[u], rows[-space.shift[static_cast<std::size_t>(u)]], upright, bins,
                [&](int bin, PackedRays rays) { column[bin * ray_columns] += rays; });
    }
  }
}

// Their sums over the bins; the counts are 0 again.
void sum_block(int begin, int end, PackedRays* counts, RaySpace& space) {
  PackedRays sums[ray_columns]{};
  for (int k{0}; k <= space.bins; ++k, counts += ray_columns) {
    for (int u{0}; u < ray_columns; ++u) {
      sums[u] += counts[u];
      counts[u] = 0;
    }
    std::copy_n(sums, end - begin, space.sums.row(k) + begin + 1);
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
                RaySpace& space) {
  space.place(rig, ground, config);
  const int blocks{(space.width + ray_columns - 1) / ray_columns};
  cpu.for_parts(blocks, static_cast<int>(space.counts.size()), [&](int part, int first, int last) {
    PackedRays* const counts{space.counts[static_cast<std::size_t>(part)].data()};
    for (int block{first}; block < last; ++block) {
      const int begin{block * ray_columns};
      const int end{std::min(begin + ray_columns, space.width)};
      count_block(matches, begin, end, space, counts);
      sum_block(begin, end, counts, space);
    }
  });
  cpu.for_ranges(space.bins + 1, rows_grain, [&](int begin, int end) {
    for (int k{begin}; k < end; ++k) {
      PackedRays* const sums{space.sums.row(k)};
      PackedRays sum{0};
      for (int u{1}; u <= space.width; ++u) sums[u] = sum += sums[u];
    }
  });
}

void project_rays(Cpu& cpu, const RaySpace& space, const BinGeometry& geometry, const GridInVehicle& grid,
                  View<float> cells) {
  const RaySums<Host> sums{space.sums.view()};
  const HiddenCells hidden{sums, geometry, grid};
  const int strips{(cells.height + rows_grain - 1) / rows_grain};
  cpu.for_ranges(strips, 1, [&](int begin, int end) {
    for (int strip{begin}; strip < end; ++strip) {
      const CellRange rows{0, strip * rows_grain, cells.width, std::min((strip + 1) * rows_grain, cells.height)};
      for_visible(hidden, rows, cells, [&](const CellRange& range) {
        project_ray_cells(sums, columns_max(space.height), geometry, grid, range, cells);
      });
    }
  });
}

}  // namespace stereogrid
