// SPDX-License-Identifier: Apache-2.0
#include "render/render.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stereogrid::scenes {
namespace {

constexpr int tile_px{16};
constexpr double near_m{0.05};

std::vector<Vector3> corners_of(const PlacedPart& part) {
  const Vector3 half{part.part->solid.half};
  std::vector<Vector3> corners;
  for (int i{0}; i < 8; ++i) {
    const double x{i & 1 ? half.x : -half.x};
    const double y{i & 2 ? half.y : -half.y};
    corners.push_back(part.centre + Vector3{part.heading.cosine * x - part.heading.sine * y,
                                            part.heading.sine * x + part.heading.cosine * y, i & 4 ? half.z : -half.z});
  }
  return corners;
}

/// The space between the corners' shadows on the lowest ground and on the highest one, or a pavement on it.
std::vector<Vector3> shadow_of(const std::vector<Vector3>& corners, const HeightField& ground) {
  constexpr double pavement_m{0.2};
  std::vector<Vector3> shadow;
  for (const Vector3& corner : corners) {
    for (const double height : {ground.lowest_m(), ground.highest_m() + pavement_m}) {
      const double t{std::max(0.0, corner.z - height) / to_sun.z};
      shadow.push_back({corner.x - t * to_sun.x, corner.y - t * to_sun.y, height});
    }
  }
  return shadow;
}

struct Bounds {
  double u_min{std::numeric_limits<double>::infinity()};
  double u_max{-std::numeric_limits<double>::infinity()};
  double v_min{std::numeric_limits<double>::infinity()};
  double v_max{-std::numeric_limits<double>::infinity()};
  double nearest_m{std::numeric_limits<double>::infinity()};

  void include(const Projection& at) {
    u_min = std::min(u_min, at.u);
    u_max = std::max(u_max, at.u);
    v_min = std::min(v_min, at.v);
    v_max = std::max(v_max, at.v);
    nearest_m = std::min(nearest_m, at.depth);
  }
};

/// Bounds of the hull of some points, cut off just ahead of the camera.
Bounds bounds_of(const Camera& camera, const std::vector<Vector3>& points) {
  Bounds bounds;
  for (const Vector3& a : points) {
    const Projection at{project(camera, a)};
    if (at.depth >= near_m) {
      bounds.include(at);
      continue;
    }
    for (const Vector3& b : points) {
      const double depth_b{dot(b - camera.position, camera.forward)};
      if (depth_b <= near_m) continue;
      Projection cut{project(camera, a + ((near_m - at.depth) / (depth_b - at.depth)) * (b - a))};
      bounds.include(cut);
    }
  }
  return bounds;
}

Camera camera_of(const Rig& rig, const Frame3& vehicle, double right_m) {
  const Direction pitch{direction_of(rig.camera_pitch_rad)};
  const Direction roll{direction_of(rig.camera_roll_rad)};
  Camera camera{rig.width_px, rig.height_px, rig.focal_px, rig.cx_px, rig.cy_px, {}, {}, {}, {}};
  camera.forward = pitch.cosine * vehicle.forward - pitch.sine * vehicle.up;
  const Vector3 below{-pitch.sine * vehicle.forward - pitch.cosine * vehicle.up};
  const Vector3 beside{-1 * vehicle.left};
  camera.down = roll.cosine * below - roll.sine * beside;
  camera.right = roll.cosine * beside + roll.sine * below;
  camera.position = vehicle.origin + rig.camera_height_m * vehicle.up + right_m * camera.right;
  return camera;
}

}  // namespace

Camera left_camera(const Rig& rig, const Frame3& vehicle) {
  return camera_of(rig, vehicle, 0);
}

Camera right_camera(const Rig& rig, const Frame3& vehicle) {
  return camera_of(rig, vehicle, rig.baseline_m);
}

Projection project(const Camera& camera, Vector3 point) {
  const Vector3 offset{point - camera.position};
  const double depth{dot(offset, camera.forward)};
  return {camera.cx_px + camera.focal_px * dot(offset, camera.right) / depth,
          camera.cy_px + camera.focal_px * dot(offset, camera.down) / depth, depth};
}

bool inside(const Camera& camera, const Projection& at) {
  return at.depth > near_m && at.u >= -0.5 && at.v >= -0.5 && at.u < camera.width_px - 0.5 &&
         at.v < camera.height_px - 0.5;
}

