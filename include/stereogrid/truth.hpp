// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "stereogrid/frame.hpp"
#include "stereogrid/grid.hpp"

namespace stereogrid {

/// Pixel classes of ground truth.
enum class TruthLabel : std::uint8_t { sky = 0, road = 1, obstacle = 2, low = 3 };

/// Cell states of ground truth.
enum class TruthCell : std::uint8_t { hidden = 0, seen_free = 1, seen_occupied = 2 };

/// Classes of cells of uneven ground, for a vehicle that climbs steps up to TruthGrid::height_min_m and slopes up to
/// 20° and needs the clearance TruthGrid::height_max_m.
enum class TerrainCell : std::uint8_t {
  hidden = 0,    ///< not seen, or out of reach behind an obstacle
  drivable = 1,  ///< seen ground that the vehicle reaches
  obstacle = 2,  ///< seen: a body, a step up, a rise that is too steep
  drop = 3,      ///< seen: the first cell lower than an edge
  beyond = 4     ///< within the field of view, behind an edge: lower ground, seen or not, and cells out of reach behind
                 ///< it
};

/// Object in the scene, static or dynamic.
struct TruthObject {
  std::int64_t id{0};
  std::string kind;
  Pose2 world_from_object;
  double vx_mps{0};  ///< world axes
  double vy_mps{0};
  double height_m{0};
  double size_m[3]{0, 0, 0};      ///< width, length, height
  std::vector<Point2> footprint;  ///< convex, counter-clockwise, world frame; the part between the cells' height limits
  std::int64_t pixels{0};         ///< seen in the left image
};

/// Labelled object: a box on the ground, in the vehicle frame of the frame's instant. None: not labelled.
struct LabelledObject {
  std::int64_t id{0};
  std::string kind;
  double x_m{0};  ///< centre
  double y_m{0};
  double length_m{0};  ///< along yaw_rad
  double width_m{0};
  double yaw_rad{0};
  int occluded{0};                       ///< KITTI's: 0 visible, 1 partly, 2 largely hidden, 3 unknown
  std::optional<Point2> velocity_mps{};  ///< over ground, vehicle axes
  std::optional<bool> moving{};
};

/// The ego vehicle's motion in the world frame.
struct TruthEgo {
  Pose2 world_from_vehicle;
  double vx_mps{0};
  double vy_mps{0};
  double yaw_rate_radps{0};
  double z_m{0};  ///< vehicle origin over the world's z = 0
  // Pose of the vehicle frame: the plane of the wheels' contacts.
  double pitch_rad{0};  ///< positive: nose down
  double roll_rad{0};   ///< positive: right side down
  // Pose of the left camera over that plane, in this frame. Height 0: unknown.
  double camera_height_m{0};
  double camera_pitch_rad{0};
  double camera_roll_rad{0};
};

/// Zone of a course: a hazard, or something harmless. A rectangle in the world frame.
struct TruthZone {
  std::string kind;
  bool is_hazard{false};
  Point2 low;
  Point2 high;
};

/// Grid and height limits of the true cells, in the vehicle frame.
struct TruthGrid {
  GridGeometry geometry;
  double height_min_m{0.15};
  double height_max_m{1.8};
  std::vector<TruthZone> zones{};  ///< zones of a course, by ascending x; else empty
};

/// Exact truth of one frame. Images are of the left camera; grids lie in the vehicle frame.
struct FrameTruth {
  std::string name;
  std::int64_t stamp_ns{0};
  TruthEgo ego;
  std::vector<TruthObject> objects;
  Image<float> disparity;            ///< px, 0 = none (sky), at the pixel centre
  Image<std::uint8_t> label;         ///< TruthLabel
  Image<std::uint16_t> instance;     ///< object id, 0 = none
  Image<std::uint8_t> seen_by_both;  ///< 255: the surface point is visible in the right image too
  Image<std::uint8_t> state;         ///< TruthCell, per cell
  Image<std::uint8_t> occupied;      ///< a footprint overlaps the cell, seen or not
  Image<std::int32_t> owner;         ///< id of the object on the cell, 0 = none
  Image<std::int32_t> pixels;        ///< obstacle pixels (within the height limits) that fall into the cell
  Image<std::int32_t> seen_object;   ///< id of the object most of those pixels belong to
  Image<std::uint8_t> free_points;   ///< 0–9 of the cell's 3 × 3 ground points seen
  Image<std::uint8_t> low;           ///< a low object (kerb, pavement, verge) lies on the cell
  Image<float> velocity_x;           ///< m/s in WORLD axes
  Image<float> velocity_y;
  // Scenes with uneven ground only; else empty.
  Image<std::uint8_t> terrain;  ///< TerrainCell
  Image<float> elevation_m;     ///< height of the ground at the cell's centre over the vehicle frame's plane
  Image<float> step_m;          ///< height of a drop (negative) or a step up; 0 elsewhere
};

}  // namespace stereogrid
