// SPDX-FileCopyrightText: 2026 The stereogrid authors
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
/// The same in a cell that the frame does not show, without free ground beside it.
constexpr float hidden_inside{2.5f};
/// Least occupancy for that factor.
constexpr float hidden_min{0.6f};
/// Moving mass of a cell that a moving obstacle covers in part.
constexpr float covered_min{0.2f};
/// Least occupancy of a cell that the frame does not show, beside an obstacle that it shows, to be unknown …
constexpr float doubtful_min{0.2f};
/// … and of that obstacle in the frame.
constexpr float neighbour_min{0.6f};

// The frame's cells around one, itself included.
struct Around {
  float least{1};
  float most{0};

  [[nodiscard]] bool has_ground() const { return is_known(least) && least < 0.5f; }
};

Around around(View<const float> observed, int x, int y) {
  Around cells;
  for (int ay{std::max(y - 1, 0)}; ay <= std::min(y + 1, observed.height - 1); ++ay) {
    for (int ax{std::max(x - 1, 0)}; ax <= std::min(x + 1, observed.width - 1); ++ax) {
      cells.least = std::min(cells.least, observed(ax, ay));
      cells.most = std::max(cells.most, observed(ax, ay));
    }
  }
  return cells;
}

// Factor of the odds of a cell with that occupancy, above ½.
float factor_of(float observed, Around around, float occupancy, Point2 place) {
  if (is_known(observed)) {
    const bool is_border{around.has_ground() &&
                         around.most * (1 - observed) > border_odds * observed * (1 - around.most)};
    return is_border ? shown_at_border : 1;
  }
  if (around.has_ground()) return std::hypot(place.x, place.y) > leaving_m ? hidden_beside_ground : 1;
  return occupancy > hidden_min ? hidden_inside : 1;
}

}  // namespace

void correct_by_frame(View<const float> observed, int begin, int end, GridLayers& filtered) {
  for (int y{begin}; y < end; ++y) {
    const float* const seen{observed.row(y)};
    float* const occupancies{filtered.occupancy.row(y)};
    float* const movings{filtered.moving.row(y)};
    for (int x{0}; x < observed.width; ++x) {
      float& occupancy{occupancies[x]};
      const bool is_shown{is_known(seen[x])};
      if (is_shown ? seen[x] < 0.5f : !is_known(occupancy)) continue;
      if (occupancy > 0.5f) {
        const Point2 place{filtered.geometry.centre(x, y)};
        const float weighed{factor_of(seen[x], around(observed, x, y), occupancy, place) * occupancy};
        occupancy = std::max(weighed / (weighed + 1 - occupancy), 0.5f);
        movings[x] = std::min(movings[x], occupancy);
      } else if (is_shown || movings[x] > covered_min ||
                 (occupancy > doubtful_min && around(observed, x, y).most > neighbour_min)) {
        occupancy = 0.5f;
      }
    }
  }
}

}  // namespace stereogrid
