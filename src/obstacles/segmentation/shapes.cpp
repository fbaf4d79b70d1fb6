// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "clamped_to_int.hpp"
#include "obstacles/segmentation/clusters.hpp"
#include "obstacles/segmentation/side_fit.hpp"

namespace stereogrid {
namespace {

constexpr double moving_mps{0.7};
constexpr double strip_m{0.2};  // minimum width of a part of an outline
constexpr int strips_max{SideFit::samples_max};
constexpr std::size_t object_side_points{4};
constexpr double thickness_m{0.5};  // assumed thickness of surfaces visible from one side only
constexpr double tail_share{0.1};   // share of a strip's pixels excluded as noise at either end
constexpr double sigma_px{0.3};
constexpr double least_sigma_m{0.02};  // unevenness of a surface
constexpr double overlap_m{0.1};
constexpr double height_share{0.9};
constexpr double boundary_m{8};       // minimum length of boundaries …
constexpr double high_m{3.6};         // … or minimum height, above a van's,
constexpr double high_boundary_m{4};  // with this minimum length, above a tree trunk's

/// Part of a segment between two image columns, from its near to its far side.
struct Strip {
  double left_u{0};
  double right_u{0};
  int pixels{0};
  int counted{0};
  double near_m{0};
  double middle_m{0};
  double far_m{0};

  // Requires far pixels first.
  void count(const SegmentNode& node) {
    const auto passes = [&](double share) {
      return counted < share * pixels && counted + node.pixels >= share * pixels;
    };
    if (passes(tail_share)) far_m = node.place.x;
    if (passes(0.5)) middle_m = node.place.x;
    if (passes(1 - tail_share)) near_m = node.place.x;
    counted += node.pixels;
  }
  // Noise makes some pixels nearer than their surface.
  void bound(double focal_baseline) {
    const double noise_m{2 * sigma_px * middle_m * middle_m / focal_baseline};
    if (far_m - near_m < 2 * noise_m) near_m = std::max(near_m, middle_m - noise_m);
    far_m = std::max(far_m, near_m + thickness_m);
  }
  [[nodiscard]] SideSample side(double at_m, double focal_baseline) const {
    const double disparity{focal_baseline / at_m};
    return {left_u, right_u, disparity, std::hypot(sigma_px, least_sigma_m * disparity / at_m)};
  }
};

// Excludes the highest columns: false matches, or objects behind.
double height_of(std::span<double> tops) {
  const auto at = tops.begin() + static_cast<std::ptrdiff_t>(height_share * static_cast<double>(tops.size() - 1));
  std::nth_element(tops.begin(), at, tops.end());
  return *at;
}

class Strips {
 public:
  Strips(ClusterWorkspace& space, std::size_t segment, Cluster& cluster) : rig_{space.rig} {
    const Segmenter& segmenter{space.segmenter};
    place(segmenter, segment, std::span{space.values}.subspan(segmenter.begin_of(segment)), cluster);
    for (const int index : segmenter.of(segment)) of(segmenter.node(index)).pixels += segmenter.node(index).pixels;
    for (const int index : segmenter.of(segment)) of(segmenter.node(index)).count(segmenter.node(index));
    const auto end =
        std::remove_if(strips_.begin(), strips_.begin() + count_, [](const Strip& one) { return one.pixels == 0; });
    count_ = static_cast<int>(end - strips_.begin());
    for (Strip& strip : used()) strip.bound(rig_.focal_px * rig_.baseline_m);
  }

  void draw_near(Outline& outline) const {
    for (const Strip& strip : used()) {
      add(strip.left_u, strip.near_m, outline);
      add(strip.right_u, strip.near_m, outline);
    }
  }
  // Requires draw_near(). The hidden part of a strip is extended to where its neighbours begin, so that the outline is
  // one polygon.
  void draw_far(Outline& outline) {
    for (int i{0}; i + 1 < count_; ++i) {
      Strip& left{strips_[static_cast<std::size_t>(i)]};
      Strip& right{strips_[static_cast<std::size_t>(i) + 1]};
      left.far_m = std::max(left.far_m, right.near_m + overlap_m);
      right.far_m = std::max(right.far_m, left.near_m + overlap_m);
    }
    for (int i{count_}; i-- > 0;) {
      const Strip& strip{strips_[static_cast<std::size_t>(i)]};
      add(strip.right_u, strip.far_m, outline);
      add(strip.left_u, strip.far_m, outline);
    }
  }

