// SPDX-License-Identifier: Apache-2.0
#include "truth/truth.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace stereogrid::scenes {
namespace {

struct Extent {
  Vector3 low{1e9, 1e9, 1e9};
  Vector3 high{-1e9, -1e9, -1e9};
};

/// The outline of a part in its body's frame, between two heights above the road.
std::vector<Point2> outline_in_body(const Part& part, double bottom_m, double top_m) {
  const Direction heading{direction_of(part.yaw_rad)};
  std::vector<Point2> points;
  for (const Point2 p : outline(part.solid, bottom_m - part.centre.z, top_m - part.centre.z)) {
    points.push_back({part.centre.x + heading.cosine * p.x - heading.sine * p.y,
                      part.centre.y + heading.sine * p.x + heading.cosine * p.y});
  }
  return points;
}

Extent extent_of(const Body& body) {
  Extent extent;
  for (const Part& part : body.parts) {
    for (const Point2 p : outline_in_body(part, -1e9, 1e9)) {
      extent.low = {std::min(extent.low.x, p.x), std::min(extent.low.y, p.y), extent.low.z};
      extent.high = {std::max(extent.high.x, p.x), std::max(extent.high.y, p.y), extent.high.z};
    }
    extent.low.z = std::min(extent.low.z, part.centre.z - part.solid.half.z);
    extent.high.z = std::max(extent.high.z, part.centre.z + part.solid.half.z);
  }
  return extent;
}

Polygon footprint_of(const Body& body, const Pose2& world_from_body, double bottom_m, double top_m) {
  const Direction heading{direction_of(world_from_body.yaw_rad)};
  std::vector<Point2> points;
  for (const Part& part : body.parts) {
    for (const Point2 p : outline_in_body(part, bottom_m, top_m)) {
      points.push_back({world_from_body.x_m + heading.cosine * p.x - heading.sine * p.y,
                        world_from_body.y_m + heading.sine * p.x + heading.cosine * p.y});
    }
  }
  return convex_hull(std::move(points));
}

TruthObject object_of(const Body& body, double time_s, const TruthGrid& grid) {
  const Extent extent{extent_of(body)};
  const Pose2 pose{body.motion.pose_at(time_s)};
  const Direction heading{direction_of(pose.yaw_rad)};
  const double speed{body.motion.speed_at(time_s)};
  TruthObject object;
  object.id = body.id;
  object.kind = body.kind;
  object.world_from_object = pose;
  object.vx_mps = speed * heading.cosine;
  object.vy_mps = speed * heading.sine;
  object.height_m = extent.high.z - body.ground_m;
  object.size_m[0] = extent.high.y - extent.low.y;
  object.size_m[1] = extent.high.x - extent.low.x;
  object.size_m[2] = extent.high.z - extent.low.z;
  object.footprint = footprint_of(body, pose, body.ground_m + grid.height_min_m, body.ground_m + grid.height_max_m);
  return object;
}

TruthEgo ego_of(const Moment& moment) {
  const Motion& motion{moment.world.ego};
  const Pose2 pose{motion.pose_at(moment.time_s)};
  const Direction heading{direction_of(pose.yaw_rad)};
  const double speed{motion.speed_at(moment.time_s)};
  const Frame3& vehicle{moment.vehicle};
  return {pose,
          speed * heading.cosine,
          speed * heading.sine,
          speed * motion.curvature_per_m,
          vehicle.origin.z,
          std::asin(-vehicle.forward.z),
          std::atan2(vehicle.left.z, vehicle.up.z),
          moment.rig.camera_height_m,
          moment.rig.camera_pitch_rad,
          moment.rig.camera_roll_rad};
}

void fill_pixel(const Moment& moment, int u, int v, FrameTruth& truth) {
  const Hit hit{moment.left.trace(u, v)};
  if (hit.part == Hit::sky) return;
  const Camera& camera{moment.left.camera()};
  truth.disparity(u, v) = static_cast<float>(camera.focal_px * moment.rig.baseline_m / hit.depth);
  const Vector3 point{camera.position + hit.depth * camera.ray(u, v)};
  truth.seen_by_both(u, v) = in_view(moment.right, point) ? 255 : 0;
  if (hit.part == Hit::road) {
    truth.label(u, v) = static_cast<std::uint8_t>(TruthLabel::road);
    return;
  }
  const Body& body{*moment.parts[static_cast<std::size_t>(hit.part)].body};
  truth.label(u, v) = static_cast<std::uint8_t>(body.label);
  truth.instance(u, v) = body.id;
}

void fill_pixels(const Moment& moment, FrameTruth& truth) {
  const int width{moment.rig.width_px};
  const int height{moment.rig.height_px};
  truth.disparity = {width, height};
  truth.label = {width, height};
  truth.instance = {width, height};
  truth.seen_by_both = {width, height};
  for_rows(height, [&](int v) {
    for (int u{0}; u < width; ++u) fill_pixel(moment, u, v, truth);
  });
}

}  // namespace

