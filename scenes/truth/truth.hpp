// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "render/render.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/truth.hpp"
#include "world/world.hpp"

namespace stereogrid::scenes {

/// Corners counter-clockwise.
using Polygon = std::vector<Point2>;

/// The smallest convex polygon around some points.
[[nodiscard]] Polygon convex_hull(std::vector<Point2> points);

/// Area of the convex polygon within a rectangle.
[[nodiscard]] double area_within(const Polygon& polygon, Point2 low, Point2 high);

/// One instant of a world as the rig sees it. Everything referred to must outlive it.
struct Moment {
  const World& world;
  const Rig& rig;  ///< rig of the frame
  const Frame3& vehicle;
  const std::vector<PlacedPart>& parts;
  const Caster& left;
  const Caster& right;
  double time_s{0};
  std::vector<const Caster*> other_lefts{};  ///< left cameras of the other pairs
};

/// Exact knowledge about a moment, all but name and stamp. Runs on the threads of the current TBB arena.
[[nodiscard]] FrameTruth truth_of(const Moment& moment, const TruthGrid& grid);

/// The part of it that is measured on the grid. Expects ego, objects, label and instance to be known.
void fill_cells(const Moment& moment, const TruthGrid& grid, FrameTruth& truth);

/// Terrain classes, elevations and steps. Expects the rest of the cells to be known, changes
/// the states to what the classes say.
void fill_terrain(const Moment& moment, const TruthGrid& grid, FrameTruth& truth);

/// The ground at a place of the vehicle frame, along its z axis; in the world.
[[nodiscard]] Vector3 on_ground(const Moment& moment, Point2 place);

/// A point is in view when nothing lies more than this before it.
constexpr double view_tolerance_m{1e-3};
[[nodiscard]] bool in_view(const Caster& caster, Vector3 point);
/// In view of the left camera of any pair.
[[nodiscard]] bool in_view(const Moment& moment, Vector3 point);

}  // namespace stereogrid::scenes
