// SPDX-License-Identifier: Apache-2.0
#include "obstacles/tracking/motion_state.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stereogrid {
namespace {

// Yaw rate of an unobserved object: standard deviation, and time constant of its decay.
constexpr double yaw_rate_sigma_radps{0.3};
constexpr double yaw_rate_lasts_s{6};
/// In standard deviations.
constexpr double sure_from{2};

constexpr double unbounded{std::numeric_limits<double>::infinity()};
/// Standard deviations of a disparity and of a surface's end in the image, px; and a constant part.
constexpr double disparity_sigma_px{0.3};
constexpr double column_sigma_px{3};
constexpr double least_sigma_m{0.05};
/// Maximum distance of points that belong to a side.
constexpr double side_m{0.1};
/// Share of the width in the image, at an end that is cut off.
constexpr double cut_share{0.55};
/// A face that is seen at a smaller angle (its sine) does not show where it ends, …
constexpr double least_sine{0.25};
/// … minimum depth, assumed if less is seen.
constexpr double assumed_m{0.65};
/// Minimum standard deviation of an extent.
constexpr double assumed_sigma_m{0.1};
/// Share of the difference between size and observation that is corrected in a frame.
constexpr double following{0.3};
/// Rate for the hidden far side of dynamic things: their first observations are too deep, because errors lie along the
/// rays.
constexpr double hidden_shrinking{0.1};

double dot(Point2 a, Point2 b) {
  return a.x * b.x + a.y * b.y;
}

/// Extent of an outline along an axis, and the camera's position on it.
struct Extent {
  double least{unbounded};
  double most{-unbounded};
  double camera{0};

  /// Distance of the camera beside it.
  [[nodiscard]] double beside_m() const { return std::max({least - camera, camera - most, 0.0}); }
};

class Viewer {
 public:
  Viewer(const Cluster& cluster, const std::array<Point2, 2>& axes, const Pose2& camera, const Rig& rig)
      : cluster_{cluster},
        axes_{axes},
        place_{camera.x_m, camera.y_m},
        vehicle_from_world_{inverse(camera)},
        rig_{rig} {
    for (std::size_t axis{0}; axis < 2; ++axis) {
      Extent& extent{extents_[axis]};
      extent.camera = dot(axes[axis], place_);
      for (const Point2& point : cluster.outline) {
        extent.least = std::min(extent.least, dot(axes[axis], point));
        extent.most = std::max(extent.most, dot(axes[axis], point));
      }
    }
    for (const Point2& point : cluster.outline) {
      leftmost_ = std::max(leftmost_, slope_of(point));
      rightmost_ = std::min(rightmost_, slope_of(point));
    }
  }

  [[nodiscard]] BoxSide side(std::size_t axis, std::size_t end) const {
    const Extent& extent{extents_[axis]};
    const double at{end == 0 ? extent.least : extent.most};
    const Point2* corner{nullptr};
    for (const Point2& point : cluster_.outline) {
      if (std::abs(dot(axes_[axis], point) - at) > side_m || is_cut(point)) continue;
      if (corner == nullptr || away(point) < away(*corner)) corner = &point;
    }
    const bool is_behind{end == 0 ? extent.camera > extent.most : extent.camera < extent.least};
    if (corner == nullptr) return {at, unbounded, !is_behind};
    const double sigma{sigma_at(*corner, axes_[axis])};
    if (!is_behind) return {at, sigma, true};
    const bool is_shown{extents_[1 - axis].beside_m() > least_sine * away(*corner) &&
                        extent.most - extent.least > assumed_m + 2 * sigma};
    return {at, is_shown ? sigma : unbounded, false};
  }

