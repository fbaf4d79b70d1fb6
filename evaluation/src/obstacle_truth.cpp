// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include "outlines.hpp"
#include "stereogrid/evaluation/obstacles.hpp"
#include "truth_cells.hpp"

namespace stereogrid::evaluation {
namespace {

constexpr double from_m{3};
constexpr double to_m{20};

// exact truth
constexpr std::array<std::string_view, 7> extended_kinds{"building", "wall",   "hedge", "tree",
                                                         "kerb",     "ground", "fence"};
constexpr std::int64_t pixels_min{250};
constexpr std::size_t cells_min{2};
constexpr double cells_reach_m{0.3};
constexpr double has_velocity_above_mps{0.5};
constexpr double disparity_sigma_px{0.3};

// labelled boxes
constexpr int largely_hidden{2};
constexpr int points_of_side{11};
constexpr std::size_t points_min{8};
constexpr double points_reach_m{0.5};

bool is_ahead(Point2 point) {
  return point.x >= from_m && point.x < to_m;
}

/// Cells of things by the thing's id, and free and occupied cells.
std::map<std::int64_t, std::vector<Point2>> sort_cells(const FrameTruth& truth, const GridGeometry& grid,
                                                       ObstacleTruth& sorted) {
  std::map<std::int64_t, std::vector<Point2>> seen;
  for (int iy{0}; iy < truth.state.height(); ++iy) {
    for (int ix{0}; ix < truth.state.width(); ++ix) {
      const Point2 place{grid.centre(ix, iy)};
      const TruthCell state{state_at(truth, ix, iy)};
      if (!is_ahead(place)) continue;
      if (state == TruthCell::seen_free && truth.low(ix, iy) == 0) sorted.free.push_back(place);
      if (state != TruthCell::seen_occupied) continue;
      sorted.occupied.push_back(place);
      seen[truth.seen_object(ix, iy)].push_back(place);
    }
  }
  return seen;
}

/// The box around the footprint that lies along the thing's heading.
void measure(const TruthObject& object, const Pose2& vehicle_from_world, Thing& thing) {
  constexpr double far{std::numeric_limits<double>::infinity()};
  const Pose2 object_from_world{inverse(object.world_from_object)};
  Point2 least{far, far};
  Point2 most{-far, -far};
  for (const Point2 corner : object.footprint) {
    const Point2 p{object_from_world * corner};
    least = {std::min(least.x, p.x), std::min(least.y, p.y)};
    most = {std::max(most.x, p.x), std::max(most.y, p.y)};
    thing.footprint.push_back(vehicle_from_world * corner);
  }
  thing.area_m2 = area_of(object.footprint);
  if (object.footprint.empty()) return;
  const Point2 middle{(least.x + most.x) / 2, (least.y + most.y) / 2};
  thing.centre = vehicle_from_world * (object.world_from_object * middle);
  thing.length_m = most.x - least.x;
  thing.width_m = most.y - least.y;
}

Thing thing_of(const TruthObject& object, const FrameTruth& truth, std::vector<Point2> seen) {
  const Pose2 vehicle_from_world{inverse(truth.ego.world_from_vehicle)};
  Thing thing;
  thing.id = object.id;
  thing.kind = object.kind;
  thing.seen = std::move(seen);
  thing.reach_m = cells_reach_m;
  measure(object, vehicle_from_world, thing);
  if (std::hypot(object.vx_mps, object.vy_mps) > has_velocity_above_mps) {
    thing.velocity_mps = Pose2{0, 0, vehicle_from_world.yaw_rad} * Point2{object.vx_mps, object.vy_mps};
  }
  return thing;
}

/// Points on the sides that end at the corner nearest to the camera.
std::vector<Point2> facing_points(const LabelledObject& object, std::vector<Point2> corners) {
  constexpr double side_within_m{0.05};
  constexpr std::size_t sides{2};
  std::ranges::stable_sort(corners, {}, [](Point2 p) { return std::hypot(p.x, p.y); });
  const Point2 a{corners.front()};
  std::vector<Point2> points;
  for (std::size_t i{1}; i < corners.size() && points.size() < sides * points_of_side; ++i) {
    const Point2 b{corners[i]};
    const double length{std::hypot(b.x - a.x, b.y - a.y)};
    if (std::min(std::abs(length - object.length_m), std::abs(length - object.width_m)) >= side_within_m) continue;
    for (int k{0}; k < points_of_side; ++k) {
      const double t{k * (1.0 / (points_of_side - 1))};
      points.push_back({a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)});
    }
  }
  return points;
}

Thing thing_of(const LabelledObject& object, const Rig& rig) {
  Thing thing;
  thing.id = object.id;
  thing.kind = object.kind;
  thing.reach_m = points_reach_m;
  thing.footprint = corners_of({object.x_m, object.y_m, object.yaw_rad}, object.length_m, object.width_m);
  thing.area_m2 = object.length_m * object.width_m;
  thing.centre = {object.x_m, object.y_m};
  thing.length_m = object.length_m;
  thing.width_m = object.width_m;
  if (object.moving.value_or(false)) thing.velocity_mps = object.velocity_mps;
  thing.seen = facing_points(object, thing.footprint);
  std::erase_if(thing.seen, [&rig](Point2 p) {
    const double u{rig.cx_px - rig.focal_px * p.y / std::max(p.x, 0.1)};
    return !is_ahead(p) || u <= 0 || u >= rig.width_px;
  });
  return thing;
}

void sort_cells(const Labels& labels, ObstacleTruth& sorted) {
  for (int iy{0}; iy < labels.cells.height(); ++iy) {
    for (int ix{0}; ix < labels.cells.width(); ++ix) {
      const Point2 place{labels.geometry.centre(ix, iy)};
      if (!is_ahead(place)) continue;
      if (labels.cells(ix, iy) == labelled_free) sorted.free.push_back(place);
      if (labels.cells(ix, iy) == labelled_occupied) sorted.occupied.push_back(place);
    }
  }
}

}  // namespace

