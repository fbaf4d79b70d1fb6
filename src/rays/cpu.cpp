// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"

#include <algorithm>

#include "rays/project_simd.hpp"
#include "rays/rays.hpp"

namespace stereogrid {
namespace {

constexpr int rows_grain{8};

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
  cpu.for_ranges(cells.height, rows_grain, [&](int begin, int end) {
    project_ray_rows(sums, columns_max(space.height), geometry, grid, begin, end, cells);
  });
}

}  // namespace stereogrid