 private:
  [[nodiscard]] double away(Point2 point) const { return std::hypot(point.x - place_.x, point.y - place_.y); }
  // To the left.
  [[nodiscard]] double slope_of(Point2 point) const {
    const Point2 here{vehicle_from_world_ * point};
    return here.y / std::max(here.x, 0.1);
  }
  [[nodiscard]] bool is_cut(Point2 point) const {
    const double slope{slope_of(point)};
    const double margin{cut_share * (leftmost_ - rightmost_)};
    return (cluster_.is_cut_left && slope > leftmost_ - margin) ||
           (cluster_.is_cut_right && slope < rightmost_ + margin);
  }
  [[nodiscard]] double sigma_at(Point2 point, Point2 axis) const {
    const double distance_m{std::max(away(point), 0.1)};
    const double along{dot(axis, {(point.x - place_.x) / distance_m, (point.y - place_.y) / distance_m})};
    const double depth_m{disparity_sigma_px * distance_m * distance_m / (rig_.focal_px * rig_.baseline_m)};
    const double to_side_m{column_sigma_px * distance_m / rig_.focal_px};
    return std::sqrt(along * along * depth_m * depth_m + (1 - along * along) * to_side_m * to_side_m +
                     least_sigma_m * least_sigma_m);
  }

  const Cluster& cluster_;
  const std::array<Point2, 2>& axes_;
  Point2 place_;
  Pose2 vehicle_from_world_;
  const Rig& rig_;
  std::array<Extent, 2> extents_;
  double leftmost_{-unbounded};
  double rightmost_{unbounded};
};

}  // namespace

MotionState::MotionState(Point2 place, double place_variance, Point2 velocity, const Symmetric2& velocity_covariance)
    : mean_{place.x, place.y, velocity.x, velocity.y, 0} {
  const auto set = [this](std::size_t row, std::size_t column, double value) {
    covariance_[row * size + column] = covariance_[column * size + row] = value;
  };
  set(0, 0, place_variance);
  set(1, 1, place_variance);
  set(2, 2, velocity_covariance.xx);
  set(2, 3, velocity_covariance.xy);
  set(3, 3, velocity_covariance.yy);
  set(4, 4, yaw_rate_sigma_radps * yaw_rate_sigma_radps);
}

double MotionState::yaw_rate_radps() const {
  return std::abs(mean_[4]) > sure_from * std::sqrt(at(4, 4)) ? mean_[4] : 0;
}

void MotionState::predict(double dt_s, double acceleration_mps2) {
  const double turned_rad{yaw_rate_radps() * dt_s};
  const double c{std::cos(turned_rad)};
  const double s{std::sin(turned_rad)};
  const Point2 before{velocity()};
  const Point2 after{c * before.x - s * before.y, s * before.x + c * before.y};
  const double kept{std::exp(-dt_s / yaw_rate_lasts_s)};
  const double half_s{dt_s / 2};
  mean_ = {mean_[0] + half_s * (before.x + after.x), mean_[1] + half_s * (before.y + after.y), after.x, after.y,
           kept * mean_[4]};
  const std::array<Vector, size> f{
      Vector{1, 0, half_s * (1 + c), -half_s * s, -dt_s * half_s * after.y},
      Vector{0, 1, half_s * s, half_s * (1 + c), dt_s * half_s * after.x},
      Vector{0, 0, c, -s, -dt_s * after.y},
      Vector{0, 0, s, c, dt_s * after.x},
      Vector{0, 0, 0, 0, kept},
  };
  std::array<double, size * size> moved{};  // f · covariance
  std::array<double, size * size> result{};
  for (std::size_t i{0}; i < size * size; ++i) {
    for (std::size_t k{0}; k < size; ++k) moved[i] += f[i / size][k] * at(k, i % size);
  }
  for (std::size_t i{0}; i < size * size; ++i) {
    for (std::size_t k{0}; k < size; ++k) result[i] += moved[i / size * size + k] * f[i % size][k];
  }
  covariance_ = result;
  const double q{acceleration_mps2 * acceleration_mps2 * dt_s * dt_s};
  for (std::size_t axis{0}; axis < 2; ++axis) {
    covariance_[axis * (size + 1)] += q * dt_s * dt_s / 4;
    covariance_[axis * (size + 1) + 2] += q * dt_s / 2;
    covariance_[axis * (size + 1) + 2 * size] += q * dt_s / 2;
    covariance_[(axis + 2) * (size + 1)] += q;
  }
  covariance_[4 * (size + 1)] += (1 - kept * kept) * yaw_rate_sigma_radps * yaw_rate_sigma_radps;
}

