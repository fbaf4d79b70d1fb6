// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stereogrid/frame.hpp"
#include "world/height_field.hpp"

namespace stereogrid::scenes {

/// Axes and origin of a frame in the world.
struct Frame3 {
  Vector3 origin;
  Vector3 forward{1, 0, 0};
  Vector3 left{0, 1, 0};
  Vector3 up{0, 0, 1};

  [[nodiscard]] Vector3 into(Vector3 world) const {
    const Vector3 offset{world - origin};
    return {dot(forward, offset), dot(left, offset), dot(up, offset)};
  }
  [[nodiscard]] Vector3 back(Vector3 local) const { return origin + local.x * forward + local.y * left + local.z * up; }
};

/// Contact points of the wheels: ahead of the camera, behind it, and to either side.
struct Wheels {
  double front_m{0.9};
  double rear_m{1.8};
  double half_track_m{0.75};
};

/// The vehicle frame of a vehicle that stands on the ground: the plane of its wheels' contacts.
[[nodiscard]] Frame3 standing_at(const HeightField& ground, const Pose2& pose, const Wheels& wheels);

}  // namespace stereogrid::scenes
