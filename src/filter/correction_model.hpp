// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "filter/resampling/resample_model.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

/// Corrects cells of the vehicle's filtered grid by what the frame shows around each of them. docs/method.md §8.8.
template <class Space>
struct FrameCorrection {
  View<const float, Space> observed;  ///< the frame, in the vehicle's grid
  View<const float, Space> window;    ///< filtered occupancy of the window
  GridInVehicle vehicle;              ///< the vehicle's grid in the vehicle frame
  CellPlaces in_window;               ///< its cells in those of the window
  bool is_widened;                    ///< matching windows have widened the frame's obstacles

  /// Factor of the odds of a cell that the frame does not show, with free ground beside it.
  /// Chosen on B to E, odometry 04 and raw 0009, as those below: ratio of the true odds to the filter's.
  static constexpr float hidden_beside_ground{0.25f};
  /// Distance from the vehicle's origin up to which that is 1, m: there, obstacles leave the image.
  static constexpr double leaving_m{6};
  /// The same at the border of an obstacle that the frame shows: beside ground and a cell with more than border_odds
  /// times its odds. Matching windows and noise widen obstacles by about a cell.
  static constexpr float shown_at_border{0.5f};
  static constexpr float border_odds{2};
  /// The same at the near edge of an obstacle that the frame shows, also where no ground is seen before it. A neighbour
  /// has greater odds. Errors of disparity spread the edge along the ray.
  static constexpr float shown_at_near_edge{0.55f};
  /// Least occupancy of an obstacle's cell in the frame; number of cells before an edge on the ray that are none.
  static constexpr float obstacle_min{0.55f};
  static constexpr int cells_before{2};
  /// The same in a cell that the frame does not show, without free ground beside it.
  static constexpr float hidden_inside{2.5f};
  /// Least occupancy for that factor.
  static constexpr float hidden_min{0.6f};
  /// Moving mass of a cell that a moving obstacle covers in part.
  static constexpr float covered_min{0.2f};
  /// Least occupancy of a cell that the frame does not show, beside an obstacle that it shows, to be unknown …
  static constexpr float uncertain_min{0.2f};
  /// … and of that obstacle in the frame.
  static constexpr float neighbour_min{0.6f};
  /// Largest difference between occupancies that say the same.
  static constexpr float alike{0.05f};

  /// False: seen as free by both grids, or unknown in both. Such a cell stays as it is. Without branches, for vectors.
  [[nodiscard]] STEREOGRID_HD static bool may_change(float seen, float occupancy) {
    const bool is_shown{is_known(seen)};
    return (is_shown & ((seen > 0.5f) | (occupancy - seen > alike))) | (!is_shown & is_known(occupancy));
  }

  STEREOGRID_HD void correct(int x, int y, float& occupancy, float& moving) const {
    const float seen{observed(x, y)};
    if (!may_change(seen, occupancy)) return;
    const bool is_shown{is_known(seen)};
    const bool is_free{is_shown && seen < 0.5f};
    if (!is_free && occupancy > 0.5f) {
      const float weighed{(is_shown ? factor_of_shown(x, y) : factor_of_hidden(x, y, occupancy)) * occupancy};
      occupancy = Max(weighed / (weighed + 1 - occupancy), 0.5f);
    } else if (!is_free &&
               (is_shown || moving > covered_min || (occupancy > uncertain_min && around(x, y).most > neighbour_min))) {
      occupancy = 0.5f;
    }
    if (is_surer(seen, occupancy)) occupancy = sharpened(x, y, seen, occupancy);
    moving = Min(moving, occupancy);
  }

 private:
  /// The frame's cells around one, itself included.
  struct Around {
    float least{1};
    float most{0};

    [[nodiscard]] STEREOGRID_HD bool has_ground() const { return is_known(least) && least < 0.5f; }
  };