void MotionState::measure(std::size_t first, Point2 direction, double measured, double variance) {
  Vector column{};
  for (std::size_t i{0}; i < size; ++i) column[i] = at(i, first) * direction.x + at(i, first + 1) * direction.y;
  const double spread{column[first] * direction.x + column[first + 1] * direction.y + variance};
  if (!(spread > 0)) return;  // known already, as surely as it is measured
  const double innovation{measured - mean_[first] * direction.x - mean_[first + 1] * direction.y};
  for (std::size_t i{0}; i < size; ++i) mean_[i] += column[i] / spread * innovation;
  for (std::size_t i{0}; i < size * size; ++i) covariance_[i] -= column[i / size] * column[i % size] / spread;
}

// Along the axes of the covariance, in which the measurement errors are independent.
void MotionState::measure_velocity(const Point2& velocity, const Symmetric2& covariance) {
  const Point2 along{principal_direction(covariance)};
  for (const Point2 axis : {along, Point2{-along.y, along.x}}) {
    measure(2, axis, velocity.x * axis.x + velocity.y * axis.y, squared(covariance, axis));
  }
}

void MotionState::stand_still() {
  mean_[2] = mean_[3] = mean_[4] = 0;
}

bool BoxSide::is_seen() const {
  return sigma_m < unbounded;
}

BoxView::BoxView(const Cluster& cluster, double yaw_rad, const Pose2& camera, const Rig& rig)
    : axes{Point2{std::cos(yaw_rad), std::sin(yaw_rad)}, Point2{-std::sin(yaw_rad), std::cos(yaw_rad)}} {
  const Viewer viewer{cluster, axes, camera, rig};
  for (std::size_t axis{0}; axis < 2; ++axis) sides[axis] = {viewer.side(axis, 0), viewer.side(axis, 1)};
}

double BoxView::face_sigma_m() const {
  double sigma{unbounded};
  for (const BoxSide& side : sides[1]) {
    if (side.is_near) sigma = std::min(sigma, side.sigma_m);
  }
  return sigma;
}

void TrackedBox::begin(const BoxView& view, double yaw, Point2 place) {
  yaw_rad = yaw;
  for (std::size_t axis{0}; axis < 2; ++axis) {
    for (std::size_t end{0}; end < 2; ++end) {
      reach_m[axis][end] = view.sides[axis][end].at_m - dot(view.axes[axis], place);
      sigma_m[axis][end] = view.sides[axis][end].sigma_m;
    }
  }
}

// Updates the sides. The visible side fixes the place; the others follow their observation: growth at once, shrinking
// slowly, and not where they may be hidden.
void TrackedBox::update(const BoxView& view, Point2 place) {
  for (std::size_t axis{0}; axis < 2; ++axis) {
    const std::array<BoxSide, 2>& sides{view.sides[axis]};
    const double from{dot(view.axes[axis], place)};
    const double larger{sides[1].at_m - sides[0].at_m - extent_m(axis)};
    const bool both{sides[0].is_near && sides[1].is_near && sides[0].is_seen() && sides[1].is_seen()};
    for (std::size_t end{0}; end < 2; ++end) {
      const double outwards{end == 0 ? -1.0 : 1.0};
      const double farther{outwards * (sides[end].at_m - from - reach_m[axis][end])};
      double taken{0};
      if (both) {
        taken = 0.5 * larger * following;
      } else if (!sides[end].is_near || !sides[end].is_seen()) {
        taken = farther * (farther > 0 || sides[end].is_seen() ? following : axis == 1 ? hidden_shrinking : 0);
      }
      reach_m[axis][end] += outwards * taken;
      if (sides[end].is_seen() || farther > side_m) sigma_m[axis][end] = sides[end].sigma_m;
    }
  }
}

Point2 TrackedBox::middle() const {
  const double along{(reach_m[0][0] + reach_m[0][1]) / 2};
  const double across{(reach_m[1][0] + reach_m[1][1]) / 2};
  const double c{std::cos(yaw_rad)};
  const double s{std::sin(yaw_rad)};
  return {c * along - s * across, s * along + c * across};
}

double TrackedBox::extent_sigma_m(std::size_t axis) const {
  // not of three: with an unbounded one, libstdc++ says NaN
  return std::hypot(std::hypot(sigma_m[axis][0], sigma_m[axis][1]), assumed_sigma_m);
}

}  // namespace stereogrid
