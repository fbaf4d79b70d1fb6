// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "clamped_to_int.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

/// Whole cells by which the window has moved since the step before.
struct Scroll {
  int x;
  int y;
};

/// World-aligned window that covers a vehicle-frame grid in every heading. Its origin is a whole number of cells.
class Window {
 public:
  explicit Window(const GridGeometry& vehicle_grid);

  /// Number of cells along a side.
  [[nodiscard]] int cells() const { return cells_; }
  /// Geometry of the window for a pose of the car.
  [[nodiscard]] GridGeometry at(const Pose2& world_from_vehicle) const;

 private:
  double cell_size_m_;
  double ahead_m_;
  double aside_m_;
  int cells_;
};

inline Window::Window(const GridGeometry& grid)
    : cell_size_m_{grid.cell_size_m},
      ahead_m_{grid.x_min_m + grid.nx * grid.cell_size_m / 2},
      aside_m_{grid.y_min_m + grid.ny * grid.cell_size_m / 2},
      cells_{static_cast<int>(std::ceil(std::hypot(grid.nx, grid.ny))) + 4} {}

inline GridGeometry Window::at(const Pose2& world_from_vehicle) const {
  const Point2 centre{world_from_vehicle * Point2{ahead_m_, aside_m_}};
  const int half{cells_ / 2};
  const double first_x{std::floor(centre.x / cell_size_m_) - half};
  const double first_y{std::floor(centre.y / cell_size_m_) - half};
  return {first_x * cell_size_m_, first_y * cell_size_m_, cell_size_m_, cells_, cells_};
}

/// From one place of the window to the next.
inline Scroll scroll_between(const GridGeometry& before, const GridGeometry& now) {
  return {clamped_to_int(std::round((now.x_min_m - before.x_min_m) / now.cell_size_m)),
          clamped_to_int(std::round((now.y_min_m - before.y_min_m) / now.cell_size_m))};
}

/// Moves the cells of a window; new ones are `fresh`.
template <class T>
void scroll_cells(Scroll scroll, Image<T>& cells, const T& fresh = {}) {
  if (scroll.x == 0 && scroll.y == 0) return;
  const int x{std::clamp(scroll.x, -cells.width(), cells.width())};
  const int y{std::clamp(scroll.y, -cells.height(), cells.height())};
  for (int i{0}; i < cells.height(); ++i) {
    const int iy{y > 0 ? i : cells.height() - 1 - i};  // a row that others still need is not overwritten
    T* const row{cells.row(iy)};
    T* const end{row + cells.width()};
    if (iy + y < 0 || iy + y >= cells.height()) {
      std::fill(row, end, fresh);
      continue;
    }
    const T* const from{cells.row(iy + y)};
    if (x > 0) {
      std::fill(std::copy(from + x, from + cells.width(), row), end, fresh);
    } else {
      std::fill(row, std::copy_backward(from, from + cells.width() + x, end), fresh);
    }
  }
}

/// Number of neighbours in a row that are tested together.
constexpr int group_cells{16};

/// True if test(i) is for a cell of the group from `first` on. Without branches, for vectors.
template <class Test>
[[nodiscard]] bool any_of_group(int first, const Test& test) {
  int found{0};
  for (int i{first}; i < first + group_cells; ++i) found |= static_cast<int>(test(i));
  return found != 0;
}

/// Calls work(i) for the cells of a row, but not for those of groups with may_skip(first).
template <class MaySkip, class Work>
void for_groups(int cells, const MaySkip& may_skip, const Work& work) {
  for (int first{0}; first < cells; first += group_cells) {
    const int end{std::min(first + group_cells, cells)};
    if (end - first == group_cells && may_skip(first)) continue;
    for (int i{first}; i < end; ++i) work(i);
  }
}

}  // namespace stereogrid
