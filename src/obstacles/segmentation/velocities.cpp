// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <tuple>

#include "obstacles/segmentation/clusters.hpp"

namespace stereogrid {
namespace {

/// Common velocity error of an object's features along the ray: drift of all disparities, px/s, and a constant part …
constexpr double drift_pxps{0.35};
constexpr double ray_sigma_mps{0.1};
/// … and correlation of the individual errors along the ray, from overlapping windows.
constexpr double correlation{0.05};
/// Common velocity error across the ray: constant part, error of the camera's yaw rate, and factor of individual
/// errors.
constexpr double side_sigma_mps{0.06};
constexpr double turning_sigma_radps{0.01};
constexpr double side_of_points{0.4};
/// With fewer features, one false track cannot be separated from the others.
constexpr std::size_t enough_features{5};
constexpr double few_sigma_mps{0.3};
/// Maximum depth change per px of disparity; beyond it, disparities do not resolve motion.
constexpr double coarse_m_per_px{5};
/// Squared Mahalanobis distance from the median.
constexpr double outlier{9};
constexpr std::size_t points_min{2};
using Followed = std::span<const ClusterWorkspace::Followed>;
using Motion = ClusterWorkspace::Motion;

// Median velocity of the features for which `counts(feature)` is true; 0: none.
template <class Counts>
Point2 median_velocity(const std::vector<FlowVector>& vectors, Followed followed, std::vector<double>& values,
                       const Counts& counts) {
  const auto along = [&](double Point2::*axis) {
    values.clear();
    for (const auto& one : followed) {
      if (counts(one)) values.push_back(vectors[one.vector].velocity.*axis);
    }
    if (values.empty()) return 0.0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  };
  return {along(&Point2::x), along(&Point2::y)};
}

// Covariance of the mean velocity of `n` features at about `place` from the camera. `of_points`: covariance with
// independent errors. Fitted to the errors of static and dynamic objects, rendered and real, by distance and `n`.
Symmetric2 covariance_of_mean(const Symmetric2& of_points, std::size_t n, Point2 place, double drift_mps) {
  const double distance_m{std::hypot(place.x, place.y)};
  const Point2 ray{place.x / distance_m, place.y / distance_m};
  const double turning_mps{turning_sigma_radps * distance_m};
  const double common_mps{n < enough_features ? few_sigma_mps : 0};
  const double along_ray{(1 + correlation * static_cast<double>(n - 1)) * squared(of_points, ray) +
                         ray_sigma_mps * ray_sigma_mps + drift_mps * drift_mps + common_mps * common_mps};
  const double to_side{side_of_points * side_of_points * squared(of_points, {-ray.y, ray.x}) +
                       side_sigma_mps * side_sigma_mps + turning_mps * turning_mps + common_mps * common_mps};
  return {along_ray * ray.x * ray.x + to_side * ray.y * ray.y, (along_ray - to_side) * ray.x * ray.y,
          along_ray * ray.y * ray.y + to_side * ray.x * ray.x};
}

// Sets the velocity of a cluster with features at about `place` from the camera, world axes.
void measure(const std::vector<FlowVector>& vectors, Followed followed, const Rig& rig, Point2 place,
             std::vector<double>& values, Cluster& cluster) {
  // a disparity error δ moves a point at Z by Z²/(f·b)·δ along its ray
  const double distance_m{std::hypot(place.x, place.y)};
  const double per_px{distance_m / (rig.focal_px * rig.baseline_m)};  // relative to the distance
  if (distance_m * per_px > coarse_m_per_px) return;
  const Point2 middle{median_velocity(vectors, followed, values, [](const auto&) { return true; })};
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
  const Symmetric2 of_points{inverted(sum.information)};
  cluster.velocity_covariance = covariance_of_mean(of_points, agreeing, place, drift_pxps * per_px * distance_m) +
                                vectors[followed[0].vector].common_covariance;
}

// Squared Mahalanobis distance of a point's velocity from another.
double distance(const FlowVector& vector, Point2 velocity) {
  constexpr double common_sigma_mps{0.2};  // features of a rigid object do not agree better
  const Symmetric2 own{widened(vector.velocity_covariance, common_sigma_mps * common_sigma_mps)};
  const Symmetric2 covariance{own + vector.common_covariance};
  return squared(inverted(covariance), {vector.velocity.x - velocity.x, vector.velocity.y - velocity.y});
}

// Classifies the features of one segment: static, or certainly dynamic with one common velocity.
void log_motion(const std::vector<FlowVector>& vectors, std::span<ClusterWorkspace::Followed> followed,
                std::vector<double>& values) {
  for (auto& one : followed) {
    if (distance(vectors[one.vector], {}) < outlier) one.motion = Motion::stands;
  }
  const Point2 middle{
      median_velocity(vectors, followed, values, [](const auto& one) { return one.motion != Motion::stands; })};
  for (auto& one : followed) {
    if (one.motion != Motion::stands && distance(vectors[one.vector], middle) < outlier) one.motion = Motion::moves;
  }
}

// True if the nearest classified feature but `other` moves.
bool moves_at(Segmenter::Spot spot, Followed followed, const ClusterWorkspace::Followed* other = nullptr) {
  constexpr int columns_of_a_bin{4};  // columns that equal a bin of half a pixel in distance
  Motion motion{Motion::unknown};
  int least{std::numeric_limits<int>::max()};
  for (const auto& one : followed) {
    const int away_u{one.spot.u - spot.u};
    const int away_bins{columns_of_a_bin * (one.spot.bin - spot.bin)};
    const int away{away_u * away_u + away_bins * away_bins};
    if (&one == other || away >= least || one.motion == Motion::unknown) continue;
    least = away;
    motion = one.motion;
  }
  return motion == Motion::moves;
}

// True if a dynamic object is beside a static one.
bool are_two(Followed followed) {
  constexpr std::ptrdiff_t each{3};
  const auto count = [&](Motion motion) {
    return std::count_if(followed.begin(), followed.end(), [&](const auto& one) { return one.motion == motion; });
  };
  const auto moving = count(Motion::moves);
  const auto together = std::count_if(followed.begin(), followed.end(), [&](const auto& one) {
    return one.motion == Motion::moves && moves_at(one.spot, followed, &one);
  });
  // dynamic objects always have a few false tracks
  return moving >= each && count(Motion::stands) >= std::max(each, moving / 2) && 3 * together >= 2 * moving;
}

// Assigns features to segments, sorted by segment.
void find_followed(const std::vector<FlowVector>& vectors, const Pose2& world_from_vehicle, ClusterWorkspace& space) {
  const Pose2 vehicle_from_world{inverse(world_from_vehicle)};
  space.followed.clear();
  for (std::size_t i{0}; i < vectors.size(); ++i) {
    const Point2 place{vehicle_from_world * vectors[i].place};
    const int label{space.segmenter.segment_at(place)};
    if (label >= 0) space.followed.push_back({.label = label, .vector = i, .spot = space.segmenter.spot_of(place)});
  }
  std::sort(space.followed.begin(), space.followed.end(),
            [](const auto& a, const auto& b) { return std::tie(a.label, a.vector) < std::tie(b.label, b.vector); });
}

// Calls work(segment, features) for each segment with features.
template <class Work>
void for_segments(std::vector<ClusterWorkspace::Followed>& followed, const Work& work) {
  for (auto begin = followed.begin(); begin != followed.end();) {
    const int label{begin->label};
    const auto end = std::find_if(begin, followed.end(), [&](const auto& one) { return one.label != label; });
    work(static_cast<std::size_t>(label), std::span{begin, end});
    begin = end;
  }
}

}  // namespace

void separate_movers(const std::vector<FlowVector>& vectors, const Pose2& world_from_vehicle, ClusterWorkspace& space) {
  find_followed(vectors, world_from_vehicle, space);
  for_segments(space.followed, [&](std::size_t segment, std::span<ClusterWorkspace::Followed> followed) {
    log_motion(vectors, followed, space.values);
    if (!are_two(followed)) return;
    space.segmenter.split(segment, [&](const SegmentNode& node) { return !moves_at({node.u, node.bin}, followed); });
  });
}

void measure_velocities(const std::vector<FlowVector>& vectors, const Pose2& world_from_vehicle,
                        ClusterWorkspace& space) {
  find_followed(vectors, world_from_vehicle, space);
  for_segments(space.followed, [&](std::size_t segment, Followed followed) {
    const Point2& at{vectors[followed[0].vector].place};
    measure(vectors, followed, space.rig, {at.x - world_from_vehicle.x_m, at.y - world_from_vehicle.y_m}, space.values,
            space.clusters[segment]);
  });
}

}  // namespace stereogrid
