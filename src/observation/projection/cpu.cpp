// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"

#include "clamped_to_int.hpp"
#include "observation/projection/projection.hpp"
#include "observation/projection/spans.hpp"

namespace stereogrid {
namespace {

constexpr int rows_grain{4};

float larger(float a, float b) {
  return a > b ? a : b;
}

// Row d of each level, from the level before.
void find_largest(View<const float> occupancy, int d, ProjectionWorkspace& space) {
  const float* before{occupancy.row(d)};
  for (int k{0}; k < ProjectionWorkspace::levels; ++k) {
    float* row{space.largest[static_cast<std::size_t>(k)].row(d)};
    const int apart{1 << k};
    for (int u{0}; u + 2 * apart <= occupancy.width; ++u) row[u] = larger(before[u], before[u + apart]);
    before = row;
  }
}

// Largest occupancy of many columns from that of 1, 2, 4 or 8 at a time; the last ones overlap.
class Largest {
 public:
  Largest(View<const float> occupancy, const ProjectionWorkspace& space) : width_{occupancy.width} {
    level_[0] = occupancy.row(0);
    for (std::size_t k{0}; k < space.largest.size(); ++k) level_[k + 1] = space.largest[k].data();
  }

  [[nodiscard]] float of(const BinSpan& span) const {
    const int columns{span.end - span.begin + 1};
    const int k{columns >= 8 ? 3 : columns >= 4 ? 2 : columns >= 2 ? 1 : 0};
    const int step{1 << k};
    const float* row{level_[k] + static_cast<std::ptrdiff_t>(width_) * span.d};
    const int last{span.end + 1 - step};
    float highest{row[last]};
    for (int u{span.begin}; u < last; u += step) highest = larger(row[u], highest);
    return highest;
  }

 private:
  int width_;
  const float* level_[ProjectionWorkspace::levels + 1];
};

bool is_same(const GridInVehicle& a, const GridInVehicle& b) {
  return a.grid == b.grid && a.x_m == b.x_m && a.y_m == b.y_m && a.cos_yaw == b.cos_yaw && a.sin_yaw == b.sin_yaw;
}

void project_planned(const Largest& largest, const ProjectionWorkspace& space, int iy, View<float> cells) {
  const std::size_t* first{space.first_span.data() + static_cast<std::ptrdiff_t>(iy) * cells.width};
  for (int ix{0}; ix < cells.width; ++ix) {
    float highest{-1};
    for (std::size_t i{first[ix]}; i < first[ix + 1]; ++i) highest = larger(largest.of(space.spans[i]), highest);
    cells(ix, iy) = highest < 0 ? 0.5f : highest;
  }
}

void project_row(const Largest& largest, const Spans& spans, int iy, View<float> cells) {
  std::fill(cells.row(iy), cells.row(iy) + cells.width, -1.0f);
  float* cell{cells.row(iy)};
  const auto begin_cell = [&](int ix) { cell = cells.row(iy) + ix; };
  const auto take = [&](const BinSpan& span) { *cell = larger(largest.of(span), *cell); };
  spans.row_by_overlap(iy, begin_cell, take);
  for (int ix{0}; ix < cells.width; ++ix) cells(ix, iy) = cells(ix, iy) < 0 ? 0.5f : cells(ix, iy);
}

}  // namespace

void project(Cpu& cpu, View<const float> occupancy, const BinGeometry& bins, const GridInVehicle& grid,
             ProjectionWorkspace& space, View<float> cells) {
  cpu.for_ranges(occupancy.height, rows_grain, [&](int begin, int end) {
    for (int d{begin}; d < end; ++d) find_largest(occupancy, d, space);
  });
  const Largest largest{occupancy, space};
  const bool is_planned{!space.first_span.empty() && is_same(grid, space.planned)};
  const Spans spans{occupancy.width, occupancy.height, bins, grid};
  cpu.for_ranges(cells.height, rows_grain, [&](int begin, int end) {
    for (int iy{begin}; iy < end; ++iy) {
      is_planned ? project_planned(largest, space, iy, cells) : project_row(largest, spans, iy, cells);
    }
  });
}

}  // namespace stereogrid
