// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "baselines/columns.hpp"

namespace stereogrid::research {
namespace {

constexpr float impossible{1e9F};
constexpr int object_bins_per_px{2};
constexpr std::size_t classes{3};
// a pixel has no disparity with these probabilities, by class
constexpr std::array<double, classes> none_probability{0.085, 0.075, 0.09};

double cost_of(double probability) {
  return -std::log(probability);
}

/// −log of a Gaussian around the expected value, mixed with outliers spread over the whole range.
double pixel_cost(double off, double sigma, double outliers, double range, double none) {
  const double spread{(1 - none) * outliers / range};
  const double gaussian{std::exp(-0.5 * off * off / (sigma * sigma)) / (sigma * std::sqrt(2 * std::numbers::pi))};
  return cost_of(spread + (1 - none) * (1 - outliers) * gaussian);
}

/// Sums over rows 0 … i − 1 at [i].
using RowSums = std::vector<float>;

/// Costs of a stixel column; rows count from the bottom of the image, a row is row_px rows of pixels.
class ColumnCosts {
 public:
  ColumnCosts(const DisparityFrame& frame, const StixelParameters& parameters, const RoadModel& road, int first_u)
      : parameters_{parameters}, range_{static_cast<double>(frame.disparities)} {
    const int rows{frame.obstacle.height / parameters.row_px};
    const double centre_u{first_u + (parameters.column_px - 1) / 2.0};
    for (int row{0}; row < rows; ++row) {
      const int last_v{frame.obstacle.height - 1 - row * parameters.row_px};
      const int first_v{last_v - parameters.row_px + 1};
      disparity_.push_back(median_disparity(frame, first_u, parameters.column_px, first_v, last_v));
      road_.push_back(road.disparity(centre_u, (first_v + last_v) / 2.0));
    }
    const double per_rad{frame.rig.focal_px * frame.rig.baseline_m / frame.ground.height_m};
    ground_sigma_ = std::hypot(parameters.sigma_px, parameters.ground_sigma_rad * per_rad);
    focal_baseline_ = frame.rig.focal_px * frame.rig.baseline_m;
    sum_fixed_classes();
    sum_objects(frame.disparities * object_bins_per_px);
  }

  [[nodiscard]] int rows() const { return static_cast<int>(disparity_.size()); }
  [[nodiscard]] double road(int row) const { return road_[static_cast<std::size_t>(row)]; }
  [[nodiscard]] double depth_m(double disparity) const { return focal_baseline_ / std::max(disparity, 0.1); }

  [[nodiscard]] float ground(int first, int last) const { return difference(ground_, first, last); }
  [[nodiscard]] float sky(int first, int last) const { return difference(sky_, first, last); }
  [[nodiscard]] float object(int first, int last, double disparity) const {
    const auto bin{static_cast<std::size_t>(std::lround(disparity * object_bins_per_px))};
    return difference(objects_[std::min(bin, objects_.size() - 1)], first, last);
  }
  /// Mean of the rows' disparities; 0: none has any.
  [[nodiscard]] double mean(int first, int last) const {
    const float count{difference(counts_, first, last)};
    return count > 0 ? static_cast<double>(difference(disparities_, first, last) / count) : 0;
  }
  [[nodiscard]] double matched(int first, int last) const {
    return static_cast<double>(difference(counts_, first, last)) / (last - first + 1);
  }
  [[nodiscard]] double median_of(int first, int last) const {
    std::vector<double> found;
    for (int row{first}; row <= last; ++row) {
      if (disparity_[static_cast<std::size_t>(row)] > 0) found.push_back(disparity_[static_cast<std::size_t>(row)]);
    }
    return found.empty() ? 0 : median(found);
  }

 private:
  [[nodiscard]] static float difference(const RowSums& sums, int first, int last) {
    return sums[static_cast<std::size_t>(last) + 1] - sums[static_cast<std::size_t>(first)];
  }

  template <class Cost>
  [[nodiscard]] RowSums summed(const Cost& cost) const {
    RowSums sums(1, 0.0F);
    for (std::size_t row{0}; row < disparity_.size(); ++row)
      sums.push_back(sums.back() + static_cast<float>(cost(row)));
    return sums;
  }