  /// A side of the segment: `at_m` of its strips.
  [[nodiscard]] std::span<const SideSample> side(double Strip::*at_m) {
    for (std::size_t i{0}; i < used().size(); ++i) {
      samples_[i] = used()[i].side(used()[i].*at_m, rig_.focal_px * rig_.baseline_m);
    }
    return {samples_.data(), used().size()};
  }

 private:
  void place(const Segmenter& segmenter, std::size_t segment, std::span<double> tops, Cluster& cluster) {
    int right{0};
    left_ = std::numeric_limits<int>::max();
    double depth_m{0};
    std::size_t count{0};
    for (const int index : segmenter.of(segment)) {
      const SegmentNode& node{segmenter.node(index)};
      left_ = std::min(left_, node.u);
      right = std::max(right, node.u + 1);
      cluster.pixels += node.pixels;
      depth_m += node.pixels * node.place.x;
      tops[count++] = node.top_m;
    }
    cluster.height_m = height_of(tops.first(count));
    const double width_m{(right - left_) * depth_m / cluster.pixels / rig_.focal_px};
    count_ = std::clamp(clamped_to_int(std::ceil(width_m / strip_m)), 2, strips_max);
    width_px_ = static_cast<double>(right - left_) / count_;
    for (int i{0}; i < count_; ++i) {
      strips_[static_cast<std::size_t>(i)].left_u = left_ + width_px_ * i;
      strips_[static_cast<std::size_t>(i)].right_u = left_ + width_px_ * (i + 1);
    }
  }
  Strip& of(const SegmentNode& node) {
    const int i{std::min(static_cast<int>((node.u - left_) / width_px_), count_ - 1)};
    return strips_[static_cast<std::size_t>(i)];
  }
  void add(double u, double x_m, Outline& outline) const {
    outline.push_back({x_m, (rig_.cx_px - u) * x_m / rig_.focal_px});
  }
  std::span<Strip> used() { return {strips_.data(), static_cast<std::size_t>(count_)}; }
  [[nodiscard]] std::span<const Strip> used() const { return {strips_.data(), static_cast<std::size_t>(count_)}; }

