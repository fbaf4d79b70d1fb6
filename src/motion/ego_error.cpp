// SPDX-License-Identifier: Apache-2.0
#include "motion/ego_error.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace stereogrid {
namespace {

/// Standard deviations of an unmeasured error. Scale: features of recorded drives and their poses differ by 0 to 4 %,
/// in the worst drive by 6 to 10 %. Offset: odometry fits to the same drives have 0.1 to 0.4 px, the worst one 1 px.
constexpr double scale_sigma{0.05};
constexpr double offset_sigma_px{0.5};
/// Time constant of the measurements' decay: the scale of poses changes within seconds.
constexpr double lasts_s{2};
/// Number of frames whose velocities are computed from the same place (SceneFlow::remembered).
constexpr double frames_of_a_place{6};
/// Sectors of the view, each with one vote: the median of its features. One object covers few of them.
constexpr double sector_rad{5 * M_PI / 180};
constexpr std::ptrdiff_t features_of_a_sector{3};
constexpr int sectors_min{4};
/// In standard deviations; faster features are of moving objects.
constexpr double gate{3};

InformationSum prior() {
  return {{1 / (scale_sigma * scale_sigma), 0, 1 / (offset_sigma_px * offset_sigma_px)}, {}};
}

double product_of(Point2 a, Point2 b) {
  return a.x * b.x + a.y * b.y;
}

Symmetric2 outer(double factor, Point2 p) {
  return {factor * p.x * p.x, factor * p.x * p.y, factor * p.y * p.y};
}

}  // namespace

EgoError::EgoError(const Rig& rig, std::size_t points_reserved)
    : focal_baseline_pxm_{rig.focal_px * rig.baseline_m}, sum_{prior()} {
  samples_.reserve(points_reserved);
}

// An offset δ of the disparity d makes a depth too large by the share δ/d, and its change by 2δ/d.
Point2 EgoError::slope_at(const Motion& motion, Point2 place) const {
  const Point2 away{place.x - motion.place.x, place.y - motion.place.y};
  return {motion.speed_mps, -2 * product_of(motion.direction, away) / focal_baseline_pxm_ * motion.speed_mps};
}

void EgoError::take_samples(const Motion& motion, std::span<const FlowVector> vectors) {
  const Symmetric2 covariance{inverted(sum_.information)};
  const Point2 error{sum_.mean()};
  const Point2 side{-motion.direction.y, motion.direction.x};
  samples_.clear();
  for (const FlowVector& vector : vectors) {
    const Point2 away{vector.place.x - motion.place.x, vector.place.y - motion.place.y};
    const Point2 slope{slope_at(motion, vector.place)};
    const double variance{squared(vector.velocity_covariance, motion.direction)};
    const double misfit_mps{product_of(motion.direction, vector.velocity) - product_of(slope, error)};
    if (!(misfit_mps * misfit_mps <= gate * gate * (variance + squared(covariance, slope)))) continue;
    const double bearing_rad{std::atan2(product_of(side, away), product_of(motion.direction, away))};
    samples_.push_back({static_cast<int>(std::floor(bearing_rad / sector_rad)), misfit_mps, variance, slope});
  }
  std::sort(samples_.begin(), samples_.end(), [](const Sample& a, const Sample& b) {
    return std::tie(a.sector, a.misfit_mps) < std::tie(b.sector, b.misfit_mps);
  });
}

void EgoError::measure() {
  const Point2 error{sum_.mean()};
  InformationSum frame;
  int sectors{0};
  for (auto begin = samples_.begin(); begin != samples_.end();) {
    const auto end =
        std::find_if(begin, samples_.end(), [&](const Sample& one) { return one.sector != begin->sector; });
    if (end - begin >= features_of_a_sector) {
      const Sample& middle{*(begin + (end - begin) / 2)};
      const double information{1 / (frames_of_a_place * middle.variance)};
      const double measured_mps{middle.misfit_mps + product_of(middle.slope, error)};
      frame.information = frame.information + outer(information, middle.slope);
      frame.weighted.x += information * measured_mps * middle.slope.x;
      frame.weighted.y += information * measured_mps * middle.slope.y;
      ++sectors;
    }
    begin = end;
  }
  if (sectors >= sectors_min) sum_.add(frame);
}

void EgoError::correct(Point2 vehicle, double dt_s, std::vector<FlowVector>& vectors) {
  const Point2 moved{before_ ? Point2{vehicle.x - before_->x, vehicle.y - before_->y} : Point2{}};
  const double moved_m{std::hypot(moved.x, moved.y)};
  before_ = vehicle;
  if (!(moved_m > 0) || !(dt_s > 0)) return;
  const Motion motion{vehicle, {moved.x / moved_m, moved.y / moved_m}, moved_m / dt_s};
  const double kept{std::exp(-dt_s / lasts_s)};
  InformationSum decayed;
  decayed.add(sum_, kept);
  decayed.add(prior(), 1 - kept);
  sum_ = decayed;
  take_samples(motion, vectors);
  measure();
  const Symmetric2 covariance{inverted(sum_.information)};
  const Point2 error{sum_.mean()};
  for (FlowVector& vector : vectors) {
    const Point2 slope{slope_at(motion, vector.place)};
    const double seeming_mps{product_of(slope, error)};
    vector.velocity.x -= seeming_mps * motion.direction.x;
    vector.velocity.y -= seeming_mps * motion.direction.y;
    vector.common_covariance = outer(squared(covariance, slope), motion.direction);
  }
}

}  // namespace stereogrid
