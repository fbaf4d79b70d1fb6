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

/// What the velocities of a thing's points err by together.
constexpr double common_sigma_mps{0.3};
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

void measure(const std::vector<FlowVector>& vectors, Followed followed, std::vector<double>& values, Cluster& cluster) {
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
  const Symmetric2 covariance{inverted(sum.information)};
  cluster.velocity = sum.mean();
  cluster.velocity_sigma_mps = std::sqrt(std::max(covariance.xx, covariance.yy) + common_sigma_mps * common_sigma_mps);
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
    measure(vectors, {begin, end}, space.values, space.clusters[static_cast<std::size_t>(label)]);
    begin = end;
  }
}

}  // namespace stereogrid