bool in_view(const Caster& caster, Vector3 point) {
  const Projection at{project(caster.camera(), point)};
  if (!inside(caster.camera(), at)) return false;
  const Hit hit{caster.trace(at.u, at.v)};
  // Far away the rounding of u and v moves a grazing ray's end by more than the fixed tolerance.
  return hit.part == Hit::sky || hit.depth >= at.depth - std::max(view_tolerance_m, 1e-6 * at.depth * at.depth);
}

bool in_view(const Moment& moment, Vector3 point) {
  return in_view(moment.left, point) ||
         std::ranges::any_of(moment.other_lefts, [&](const Caster* caster) { return in_view(*caster, point); });
}

FrameTruth truth_of(const Moment& moment, const TruthGrid& grid) {
  FrameTruth truth;
  truth.ego = ego_of(moment);
  for (const Body& body : moment.world.bodies) {
    if (body.label == TruthLabel::obstacle) truth.objects.push_back(object_of(body, moment.time_s, grid));
  }
  fill_pixels(moment, truth);
  std::vector<std::int64_t> pixels(truth.objects.size() + 1);
  for (const std::uint16_t id : truth.instance) ++pixels[id];
  for (TruthObject& object : truth.objects) object.pixels = pixels[static_cast<std::size_t>(object.id)];
  fill_cells(moment, grid, truth);
  if (!moment.world.ground.is_flat()) fill_terrain(moment, grid, truth);
  return truth;
}

namespace {

double turn(Point2 a, Point2 b, Point2 c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

void extend_hull(Polygon& hull, std::size_t fixed, Point2 point) {
  while (hull.size() >= fixed + 2 && turn(hull[hull.size() - 2], hull.back(), point) <= 0) hull.pop_back();
  hull.push_back(point);
}

/// Keeps the side where a·x + b·y ≥ c.
Polygon clipped(const Polygon& polygon, double a, double b, double c) {
  Polygon kept;
  for (std::size_t i{0}; i < polygon.size(); ++i) {
    const Point2 p{polygon[i]};
    const Point2 q{polygon[(i + 1) % polygon.size()]};
    const double height_p{a * p.x + b * p.y - c};
    const double height_q{a * q.x + b * q.y - c};
    if (height_p >= 0) kept.push_back(p);
    if ((height_p < 0) != (height_q < 0)) {
      const double t{height_p / (height_p - height_q)};
      kept.push_back({p.x + t * (q.x - p.x), p.y + t * (q.y - p.y)});
    }
  }
  return kept;
}

double area_of(const Polygon& polygon) {
  double doubled{0};
  for (std::size_t i{2}; i < polygon.size(); ++i) doubled += turn(polygon[0], polygon[i - 1], polygon[i]);
  return doubled / 2;
}

}  // namespace

Polygon convex_hull(std::vector<Point2> points) {
  std::sort(points.begin(), points.end(), [](Point2 a, Point2 b) { return a.x < b.x || (a.x == b.x && a.y < b.y); });
  Polygon hull;
  for (const Point2 point : points) extend_hull(hull, 0, point);
  const std::size_t lower{hull.empty() ? 0 : hull.size() - 1};
  for (auto point = points.rbegin(); point != points.rend(); ++point) {
    if (point != points.rbegin()) extend_hull(hull, lower, *point);
  }
  if (hull.size() > 1) hull.pop_back();
  return hull;
}

double area_within(const Polygon& polygon, Point2 low, Point2 high) {
  return area_of(clipped(clipped(clipped(clipped(polygon, 1, 0, low.x), -1, 0, -high.x), 0, 1, low.y), 0, -1, -high.y));
}

}  // namespace stereogrid::scenes