  void sum_fixed_classes() {
    counts_ = summed([&](std::size_t row) { return disparity_[row] > 0 ? 1 : 0; });
    disparities_ = summed([&](std::size_t row) { return disparity_[row]; });
    // a row on the wrong side of the horizon costs more than any outlier
    constexpr double wrong_side{30};
    ground_ = summed([&](std::size_t row) {
      if (road_[row] < 0) return wrong_side;
      if (disparity_[row] <= 0) return cost_of(none_probability[0]);
      return pixel_cost(disparity_[row] - road_[row], ground_sigma_, parameters_.outlier_ground, range_,
                        none_probability[0]);
    });
    sky_ = summed([&](std::size_t row) {
      if (road_[row] > 1) return wrong_side;
      if (disparity_[row] <= 0) return cost_of(none_probability[2]);
      return pixel_cost(disparity_[row], parameters_.sigma_px, parameters_.outlier_sky, range_, none_probability[2]);
    });
  }

  void sum_objects(int bins) {
    const double far_off{pixel_cost(1e9, 1, parameters_.outlier_object, range_, none_probability[1])};
    const double none{cost_of(none_probability[1])};
    for (int bin{0}; bin < bins; ++bin) {
      const double d{static_cast<double>(bin) / object_bins_per_px};
      const double sigma{std::hypot(parameters_.sigma_px, d * d * parameters_.object_depth_m / focal_baseline_)};
      objects_.push_back(summed([&](std::size_t row) {
        if (disparity_[row] <= 0) return none;
        const double off{disparity_[row] - d};
        if (std::abs(off) > 6 * sigma) return far_off;
        return pixel_cost(off, sigma, parameters_.outlier_object, range_, none_probability[1]);
      }));
    }
  }

  const StixelParameters& parameters_;
  double range_;
  double ground_sigma_{0};
  double focal_baseline_{0};
  std::vector<double> disparity_;
  std::vector<double> road_;
  RowSums counts_, disparities_, ground_, sky_;
  std::vector<RowSums> objects_;  // by disparity
};

/// The best way to cut the rows up to here, the last piece being of one class.
struct Best {
  float cost{impossible};
  int first_row{0};
  StixelClass before{StixelClass::ground};
  double disparity{0};
};

/// Exact dynamic programming over (row, class).
class ColumnCutter {
 public:
  ColumnCutter(const ColumnCosts& costs, const StixelParameters& parameters)
      : costs_{costs},
        parameters_{parameters},
        ordered_{static_cast<float>(cost_of(1 - parameters.order))},
        disordered_{static_cast<float>(cost_of(parameters.order))},
        standing_{static_cast<float>(cost_of(1 - parameters.gravity - parameters.below_ground))},
        floating_{static_cast<float>(cost_of(parameters.gravity))},
        buried_{static_cast<float>(cost_of(parameters.below_ground))},
        best_(static_cast<std::size_t>(costs.rows())) {}

  [[nodiscard]] std::vector<Stixel> cut(int image_height) {
    for (int last{0}; last < costs_.rows(); ++last) {
      for (int first{0}; first <= last; ++first) extend(first, last);
    }
    return trace_back(image_height);
  }

 private:
  [[nodiscard]] Best& best(int row, StixelClass kind) {
    return best_[static_cast<std::size_t>(row)][static_cast<std::size_t>(kind)];
  }

  void extend(int first, int last) {
    consider(first, last, StixelClass::ground, costs_.ground(first, last), 0);
    consider(first, last, StixelClass::sky, costs_.sky(first, last), 0);
    const double d{costs_.mean(first, last)};
    if (d > 0) consider(first, last, StixelClass::object, costs_.object(first, last, d), d);
  }

  void consider(int first, int last, StixelClass kind, float data, double d) {
    Best& here{best(last, kind)};
    const auto cut{static_cast<float>(parameters_.cut)};
    if (first == 0) {
      if (kind != StixelClass::sky && data < here.cost) here = {data, 0, kind, d};
      return;
    }
    for (const StixelClass before : {StixelClass::ground, StixelClass::object, StixelClass::sky}) {
      const Best& below{best(first - 1, before)};
      if (below.cost + data + cut >= here.cost) continue;
      const float cost{below.cost + data + cut + prior(first, before, below.disparity, kind, d)};
      if (cost < here.cost) here = {cost, first, before, d};
    }
  }

