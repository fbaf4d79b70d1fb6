// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <tuple>

#include "obstacles/tracking.hpp"

namespace stereogrid {
namespace {

/// What the velocities of a thing's points err by together …
constexpr double common_sigma_mps{0.2};
/// … along the ray, as all their disparities drift, in px/s …
constexpr double drift_pxps{0.2};
/// … and how the errors of any two of them correlate: the same motion of the camera, windows that overlap.
constexpr double correlation{0.2};
/// Squared Mahalanobis distance from the median.
constexpr double outlier{9};
constexpr std::size_t points_min{2};
using Followed = std::span<const ClusterSpace::Followed>;

double median_along(double Point2::*axis, const std::vector<FlowVector>& vectors, Followed followed,
                    std::vector<double>& values) {
  values.clear();
  for (const auto& one : followed) values.push_back(vectors[one.vector].velocity.*axis);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Of the points of one cluster, which lie at about `place` from the camera. World axes.
void measure(const std::vector<FlowVector>& vectors, Followed followed, const Rig& rig, Point2 place,
             std::vector<double>& values, Cluster& cluster) {
  const Point2 middle{median_along(&Point2::x, vectors, followed, values),
                      median_along(&Point2::y, vectors, followed, values)};
  InformationSum sum;
  std::size_t agreeing{0};
  for (const auto& one : followed) {
    const FlowVector& vector{vectors[one.vector]};
    const Symmetric2 information{inverted(vector.velocity_covariance)};
    const Point2 away{vector.velocity.x - middle.x, vector.velocity.y - middle.y};
    if (squared(information, away) > outlier) continue;
    sum.add({information, vector.velocity});
    ++agreeing;
  }
  if (agreeing < points_min) return;
  cluster.velocity = sum.mean();
  const double shared{1 + correlation * static_cast<double>(agreeing - 1)};
  const Symmetric2 covariance{widened(shared * inverted(sum.information), common_sigma_mps * common_sigma_mps)};
  // a disparity that errs by δ moves what lies at Z by Z²/(f·b)·δ along its ray
  const double per_px{drift_pxps * std::hypot(place.x, place.y) / (rig.focal_px * rig.baseline_m)};
  const Point2 along{per_px * place.x, per_px * place.y};
  cluster.velocity_covariance = {covariance.xx + along.x * along.x, covariance.xy + along.x * along.y,
                                 covariance.yy + along.y * along.y};
}

}  // namespace

void measure_velocities(const std::vector<FlowVector>& vectors, const Pose2& world_from_vehicle, ClusterSpace& space) {
  const Pose2 vehicle_from_world{inverse(world_from_vehicle)};
  space.followed.clear();
  for (std::size_t i{0}; i < vectors.size(); ++i) {
    const int label{space.segmenter.segment_at(vehicle_from_world * vectors[i].place)};
    if (label >= 0) space.followed.push_back({label, i});
  }
  std::sort(space.followed.begin(), space.followed.end(),
            [](const auto& a, const auto& b) { return std::tie(a.label, a.vector) < std::tie(b.label, b.vector); });
  for (auto begin = space.followed.cbegin(); begin != space.followed.cend();) {
    const int label{begin->label};
    const auto end = std::find_if(begin, space.followed.cend(), [&](const auto& one) { return one.label != label; });
    const Point2& at{vectors[begin->vector].place};
    measure(vectors, {begin, end}, space.rig, {at.x - world_from_vehicle.x_m, at.y - world_from_vehicle.y_m},
            space.values, space.clusters[static_cast<std::size_t>(label)]);
    begin = end;
  }
}

}  // namespace stereogrid