  [[nodiscard]] STEREOGRID_HD Around around(int x, int y) const {
    Around cells;
    const int right{Min(x + 1, observed.width - 1)};
    const int top{Min(y + 1, observed.height - 1)};
    for (int ay{Max(y - 1, 0)}; ay <= top; ++ay) {
      const float* const row{observed.row(ay)};
      for (int ax{Max(x - 1, 0)}; ax <= right; ++ax) {
        cells.least = Min(cells.least, row[ax]);
        cells.most = Max(cells.most, row[ax]);
      }
    }
    return cells;
  }

  /// From the vehicle's origin, m. Not std::hypot, whose last digit is the library's.
  [[nodiscard]] STEREOGRID_HD static double distance_m(Point2 place) {
    return std::sqrt(place.x * place.x + place.y * place.y);
  }

  /// True if the frame shows no obstacle in the cells before this one, on the ray from the vehicle's origin.
  [[nodiscard]] STEREOGRID_HD bool is_near_edge(int x, int y) const {
    const Point2 place{vehicle.centre(x, y)};
    const double away_m{distance_m(place)};
    const double length_m{away_m > 0.1 ? away_m : 0.1};
    for (int step{1}; step <= cells_before; ++step) {
      const int before_x{static_cast<int>(std::lround(x - step * place.x / length_m))};
      const int before_y{static_cast<int>(std::lround(y - step * place.y / length_m))};
      if (before_x < 0 || before_y < 0 || before_x >= observed.width || before_y >= observed.height) return true;
      if (observed(before_x, before_y) > obstacle_min) return false;
    }
    return true;
  }

  /// True if both know the same of a cell, the frame more surely.
  [[nodiscard]] STEREOGRID_HD static bool is_surer(float seen, float occupancy) {
    if (!is_known(seen) || !is_known(occupancy)) return false;
    return seen < 0.5f ? occupancy < 0.5f && occupancy - seen > alike : occupancy > 0.5f && seen - occupancy > alike;
  }

  /// Factor of the odds of a cell that the frame shows as occupied.
  [[nodiscard]] STEREOGRID_HD float factor_of_shown(int x, int y) const {
    const float here{observed(x, y)};
    const Around beside{around(x, y)};
    if (!is_widened || !(beside.most > here)) return 1;
    const bool is_border{beside.has_ground() && beside.most * (1 - here) > border_odds * here * (1 - beside.most)};
    return (is_border ? shown_at_border : 1) * (is_near_edge(x, y) ? shown_at_near_edge : 1);
  }

  /// The same of one that it does not show, with that occupancy, above ½.
  [[nodiscard]] STEREOGRID_HD float factor_of_hidden(int x, int y, float occupancy) const {
    if (!around(x, y).has_ground()) return occupancy > hidden_min ? hidden_inside : 1;
    return distance_m(vehicle.centre(x, y)) > leaving_m ? hidden_beside_ground : 1;
  }

  /// A cell is interpolated between four cells of the window. The share of the three farther ones becomes the frame's,
  /// within the range of the four.
  [[nodiscard]] STEREOGRID_HD float sharpened(int x, int y, float seen, float occupancy) const {
    const float place_x{in_window.x_of(x, y) - 0.5f};
    const float place_y{in_window.y_of(x, y) - 0.5f};
    const auto left = static_cast<int>(floorf(place_x));
    const auto low = static_cast<int>(floorf(place_y));
    const float aside{place_x - static_cast<float>(left)};
    const float up{place_y - static_cast<float>(low)};
    const float share{1 - Max(aside, 1 - aside) * Max(up, 1 - up)};
    float least{occupancy};
    float most{occupancy};
    for (int iy{low}; iy <= low + 1; ++iy) {
      for (int ix{left}; ix <= left + 1; ++ix) {
        const float here{window(Min(Max(ix, 0), window.width - 1), Min(Max(iy, 0), window.height - 1))};
        least = Min(least, here);
        most = Max(most, here);
      }
    }
    return Min(Max(between(occupancy, seen, share), least), most);
  }
};

}  // namespace stereogrid
