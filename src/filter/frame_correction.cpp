// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "filter/filter.hpp"

namespace stereogrid {
namespace {

/// Factor of the odds of a cell that the frame does not show, with free ground beside it.
/// Chosen on B to E, odometry 04 and raw 0009, as those below: ratio of the true odds to the filter's.
constexpr float hidden_beside_ground{0.25f};
/// Distance from the vehicle's origin up to which that is 1, m: there, obstacles leave the image.
constexpr double leaving_m{6};
/// The same at the border of an obstacle that the frame shows: beside ground and a cell with more than border_odds
/// times its odds. Matching windows and noise widen obstacles by about a cell.
constexpr float shown_at_border{0.5f};
constexpr float border_odds{2};
/// The same at the near edge of an obstacle that the frame shows, also where no ground is seen before it. A neighbour
/// has greater odds. Errors of disparity spread the edge along the ray.
constexpr float shown_at_near_edge{0.55f};
/// Least occupancy of an obstacle's cell in the frame; number of cells before an edge on the ray that are none.
constexpr float obstacle_min{0.55f};
constexpr int cells_before{2};
/// The same in a cell that the frame does not show, without free ground beside it.
constexpr float hidden_inside{2.5f};
/// Least occupancy for that factor.
constexpr float hidden_min{0.6f};
/// Moving mass of a cell that a moving obstacle covers in part.
constexpr float covered_min{0.2f};
/// Least occupancy of a cell that the frame does not show, beside an obstacle that it shows, to be unknown …
constexpr float uncertain_min{0.2f};
/// … and of that obstacle in the frame.
constexpr float neighbour_min{0.6f};
constexpr int cells_together{16};

// The frame's cells around one, itself included.
struct Around {
  float least{1};
  float most{0};

  [[nodiscard]] bool has_ground() const { return is_known(least) && least < 0.5f; }
};

Around around(View<const float> observed, int x, int y) {
  Around cells;
  const int left{std::max(x - 1, 0)};
  const int right{std::min(x + 1, observed.width - 1)};
  for (const int ay : {std::max(y - 1, 0), y, std::min(y + 1, observed.height - 1)}) {
    const float* const row{observed.row(ay)};
    cells.least = std::min({cells.least, row[left], row[x], row[right]});
    cells.most = std::max({cells.most, row[left], row[x], row[right]});
  }
  return cells;
}

// True if the frame shows no obstacle in the cells before this one, on the ray from the vehicle's origin.
bool is_near_edge(View<const float> observed, int x, int y, Point2 place) {
  const double distance_m{std::max(std::hypot(place.x, place.y), 0.1)};
  for (int step{1}; step <= cells_before; ++step) {
    const int before_x{static_cast<int>(std::lround(x - step * place.x / distance_m))};
    const int before_y{static_cast<int>(std::lround(y - step * place.y / distance_m))};
    if (before_x < 0 || before_y < 0 || before_x >= observed.width || before_y >= observed.height) return true;
    if (observed(before_x, before_y) > obstacle_min) return false;
  }
  return true;
}

// Factor of the odds of a cell that the frame shows as occupied.
float factor_of_shown(View<const float> observed, int x, int y, Point2 place) {
  const float here{observed(x, y)};
  const Around beside{around(observed, x, y)};
  if (!(beside.most > here)) return 1;
  const bool is_border{beside.has_ground() && beside.most * (1 - here) > border_odds * here * (1 - beside.most)};
  return (is_border ? shown_at_border : 1) * (is_near_edge(observed, x, y, place) ? shown_at_near_edge : 1);
}

// The same of one that it does not show, with that occupancy, above ½.
float factor_of_hidden(Around around, float occupancy, Point2 place) {
  if (around.has_ground()) return std::hypot(place.x, place.y) > leaving_m ? hidden_beside_ground : 1;
  return occupancy > hidden_min ? hidden_inside : 1;
}

// Cells that stay as they are: seen as free, or unknown in both grids. Without branches, for vectors.
bool are_kept(const float* seen, const float* occupancies) {
  int changes{0};
  for (int i{0}; i < cells_together; ++i) {
    const bool is_shown{is_known(seen[i])};
    changes |= (is_shown & (seen[i] > 0.5f)) | (!is_shown & is_known(occupancies[i]));
  }
  return changes == 0;
}

void correct(View<const float> observed, int x, int y, GridLayers& filtered) {
  const float seen{observed(x, y)};
  float& occupancy{filtered.occupancy(x, y)};
  float& moving{filtered.moving(x, y)};
  const bool is_shown{is_known(seen)};
  if (is_shown ? seen < 0.5f : !is_known(occupancy)) return;
  if (occupancy > 0.5f) {
    const Point2 place{filtered.geometry.centre(x, y)};
    const float factor{is_shown ? factor_of_shown(observed, x, y, place)
                                : factor_of_hidden(around(observed, x, y), occupancy, place)};
    const float weighed{factor * occupancy};
    occupancy = std::max(weighed / (weighed + 1 - occupancy), 0.5f);
    moving = std::min(moving, occupancy);
  } else if (is_shown || moving > covered_min ||
             (occupancy > uncertain_min && around(observed, x, y).most > neighbour_min)) {
    occupancy = 0.5f;
  }
}

}  // namespace

void correct_by_frame(View<const float> observed, int begin, int end, GridLayers& filtered) {
  for (int y{begin}; y < end; ++y) {
    const float* const seen{observed.row(y)};
    const float* const occupancies{filtered.occupancy.row(y)};
    for (int first{0}; first < observed.width; first += cells_together) {
      const int last{std::min(first + cells_together, observed.width)};
      if (last - first == cells_together && are_kept(seen + first, occupancies + first)) continue;
      for (int x{first}; x < last; ++x) correct(observed, x, y, filtered);
    }
  }
}

}  // namespace stereogrid
