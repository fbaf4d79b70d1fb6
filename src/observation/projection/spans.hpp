// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "clamped_to_int.hpp"
#include "observation/projection/projection.hpp"

namespace stereogrid {

/// Bins of the cells of a grid. Each call of visit(BinSpan) passes bins of one disparity.
class Spans {
 public:
  STEREOGRID_HD Spans(int width, int disparities, const BinGeometry& bins, const GridInVehicle& grid)
      : width_{width},
        disparities_{disparities},
        bins_{bins},
        grid_{grid},
        slopes_{grid.sin_yaw / grid.cos_yaw, -grid.cos_yaw / grid.sin_yaw},
        is_steep_{is_steep(grid.cos_yaw) || is_steep(grid.sin_yaw)} {}

  /// The cells of row iy one after the other: begin_cell(ix) before the bins of each.
  template <class BeginCell, class Visit>
  STEREOGRID_HD void row_by_overlap(int iy, const BeginCell& begin_cell, const Visit& visit) const {
    Corner low{corner(0, iy)};
    Corner high{corner(0, iy + 1)};
    for (int ix{0}; ix < grid_.grid.nx; ++ix) {
      const Corner next_low{corner(ix + 1, iy)};
      const Corner next_high{corner(ix + 1, iy + 1)};
      begin_cell(ix);
      overlap({low, next_low, next_high, high}, visit);
      low = next_low;
      high = next_high;
    }
  }

  /// One cell on its own.
  template <class Visit>
  STEREOGRID_HD void by_overlap(int ix, int iy, const Visit& visit) const {
    overlap({corner(ix, iy), corner(ix + 1, iy), corner(ix + 1, iy + 1), corner(ix, iy + 1)}, visit);
  }

 private:
  struct Corner {
    Point2 at;
    double column;
  };
  struct Cell {
    Corner corner[4];
  };

  // Edges so nearly across the view that their slope says too little; exactly across, none is ever cut.
  STEREOGRID_HD static bool is_steep(double part) { return part != 0 && std::abs(part) < 1e-3; }

  STEREOGRID_HD static int clamped(double value, int highest) {
    return clamped_to_int(std::clamp(value, -1.0, static_cast<double>(highest)));
  }

  [[nodiscard]] STEREOGRID_HD Corner corner(int ix, int iy) const {
    const GridGeometry& grid{grid_.grid};
    const Point2 at{grid_.to_vehicle(grid.x_min_m + ix * grid.cell_size_m, grid.y_min_m + iy * grid.cell_size_m)};
    return {at, bins_.column(at.x, at.y)};
  }

  // The columns that the span touches.
  template <class Visit>
  STEREOGRID_HD void visit_exactly(int d, const ColumnSpan& span, const Visit& visit) const {
    const int last{width_ - 1};
    int begin{std::max(clamped(std::floor(span.smallest - 1), last), 0)};
    int end{clamped(std::ceil(span.largest + 1), last)};
    while (begin <= end && !span.touches(begin)) ++begin;
    while (end >= begin && !span.touches(end)) --end;
    visit_columns(d, begin, end, visit);
  }

  template <class Visit>
  STEREOGRID_HD static void visit_columns(int d, int begin, int end, const Visit& visit) {
    if (begin > end) return;
    visit(BinSpan{static_cast<std::int16_t>(d), static_cast<std::int16_t>(begin), static_cast<std::int16_t>(end)});
  }

  template <class Visit>
  STEREOGRID_HD void overlap(const Cell& cell, const Visit& visit) const {
    const Corner* c{cell.corner};
    const double near{std::min(std::min(c[0].at.x, c[1].at.x), std::min(c[2].at.x, c[3].at.x))};
    if (!(near > 0)) return;
    const double leftmost{std::min(std::min(c[0].column, c[1].column), std::min(c[2].column, c[3].column))};
    const double rightmost{std::max(std::max(c[0].column, c[1].column), std::max(c[2].column, c[3].column))};
    if (rightmost < -1.5 || leftmost > width_ + 0.5) return;  // a pixel beyond what touches the image
    const double far{std::max(std::max(c[0].at.x, c[1].at.x), std::max(c[2].at.x, c[3].at.x))};
    int d{std::max(clamped(std::floor(bins_.disparity(far) - 1.5), disparities_ - 1), 0)};
    while (d < disparities_ && bins_.nearest_x(d) >= far) ++d;
    if (d >= disparities_) return;
    double x_far{bins_.farthest_x(d)};
    ColumnSpan at_far{cut(cell, x_far)};
    for (; d < disparities_ && x_far > near; ++d) {
      const double x_near{bins_.nearest_x(d)};
      const ColumnSpan at_near{cut(cell, x_near)};
      ColumnSpan span{std::min(at_far.smallest, at_near.smallest), std::max(at_far.largest, at_near.largest)};
      for (const Corner& one : cell.corner) {
        if (one.at.x >= x_near && one.at.x <= x_far) span.take(one.column);
      }
      visit_touched(cell, d, x_near, x_far, span, visit);
      x_far = x_near;  // the bins' depths follow each other without a gap
      at_far = at_near;
    }
  }

  // Columns in which the cell's edges pass the depth x, to a small fraction of a pixel.
  [[nodiscard]] STEREOGRID_HD ColumnSpan cut(const Cell& cell, double x) const {
    ColumnSpan span;
    const double scale{bins_.focal_px / x};
    for (int i{0}; i < 4; ++i) {
      const Point2 a{cell.corner[i].at};
      if ((a.x < x) == (cell.corner[(i + 1) % 4].at.x < x)) continue;
      span.take(bins_.cx_px - scale * (a.y + (x - a.x) * slopes_[i % 2]));
    }
    return span;
  }

  STEREOGRID_HD static bool is_close_to_whole(double value) { return std::abs(value - std::nearbyint(value)) < 1e-4; }

  // The bins whose columns u ± ½ the span touches. Where it ends so near to one of their borders that its small error
  // could decide, it is found again without.
  template <class Visit>
  STEREOGRID_HD void visit_touched(const Cell& cell, int d, double x_near, double x_far, const ColumnSpan& span,
                                   const Visit& visit) const {
    const double low{std::clamp(span.smallest - 0.5, -2.0, width_ + 1.0)};
    const double high{std::clamp(span.largest + 0.5, -2.0, width_ + 1.0)};
    const bool is_outside{low == high};
    if (is_outside && span.smallest <= span.largest) return;
    if (is_steep_ || is_close_to_whole(low) || is_close_to_whole(high)) {
      const CellCorners corners{{cell.corner[0].at, cell.corner[1].at, cell.corner[2].at, cell.corner[3].at}};
      const ColumnSpan exact{columns_of(bins_, corners, x_near, x_far)};
      return visit_exactly(d, exact, visit);
    }
    const int begin{clamped_to_int(std::floor(low)) + 1};
    const int end{clamped_to_int(std::ceil(high)) - 1};
    visit_columns(d, std::max(begin, 0), std::min(end, width_ - 1), visit);
  }

  int width_;
  int disparities_;
  const BinGeometry& bins_;
  const GridInVehicle& grid_;
  double slopes_[2];  // slopes of the edges along the grid's x and along its y
  bool is_steep_;
};

}  // namespace stereogrid