  const Rig& rig_;
  std::array<Strip, strips_max> strips_{};
  std::array<SideSample, strips_max> samples_{};
  int count_{0};
  int left_{0};
  double width_px_{1};
};

Point2 farthest_from(Point2 from, const Outline& outline) {
  return *std::max_element(outline.begin(), outline.end(), [&](Point2 a, Point2 b) {
    return std::hypot(a.x - from.x, a.y - from.y) < std::hypot(b.x - from.x, b.y - from.y);
  });
}

// `near`: near side of the outline.
bool is_boundary(const Outline& near, double height_m) {
  const Point2 end{farthest_from(near[0], near)};
  const Point2 other{farthest_from(end, near)};
  const double long_m{std::hypot(end.x - other.x, end.y - other.y)};
  return long_m > boundary_m || (height_m > high_m && long_m > high_boundary_m);
}

// Fitted outline: the near side, and for objects the far side, at least thickness_m behind it along the rays. Both have
// the same columns, and the outline is a simple polygon.
void fit_outline(const Rig& rig, Strips& strips, Cluster& cluster) {
  const bool is_object{cluster.kind == ObstacleKind::object};
  const double focal_baseline{rig.focal_px * rig.baseline_m};
  const std::span<const SideSample> near{strips.side(&Strip::near_m)};
  // things behind show in some strips of a boundary: two numbers a point, by Schwarz' criterion (1978)
  const double point_gain{2 * std::log(static_cast<double>(near.size()))};
  SideFit side{near, is_object ? object_side_points : SideFit::points_max, is_object ? 0 : point_gain};
  for (std::size_t i{0}; i < side.size(); ++i) {
    const double x_m{focal_baseline / side.disparity(i)};
    cluster.fitted.push_back({x_m, (rig.cx_px - side.column(i)) * x_m / rig.focal_px});
  }
  if (!is_object) return;
  side.refit(strips.side(&Strip::far_m));
  for (std::size_t i{side.size()}; i-- > 0;) {
    const Point2 front{cluster.fitted[i]};
    const double x_m{std::max(focal_baseline / side.disparity(i), front.x + thickness_m)};
    cluster.fitted.push_back({x_m, front.y * x_m / front.x});
  }
}

void outline_segment(ClusterWorkspace& space, std::size_t segment, Cluster& cluster) {
  Strips strips{space, segment, cluster};
  strips.draw_near(cluster.outline);
  if (is_boundary(cluster.outline, cluster.height_m)) cluster.kind = ObstacleKind::boundary;
  fit_outline(space.rig, strips, cluster);
  if (cluster.kind == ObstacleKind::object) strips.draw_far(cluster.outline);
}

struct Direction {
  double yaw_rad{0};
  double c{std::cos(yaw_rad)};
  double s{std::sin(yaw_rad)};
};

void fit_box(const Direction& direction, Cluster& cluster) {
  const auto [yaw_rad, c, s] = direction;
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

// The smallest box, its longer side along its yaw. `directions`: over half a turn, across in the second half.
void fit_smallest_box(std::span<const Direction> directions, Cluster& cluster) {
  const std::size_t quarter{directions.size() / 2};
  std::size_t best{0};
  double least_m2{std::numeric_limits<double>::max()};
  for (std::size_t i{0}; i < quarter; ++i) {
    fit_box(directions[i], cluster);
    const double area_m2{cluster.length_m * cluster.width_m};
    if (area_m2 >= least_m2) continue;
    least_m2 = area_m2;
    best = cluster.length_m < cluster.width_m ? i + quarter : i;
  }
  fit_box(directions[best], cluster);
}

}  // namespace

Bounds bounds_of(const Outline& outline) {
  Bounds bounds{};
  if (!outline.empty()) bounds = {outline[0], outline[0]};
  for (const Point2& point : outline) {
    bounds.least = {std::min(bounds.least.x, point.x), std::min(bounds.least.y, point.y)};
    bounds.most = {std::max(bounds.most.x, point.x), std::max(bounds.most.y, point.y)};
  }
  return bounds;
}

ClusterWorkspace::ClusterWorkspace(const Rig& level_rig, int disparities, std::size_t points)
    : segmenter{level_rig, disparities}, rig{level_rig} {
  clusters.reserve(things_reserved);
  followed.reserve(points);
  values.reserve(std::max(points, nodes_reserved(level_rig.width_px, disparities)));
}

void outline_segments(int begin, int end, const Pose2& world_from_vehicle, ClusterWorkspace& space) {
  for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
    Cluster& cluster{space.clusters[i]};
    outline_segment(space, i, cluster);
    const auto [cut_left, cut_right] = space.segmenter.cuts_of(i);
    cluster.is_cut_left = cut_left;
    cluster.is_cut_right = cut_right;
    for (Point2& point : cluster.outline) point = world_from_vehicle * point;
    for (Point2& point : cluster.fitted) point = world_from_vehicle * point;
    cluster.bounds = bounds_of(cluster.outline);
  }
  fit_boxes(std::span{space.clusters}.subspan(static_cast<std::size_t>(begin), static_cast<std::size_t>(end - begin)));
}

void ask_grid(const GridLayers& world, const Pose2& world_from_vehicle, ClusterWorkspace& space) {
  for (std::size_t i{0}; i < space.segmenter.size(); ++i) {
    Cluster& cluster{space.clusters[i]};
    double known{0};
    double occupied{0};
    double moving{0};
    Point2 velocity{};
    for (const int index : space.segmenter.of(i)) {
      const SegmentNode& node{space.segmenter.node(index)};
      const std::optional<CellIndex> cell{world.geometry.cell_at(world_from_vehicle * node.place)};
      if (!cell) continue;
      const auto [x, y] = *cell;
      const double of_node{node.weight * static_cast<double>(world.occupancy(x, y))};
      known += node.weight;
      occupied += of_node;
      moving += node.weight * static_cast<double>(world.moving(x, y));
      velocity.x += of_node * static_cast<double>(world.velocity_x(x, y));
      velocity.y += of_node * static_cast<double>(world.velocity_y(x, y));
    }
    cluster.moving = occupied > 0 ? moving / occupied : 0;
    if (cluster.moving > 0.5 && !cluster.has_measured_velocity()) {
      cluster.velocity = {velocity.x / occupied, velocity.y / occupied};
      fit_boxes({&cluster, 1});
    }
    cluster.occupancy = known > 0 ? occupied / known : 0.5;
  }
}

void fit_boxes(std::span<Cluster> clusters) {
  std::array<Direction, 36> directions;  // half a turn
  for (int i{0}; Direction & one : directions) one = {i++ * M_PI / 36};
  for (Cluster& cluster : clusters) {
    const bool moves{cluster.kind == ObstacleKind::object &&
                     std::hypot(cluster.velocity.x, cluster.velocity.y) > moving_mps};
    moves ? fit_box({std::atan2(cluster.velocity.y, cluster.velocity.x)}, cluster)
          : fit_smallest_box(directions, cluster);
  }
}

}  // namespace stereogrid
