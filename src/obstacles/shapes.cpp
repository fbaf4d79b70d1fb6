// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "clamped_to_int.hpp"
#include "obstacles/tracking.hpp"

namespace stereogrid {
namespace {

constexpr double moving_mps{0.7};
constexpr double strip_m{0.2};  // width of a part of an outline, at least
constexpr int strips_max{12};
constexpr double thickness_m{0.5};  // of what is seen from one side only
constexpr double tail_share{0.1};   // of a strip's pixels on either side that do not count: noise
constexpr double sigma_px{0.3};
constexpr double extended_m{10};      // longer ones are boundaries …
constexpr double high_m{3.6};         // … and so are those that are higher than a van
constexpr double high_extended_m{4};  // and longer than a tree's trunk

/// What a strip of the image has of a segment: between two columns, from the near to the far side.
struct Strip {
  double left_u;
  double right_u;
  double near_m;
  double far_m;
};

// The depths between which most of the strip's pixels lie. `depths`: pixels by depth, ascending.
Strip strip_of(std::vector<ClusterSpace::Depth>& depths, double left_u, double right_u, double focal_baseline) {
  std::sort(depths.begin(), depths.end(), [](const auto& a, const auto& b) { return a.x_m < b.x_m; });
  double pixels{0};
  for (const auto& depth : depths) pixels += depth.pixels;
  const auto quantile = [&](double share) {
    double before{0};
    for (const auto& depth : depths) {
      before += depth.pixels;
      if (before >= share * pixels) return depth.x_m;
    }
    return depths.back().x_m;
  };
  const double middle_m{quantile(0.5)};
  const double noise_m{2 * sigma_px * middle_m * middle_m / focal_baseline};
  double near_m{quantile(tail_share)};
  const double far_m{quantile(1 - tail_share)};
  if (far_m - near_m < 2 * noise_m) near_m = std::max(near_m, middle_m - noise_m);
  return {left_u, right_u, near_m, std::max(far_m, near_m + thickness_m)};
}

bool is_extended(const Cluster& cluster) {
  const double long_m{std::hypot(cluster.length_m, cluster.width_m)};
  return long_m > extended_m || (cluster.height_m > high_m && long_m > high_extended_m);
}

// The box along `yaw` around the outline.
void fit_box(double yaw_rad, Cluster& cluster) {
  const double c{std::cos(yaw_rad)};
  const double s{std::sin(yaw_rad)};
  double along_min{std::numeric_limits<double>::max()};
  double along_max{std::numeric_limits<double>::lowest()};
  double across_min{along_min};
  double across_max{along_max};
  for (const Point2& at : cluster.outline) {
    const double along{c * at.x + s * at.y};
    const double across{-s * at.x + c * at.y};
    along_min = std::min(along_min, along);
    along_max = std::max(along_max, along);
    across_min = std::min(across_min, across);
    across_max = std::max(across_max, across);
  }
  const double along{(along_min + along_max) / 2};
  const double across{(across_min + across_max) / 2};
  cluster.yaw_rad = yaw_rad;
  cluster.centre = {c * along - s * across, s * along + c * across};
  cluster.length_m = along_max - along_min;
  cluster.width_m = across_max - across_min;
}

// The smallest box, its longer side along its yaw.
void fit_smallest_box(Cluster& cluster) {
  constexpr int directions{36};
  Cluster best;
  double least_m2{std::numeric_limits<double>::max()};
  for (int i{0}; i < directions; ++i) {
    fit_box(i * M_PI / directions, cluster);
    const double area_m2{cluster.length_m * cluster.width_m};
    if (cluster.length_m < cluster.width_m || area_m2 >= least_m2) continue;
    least_m2 = area_m2;
    best = cluster;
  }
  if (least_m2 < std::numeric_limits<double>::max()) cluster = best;
}

void find_bounds(Cluster& cluster) {
  Bounds& bounds{cluster.bounds};
  if (!cluster.outline.empty()) bounds = {cluster.outline[0], cluster.outline[0]};
  for (const Point2& point : cluster.outline) {
    bounds.least = {std::min(bounds.least.x, point.x), std::min(bounds.least.y, point.y)};
    bounds.most = {std::max(bounds.most.x, point.x), std::max(bounds.most.y, point.y)};
  }
}

// What the filter says of the segment's cells.
void ask_grid(const Segmenter& segmenter, std::size_t segment, const GridLayers& world, const Pose2& world_from_vehicle,
              Cluster& cluster) {
  double known{0};
  double moving{0};
  for (const int index : segmenter.of(segment)) {
    const SegmentNode& node{segmenter.node(index)};
    const std::optional<CellIndex> cell{world.geometry.cell_at(world_from_vehicle * node.place)};
    if (!cell) continue;
    const auto [x, y] = *cell;
    const double occupied{node.weight * static_cast<double>(world.occupancy(x, y))};
    known += node.weight;
    cluster.occupancy += occupied;
    moving += node.weight * static_cast<double>(world.moving(x, y));
    cluster.velocity.x += occupied * static_cast<double>(world.velocity_x(x, y));
    cluster.velocity.y += occupied * static_cast<double>(world.velocity_y(x, y));
  }
  const double occupied{cluster.occupancy};
  cluster.velocity = moving > 0.5 * occupied && occupied > 0
                         ? Point2{cluster.velocity.x / occupied, cluster.velocity.y / occupied}
                         : Point2{};
  cluster.occupancy = known > 0 ? occupied / known : 0.5;
}

}  // namespace

ClusterSpace::ClusterSpace(const Rig& level_rig, const UDisparityConfig& heights, int disparities, std::size_t points)
    : segmenter{level_rig, heights, disparities}, rig{level_rig} {
  clusters.reserve(things_reserved);
  depths.reserve(4096);
  followed.reserve(points);
  values.reserve(points);
}

namespace {

// From the left to the right on the near side, and, of a thing, back on the far side.
void draw_outline(ClusterSpace& space, std::size_t segment, Cluster& cluster) {
  const Segmenter& segmenter{space.segmenter};
  int left{std::numeric_limits<int>::max()};
  int right{0};
  double pixels{0};
  double depth_m{0};
  for (const int index : segmenter.of(segment)) {
    const SegmentNode& node{segmenter.node(index)};
    left = std::min(left, node.u);
    right = std::max(right, node.u + 1);
    pixels += node.pixels;
    depth_m += node.pixels * node.place.x;
    cluster.height_m = std::max(cluster.height_m, static_cast<double>(node.top_m));
  }
  cluster.pixels = clamped_to_int(pixels);
  const double width_m{(right - left) * depth_m / pixels / space.rig.focal_px};
  const int strips{std::clamp(clamped_to_int(std::ceil(width_m / strip_m)), 2, strips_max)};
  std::array<Strip, strips_max> all{};
  std::size_t count{0};
  for (int i{0}; i < strips; ++i) {
    const double from{left + static_cast<double>(right - left) * i / strips};
    const double to{left + static_cast<double>(right - left) * (i + 1) / strips};
    space.depths.clear();
    for (const int index : segmenter.of(segment)) {
      const SegmentNode& node{segmenter.node(index)};
      if (node.u >= from && node.u < to) space.depths.push_back({node.place.x, node.pixels});
    }
    if (space.depths.empty()) continue;
    all[count++] = strip_of(space.depths, from, to, space.rig.focal_px * space.rig.baseline_m);
  }
  const auto add = [&](double u, double x_m) {
    cluster.outline.push_back({x_m, (space.rig.centre_u_px - u) * x_m / space.rig.focal_px});
  };
  for (std::size_t i{0}; i < count; ++i) {
    add(all[i].left_u, all[i].near_m);
    add(all[i].right_u, all[i].near_m);
  }
  fit_smallest_box(cluster);
  if (is_extended(cluster)) cluster.kind = ObstacleKind::extended;
  if (cluster.kind == ObstacleKind::extended) return;
  for (std::size_t i{count}; i-- > 0;) {
    add(all[i].right_u, all[i].far_m);
    add(all[i].left_u, all[i].far_m);
  }
}

}  // namespace

void find_clusters(View<const float> obstacle, const Ground& ground, const GridLayers& world,
                   const Pose2& world_from_vehicle, ClusterSpace& space) {
  space.segmenter.find(obstacle, ground);
  space.clusters.clear();
  for (std::size_t i{0}; i < space.segmenter.size(); ++i) {
    Cluster cluster;
    draw_outline(space, i, cluster);
    for (Point2& point : cluster.outline) point = world_from_vehicle * point;
    find_bounds(cluster);
    ask_grid(space.segmenter, i, world, world_from_vehicle, cluster);
    space.clusters.push_back(cluster);
  }
}

void fit_boxes(std::vector<Cluster>& clusters) {
  for (Cluster& cluster : clusters) {
    const bool moves{cluster.kind == ObstacleKind::thing &&
                     std::hypot(cluster.velocity.x, cluster.velocity.y) > moving_mps};
    moves ? fit_box(std::atan2(cluster.velocity.y, cluster.velocity.x), cluster) : fit_smallest_box(cluster);
  }
}

}  // namespace stereogrid
