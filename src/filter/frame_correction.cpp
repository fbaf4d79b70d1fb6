// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <utility>

#include "filter/filter.hpp"
#include "filter/resampling/resample_model.hpp"

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
/// Largest difference between occupancies that say the same.
constexpr float alike{0.05f};
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

// Cells that stay as they are: seen as free by both grids, or unknown in both. Without branches, for vectors.
bool are_kept(const float* seen, const float* occupancies) {
  int changes{0};
  for (int i{0}; i < cells_together; ++i) {
    const bool is_shown{is_known(seen[i])};
    changes |=
        (is_shown & ((seen[i] > 0.5f) | (occupancies[i] - seen[i] > alike))) | (!is_shown & is_known(occupancies[i]));
  }
  return changes == 0;
}

// True if both know the same of a cell, the frame more surely.
bool is_surer(float seen, float occupancy) {
  if (!is_known(seen) || !is_known(occupancy)) return false;
  return seen < 0.5f ? occupancy < 0.5f && occupancy - seen > alike : occupancy > 0.5f && seen - occupancy > alike;
}

class FrameCorrection {
 public:
  FrameCorrection(const Pose2& world_from_vehicle, bool is_widened, FrameResult& result)
      : observed_{std::as_const(result.observed).view()},
        window_{std::as_const(result.world.occupancy).view()},
        filtered_{result.vehicle},
        in_window_{places_in_window(grid_in_vehicle(filtered_.geometry, world_from_vehicle), result.world.geometry)},
        is_widened_{is_widened} {}

  void correct_row(int y) const {
    const float* const seen{observed_.row(y)};
    const float* const occupancies{filtered_.occupancy.row(y)};
    for (int first{0}; first < observed_.width; first += cells_together) {
      const int last{std::min(first + cells_together, observed_.width)};
      if (last - first == cells_together && are_kept(seen + first, occupancies + first)) continue;
      for (int x{first}; x < last; ++x) correct(x, y);
    }
  }

 private:
  void correct(int x, int y) const {
    const float seen{observed_(x, y)};
    float& occupancy{filtered_.occupancy(x, y)};
    float& moving{filtered_.moving(x, y)};
    const bool is_shown{is_known(seen)};
    if (!is_shown && !is_known(occupancy)) return;
    const bool is_free{is_shown && seen < 0.5f};
    if (!is_free && occupancy > 0.5f) {
      const float weighed{(is_shown ? factor_of_shown(x, y) : factor_of_hidden(x, y, occupancy)) * occupancy};
      occupancy = std::max(weighed / (weighed + 1 - occupancy), 0.5f);
    } else if (!is_free && (is_shown || moving > covered_min ||
                            (occupancy > uncertain_min && around(observed_, x, y).most > neighbour_min))) {
      occupancy = 0.5f;
    }
    if (is_surer(seen, occupancy)) occupancy = sharpened(x, y, seen, occupancy);
    moving = std::min(moving, occupancy);
  }

  // Factor of the odds of a cell that the frame shows as occupied.
  [[nodiscard]] float factor_of_shown(int x, int y) const {
    const float here{observed_(x, y)};
    const Around beside{around(observed_, x, y)};
    if (!is_widened_ || !(beside.most > here)) return 1;
    const bool is_border{beside.has_ground() && beside.most * (1 - here) > border_odds * here * (1 - beside.most)};
    return (is_border ? shown_at_border : 1) *
           (is_near_edge(observed_, x, y, filtered_.geometry.centre(x, y)) ? shown_at_near_edge : 1);
  }

  // The same of one that it does not show, with that occupancy, above ½.
  [[nodiscard]] float factor_of_hidden(int x, int y, float occupancy) const {
    if (!around(observed_, x, y).has_ground()) return occupancy > hidden_min ? hidden_inside : 1;
    const Point2 place{filtered_.geometry.centre(x, y)};
    return std::hypot(place.x, place.y) > leaving_m ? hidden_beside_ground : 1;
  }

  // A cell is interpolated between four cells of the window. The share of the three farther ones becomes the frame's,
  // within the range of the four.
  [[nodiscard]] float sharpened(int x, int y, float seen, float occupancy) const {
    const float place_x{in_window_.x_of(x, y) - 0.5f};
    const float place_y{in_window_.y_of(x, y) - 0.5f};
    const auto left = static_cast<int>(std::floor(place_x));
    const auto low = static_cast<int>(std::floor(place_y));
    const auto share_of_nearer = [](float share) { return std::max(share, 1 - share); };
    const float share{1 - share_of_nearer(place_x - static_cast<float>(left)) *
                              share_of_nearer(place_y - static_cast<float>(low))};
    float least{occupancy};
    float most{occupancy};
    for (const int iy : {low, low + 1}) {
      for (const int ix : {left, left + 1}) {
        const float here{window_(std::clamp(ix, 0, window_.width - 1), std::clamp(iy, 0, window_.height - 1))};
        least = std::min(least, here);
        most = std::max(most, here);
      }
    }
    return std::clamp(between(occupancy, seen, share), least, most);
  }

  View<const float> observed_;
  View<const float> window_;
  GridLayers& filtered_;
  CellPlaces in_window_;
  bool is_widened_;
};

}  // namespace

void correct_by_frame(const Pose2& world_from_vehicle, bool is_widened, int begin, int end, FrameResult& result) {
  const FrameCorrection correction{world_from_vehicle, is_widened, result};
  for (int y{begin}; y < end; ++y) correction.correct_row(y);
}

}  // namespace stereogrid