Caster::Caster(const Camera& camera, const std::vector<PlacedPart>& parts, const HeightField& ground)
    : camera_{camera},
      parts_{parts},
      ground_{ground},
      tiles_across_{(camera.width_px + tile_px - 1) / tile_px},
      tiles_down_{(camera.height_px + tile_px - 1) / tile_px},
      visible_(static_cast<std::size_t>(tiles_across_ * tiles_down_)),
      shadowing_(visible_.size()) {
  for (std::size_t i{0}; i < parts.size(); ++i) {
    origins_.push_back(turned_into(parts[i], camera.position - parts[i].centre));
    const std::vector<Vector3> corners{corners_of(parts[i])};
    enlist(visible_, static_cast<int>(i), corners);
    if (parts[i].body->label == TruthLabel::obstacle)
      enlist(shadowing_, static_cast<int>(i), shadow_of(corners, ground));
  }
  for (auto& tile : visible_) {
    std::stable_sort(tile.begin(), tile.end(),
                     [](const Candidate& a, const Candidate& b) { return a.nearest_m < b.nearest_m; });
  }
}

void Caster::enlist(Tiles& tiles, int part, const std::vector<Vector3>& hull) const {
  const Bounds bounds{bounds_of(camera_, hull)};
  if (bounds.u_min > bounds.u_max) return;
  // A tile also serves the half pixel around it, where rays between pixels are cast.
  const auto tile = [](double pixel, int last) {
    return static_cast<int>(std::clamp(std::floor(pixel / tile_px), -1.0, last + 1.0));
  };
  const int first_u{std::max(tile(bounds.u_min - 1, tiles_across_), 0)};
  const int last_u{std::min(tile(bounds.u_max + 1, tiles_across_), tiles_across_ - 1)};
  const int first_v{std::max(tile(bounds.v_min - 1, tiles_down_), 0)};
  const int last_v{std::min(tile(bounds.v_max + 1, tiles_down_), tiles_down_ - 1)};
  for (int v{first_v}; v <= last_v; ++v) {
    for (int u{first_u}; u <= last_u; ++u) {
      tiles[static_cast<std::size_t>(v * tiles_across_ + u)].push_back({bounds.nearest_m, part});
    }
  }
}

std::size_t Caster::tile_of(double u, double v) const {
  const int tile_u{std::clamp(static_cast<int>(u) / tile_px, 0, tiles_across_ - 1)};
  const int tile_v{std::clamp(static_cast<int>(v) / tile_px, 0, tiles_down_ - 1)};
  return static_cast<std::size_t>(tile_v * tiles_across_ + tile_u);
}

Hit Caster::ground_hit(Vector3 ray) const {
  if (ground_.is_flat()) {
    if (ray.z >= 0) return {};
    return {Hit::road, -camera_.position.z / ray.z, {0, 0, 1}};
  }
  HeightField::Crossing crossing;
  if (!ground_.crosses(camera_.position, ray, crossing)) return {};
  return {Hit::road, crossing.t, crossing.normal, crossing.is_wall};
}

Hit Caster::trace(double u, double v) const {
  const Vector3 ray{camera_.ray(u, v)};
  Hit hit{ground_hit(ray)};
  double nearest{hit.part == Hit::road ? hit.depth : std::numeric_limits<double>::infinity()};
  for (const Candidate& candidate : visible_[tile_of(u, v)]) {
    if (candidate.nearest_m >= nearest) break;
    const auto index = static_cast<std::size_t>(candidate.part);
    Entry entry;
    if (!enters(parts_[index].part->solid, origins_[index], turned_into(parts_[index], ray), nearest, entry)) continue;
    nearest = entry.t;
    hit = {candidate.part, nearest, entry.normal};
  }
  return hit;
}

bool Caster::in_shadow(double u, double v, Vector3 point) const {
  const auto& candidates = shadowing_[tile_of(u, v)];
  return std::any_of(candidates.begin(), candidates.end(), [&](const Candidate& candidate) {
    const PlacedPart& part{parts_[static_cast<std::size_t>(candidate.part)]};
    Entry entry;
    return enters(part.part->solid, turned_into(part, point - part.centre), turned_into(part, to_sun), 1e3, entry);
  });
}

}  // namespace stereogrid::scenes
