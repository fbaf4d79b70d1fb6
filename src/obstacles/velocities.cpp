// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <tuple>

#include "obstacles/clusters.hpp"

namespace stereogrid {
namespace {

/// What the velocities of a thing's points err by together …
constexpr double common_sigma_mps{0.2};
/// … along the ray, as all their disparities drift, in px/s …
constexpr double drift_pxps{0.2};
/// … and how the errors of any two of them correlate: the same motion of the camera, windows that overlap.
constexpr double correlation{0.2};
/// Where a pixel of disparity is worth more, disparities are too coarse to tell motion.
constexpr double coarse_m_per_px{5};
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
  // a disparity that errs by δ moves what lies at Z by Z²/(f·b)·δ along its ray
  const double distance_m{std::hypot(place.x, place.y)};
  const double per_px{distance_m / (rig.focal_px * rig.baseline_m)};  // of the distance
  if (distance_m * per_px > coarse_m_per_px) return;
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
  const double drift{drift_pxps * per_px};
  const Point2 along{drift * place.x, drift * place.y};
  cluster.velocity_covariance = {covariance.xx + along.x * along.x, covariance.xy + along.x * along.y,
                                 covariance.yy + along.y * along.y};
}

// Points of a segment that move, surely and all alike, beside others that stand.
class Movers {
 public:
  Movers(const std::vector<FlowVector>& vectors, Followed followed, std::vector<double>& values)
      : vectors_{vectors}, followed_{followed} {
    velocity_ = {middle(&Point2::x, values), middle(&Point2::y, values)};
  }

  [[nodiscard]] bool are_some() const {
    constexpr int each{3};
    int moving{0};
    int standing{0};
    int together{0};
    for (const auto& one : followed_) {
      standing += is_standing(one);
      if (!is_moving(one)) continue;
      ++moving;
      together += is_moving(*nearest(one.spot.u, one.spot.bin, &one));
    }
    // a few points of what moves are always followed wrongly
    return moving >= each && standing >= std::max(each, moving / 2) && 3 * together >= 2 * moving;
  }
  /// The nearest point that says anything is one of them.
  [[nodiscard]] bool has(const SegmentNode& node) const { return is_moving(*nearest(node.u, node.bin, nullptr)); }

 private:
  using One = ClusterSpace::Followed;

  // A bin of half a pixel is as far as so many columns.
  static constexpr int columns_of_a_bin{4};

  [[nodiscard]] double excess(const One& one, Point2 velocity) const {
    const FlowVector& vector{vectors_[one.vector]};
    const Symmetric2 covariance{widened(vector.velocity_covariance, common_sigma_mps * common_sigma_mps)};
    return squared(inverted(covariance), {vector.velocity.x - velocity.x, vector.velocity.y - velocity.y});
  }
  [[nodiscard]] bool is_standing(const One& one) const { return excess(one, {}) < outlier; }
  [[nodiscard]] bool is_moving(const One& one) const { return !is_standing(one) && excess(one, velocity_) < outlier; }
  // Of the points that do not stand.
  [[nodiscard]] double middle(double Point2::*axis, std::vector<double>& values) const {
    values.clear();
    for (const auto& one : followed_) {
      if (!is_standing(one)) values.push_back(vectors_[one.vector].velocity.*axis);
    }
    if (values.empty()) return 0;
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), at, values.end());
    return *at;
  }
  // Of those that say anything, without `other`.
  [[nodiscard]] const One* nearest(int u, int bin, const One* other) const {
    const One* found{&followed_[0]};
    int least{std::numeric_limits<int>::max()};
    for (const auto& one : followed_) {
      const int away_u{one.spot.u - u};
      const int away_bins{columns_of_a_bin * (one.spot.bin - bin)};
      const int distance{away_u * away_u + away_bins * away_bins};
      if (&one == other || distance >= least || !(is_standing(one) || is_moving(one))) continue;
      least = distance;
      found = &one;
    }
    return found;
  }

  const std::vector<FlowVector>& vectors_;
  Followed followed_;
  Point2 velocity_;
};

// Those that are seen on a segment, by segment.
void find_followed(const std::vector<FlowVector>& vectors, const Pose2& world_from_vehicle, ClusterSpace& space) {
  const Pose2 vehicle_from_world{inverse(world_from_vehicle)};
  space.followed.clear();
  for (std::size_t i{0}; i < vectors.size(); ++i) {
    const Point2 place{vehicle_from_world * vectors[i].place};
    const int label{space.segmenter.segment_at(place)};
    if (label >= 0) space.followed.push_back({label, i, space.segmenter.spot_of(place)});
  }
  std::sort(space.followed.begin(), space.followed.end(),
            [](const auto& a, const auto& b) { return std::tie(a.label, a.vector) < std::tie(b.label, b.vector); });
}

// work(segment, points) for each segment that has some.
template <class Work>
void for_segments(Followed followed, const Work& work) {
  for (auto begin = followed.begin(); begin != followed.end();) {
    const int label{begin->label};
    const auto end = std::find_if(begin, followed.end(), [&](const auto& one) { return one.label != label; });
    work(static_cast<std::size_t>(label), Followed{begin, end});
    begin = end;
  }
}

}  // namespace

void separate_movers(const std::vector<FlowVector>& vectors, const Pose2& world_from_vehicle, ClusterSpace& space) {
  find_followed(vectors, world_from_vehicle, space);
  for_segments(space.followed, [&](std::size_t segment, Followed followed) {
    const Movers movers{vectors, followed, space.values};
    if (!movers.are_some()) return;
    space.segmenter.split(segment, [&](const SegmentNode& node) { return !movers.has(node); });
  });
}

void measure_velocities(const std::vector<FlowVector>& vectors, const Pose2& world_from_vehicle, ClusterSpace& space) {
  find_followed(vectors, world_from_vehicle, space);
  for_segments(space.followed, [&](std::size_t segment, Followed followed) {
    const Point2& at{vectors[followed[0].vector].place};
    measure(vectors, followed, space.rig, {at.x - world_from_vehicle.x_m, at.y - world_from_vehicle.y_m}, space.values,
            space.clusters[segment]);
  });
}

}  // namespace stereogrid
