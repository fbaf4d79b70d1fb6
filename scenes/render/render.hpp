// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <tbb/parallel_for.h>

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <typeinfo>
#include <vector>

#include "stereogrid/camera.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/image.hpp"
#include "world/world.hpp"

namespace stereogrid::scenes {

/// Calls work(row) for `count` rows, on all cores. Throws DeviceError where a thread cannot be started: oneTBB throws a
/// plain std::runtime_error then.
template <class Work>
void for_rows(int count, const Work& work) {
  try {
    tbb::parallel_for(0, count, work);
  } catch (const std::runtime_error& error) {
    if (typeid(error) != typeid(std::runtime_error)) throw;
    throw DeviceError{std::string{"a thread cannot be started: "} + error.what() +
                      ". Allow more threads or address space (ulimit -u, ulimit -v, the container's limits)."};
  }
}

/// A pinhole camera in the world frame.
struct Camera {
  int width_px{0};
  int height_px{0};
  double focal_px{0};
  double cx_px{0};
  double cy_px{0};
  Vector3 position;
  Vector3 right;
  Vector3 down;
  Vector3 forward;

  /// Direction of a pixel, scaled to depth 1: position + depth · ray.
  [[nodiscard]] Vector3 ray(double u, double v) const {
    return forward + ((u - cx_px) / focal_px) * right + ((v - cy_px) / focal_px) * down;
  }
};

/// The rig's cameras on a vehicle.
[[nodiscard]] Camera left_camera(const Rig& rig, const Frame3& vehicle);
[[nodiscard]] Camera right_camera(const Rig& rig, const Frame3& vehicle);

/// Projection of a point. Depth ≤ 0: behind the camera, u and v are undefined.
struct Projection {
  double u{0};
  double v{0};
  double depth{0};
};
[[nodiscard]] Projection project(const Camera& camera, Vector3 point);
/// Inside the image, which reaches half a pixel beyond the outermost pixel centres.
[[nodiscard]] bool inside(const Camera& camera, const Projection& at);

/// First intersection of a ray.
struct Hit {
  static constexpr int sky{-2};
  static constexpr int road{-1};

  int part{sky};        ///< index into the placed parts, or road, or sky
  double depth{0};      ///< along the camera's axis
  Vector3 normal;       ///< in the part's own frame; of the road in the world's
  bool is_wall{false};  ///< a vertical side of the ground
};

/// Casts rays from one camera. Stores for every tile of the image the parts that can appear in it.
class Caster {
 public:
  Caster(const Camera& camera, const std::vector<PlacedPart>& parts, const HeightField& ground);

  /// Hit of the ray through a place in the image, also between pixels.
  [[nodiscard]] Hit trace(double u, double v) const;
  /// Whether bodies hide the sun from a point on the ground (or not far above it) that is seen there.
  [[nodiscard]] bool in_shadow(double u, double v, Vector3 point) const;

  [[nodiscard]] const Camera& camera() const { return camera_; }
  [[nodiscard]] const std::vector<PlacedPart>& parts() const { return parts_; }

 private:
  struct Candidate {
    double nearest_m{0};
    int part{0};
  };
  using Tiles = std::vector<std::vector<Candidate>>;

  [[nodiscard]] std::size_t tile_of(double u, double v) const;
  [[nodiscard]] Hit ground_hit(Vector3 ray) const;
  void enlist(Tiles& tiles, int part, const std::vector<Vector3>& hull) const;

  Camera camera_;
  const std::vector<PlacedPart>& parts_;
  const HeightField& ground_;
  int tiles_across_;
  int tiles_down_;
  std::vector<Vector3> origins_;  ///< the camera in each part's frame
  Tiles visible_;                 ///< sorted by distance
  Tiles shadowing_;
};

/// A vector of the world in a part's own frame.
[[nodiscard]] inline Vector3 turned_into(const PlacedPart& part, Vector3 v) {
  return {part.heading.cosine * v.x + part.heading.sine * v.y, -part.heading.sine * v.x + part.heading.cosine * v.y,
          v.z};
}

/// Direction to the sun, unit length, world frame.
constexpr Vector3 to_sun{-0.36, 0.48, 0.8};

/// Noise and response of the sensor.
struct Sensor {
  double gain{1};
  double noise_grey{0};
  std::uint64_t seed{0};
};

/// Renders the image of the caster's camera. Runs on the threads of the current TBB arena.
[[nodiscard]] Image<std::uint8_t> render(const World& world, const Caster& caster, const Sensor& sensor);

}  // namespace stereogrid::scenes