  /// −log P(this piece, given the one below it).
  [[nodiscard]] float prior(int first, StixelClass before, double d_before, StixelClass kind, double d) const {
    constexpr double tolerance_px{2};
    if (kind != StixelClass::object) return kind == before || before == StixelClass::sky ? impossible : 0;
    const double road{costs_.road(first)};
    if (d < road - tolerance_px) return buried_;  // surfaces below the road are not visible
    if (before == StixelClass::ground) return d > road + tolerance_px ? floating_ : standing_;
    if (before == StixelClass::sky) return disordered_;
    return costs_.depth_m(d) > costs_.depth_m(d_before) + parameters_.gap_m ? ordered_ : disordered_;
  }

  [[nodiscard]] std::vector<Stixel> trace_back(int image_height) {
    std::vector<Stixel> pieces;
    int last{costs_.rows() - 1};
    StixelClass kind{StixelClass::ground};
    for (const StixelClass other : {StixelClass::object, StixelClass::sky}) {
      if (best(last, other).cost < best(last, kind).cost) kind = other;
    }
    while (last >= 0) {
      const Best& here{best(last, kind)};
      const int rows{parameters_.row_px};
      const double d{kind == StixelClass::object ? costs_.median_of(here.first_row, last) : 0};
      pieces.push_back({kind, image_height - (last + 1) * rows, image_height - 1 - here.first_row * rows, d,
                        costs_.matched(here.first_row, last)});
      kind = here.before;
      last = here.first_row - 1;
    }
    std::reverse(pieces.begin(), pieces.end());
    return pieces;
  }

  const ColumnCosts& costs_;
  const StixelParameters& parameters_;
  float ordered_, disordered_, standing_, floating_, buried_;
  std::vector<std::array<Best, classes>> best_;
};

/// Writes what the pieces of a column say about the disparities behind each other.
void paint(const std::vector<Stixel>& pieces, int u, const RoadModel& road, const StixelParameters& parameters,
           DisparityPlane& plane) {
  constexpr double matched_min{0.2};
  std::vector<double> obstacles;
  double nearest{0};
  double farthest_ground{0};
  for (const Stixel& piece : pieces) {
    if (piece.kind == StixelClass::ground && piece.matched >= matched_min) {
      const double far{std::max(0.5, road.disparity(u, piece.first_row))};
      plane.set(u, far, road.disparity(u, piece.last_row), parameters.between_free);
      farthest_ground = far;
    } else if (piece.kind == StixelClass::object && piece.disparity > 0.5) {
      const double top_m{road.height_m(u, piece.first_row, piece.disparity)};
      const double bottom_m{road.height_m(u, piece.last_row, piece.disparity)};
      if (top_m < parameters.height_min_m || bottom_m > parameters.height_max_m) continue;
      obstacles.push_back(piece.disparity);
      nearest = std::max(nearest, piece.disparity);
    }
  }
  const double free_to{obstacles.empty() ? farthest_ground : nearest};
  if (free_to > 0) plane.set(u, free_to, plane.disparity_max(), parameters.levels.free);
  const double half{0.5 - 0.5 / parameters.grid.bins_per_px};
  for (const double d : obstacles) plane.set(u, d - half, d + half, parameters.levels.occupied);
}

}  // namespace

std::vector<std::vector<Stixel>> stixels(const DisparityFrame& frame, const StixelParameters& parameters) {
  const RoadModel road{frame.rig, frame.ground};
  std::vector<std::vector<Stixel>> columns;
  for (int u{0}; u < frame.obstacle.width; u += parameters.column_px) {
    const ColumnCosts costs{frame, parameters, road, u};
    if (costs.rows() == 0) return {};
    columns.push_back(ColumnCutter{costs, parameters}.cut(frame.obstacle.height));
  }
  return columns;
}

Image<float> stixel_grid(const DisparityFrame& frame, const GridGeometry& grid, const StixelParameters& parameters) {
  const RoadModel road{frame.rig, frame.ground};
  DisparityPlane plane{frame, parameters.grid};
  const std::vector<std::vector<Stixel>> columns{stixels(frame, parameters)};
  for (std::size_t i{0}; i < columns.size(); ++i) {
    const int first_u{static_cast<int>(i) * parameters.column_px};
    for (int u{first_u}; u < std::min(first_u + parameters.column_px, frame.obstacle.width); ++u) {
      paint(columns[i], u, road, parameters, plane);
    }
  }
  return plane.to_cells(grid);
}

}  // namespace stereogrid::research