ObstacleTruth obstacle_truth(const FrameTruth& truth, const TruthGrid& truth_grid, const Rig& rig) {
  const Pose2 vehicle_from_world{inverse(truth.ego.world_from_vehicle)};
  ObstacleTruth known;
  known.has_cell_truth = true;
  known.sigma_per_m2 = disparity_sigma_px / (rig.focal_px * rig.baseline_m);
  auto seen{sort_cells(truth, truth_grid.geometry, known)};
  for (const TruthObject& object : truth.objects) {
    if (is_moving(object)) {
      known.movers.push_back({vehicle_from_world * Point2{object.world_from_object.x_m, object.world_from_object.y_m},
                              std::max(object.size_m[0], object.size_m[1]) / 2});
    }
    const bool is_thing{std::ranges::find(extended_kinds, object.kind) == extended_kinds.end()};
    const auto cells{seen.find(object.id)};
    if (!is_thing || object.pixels < pixels_min || cells == seen.end() || cells->second.size() < cells_min) continue;
    known.things.push_back(thing_of(object, truth, std::move(cells->second)));
    seen.erase(cells);
  }
  return known;
}

ObstacleTruth obstacle_truth(std::span<const LabelledObject> objects, const Rig& rig, const Labels* cells) {
  ObstacleTruth known;
  known.has_cell_truth = cells != nullptr;
  if (cells != nullptr) sort_cells(*cells, known);
  for (const LabelledObject& object : objects) {
    if (object.moving.value_or(true)) {
      known.movers.push_back({{object.x_m, object.y_m}, std::max(object.length_m, object.width_m) / 2});
    }
    if (object.occluded >= largely_hidden) continue;
    Thing thing{thing_of(object, rig)};
    if (thing.seen.size() >= points_min) known.things.push_back(std::move(thing));
  }
  return known;
}

}  // namespace stereogrid::evaluation
