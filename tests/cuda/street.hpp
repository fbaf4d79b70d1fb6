// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "stereogrid/camera.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid::test {

/// A road with upright boards on it, seen from a moving car. Drawn here, so that a machine without the project's other
/// packages can test and measure.
class Street {
 public:
  /// `pitch_rad`: of the camera, which `rig` does not know.
  explicit Street(const Rig& rig, double pitch_rad = 0) : rig_{rig}, pitch_rad_{pitch_rad} {}

  /// A rig whose camera sees 66° across, at any image size.
  static Rig rig(int width, int height) {
    const double focal{width * 0.77};
    return {width, height, focal, width / 2.0 - 0.5, height * 0.45, 0.54, 1.5, 0, 0};
  }

  [[nodiscard]] StereoFrame frame(int index) const {
    StereoFrame result;
    result.index = index;
    result.name = std::to_string(index);
    result.stamp_ns = index * 100'000'000LL;
    const double driven_m{0.5 * index};
    result.world_from_vehicle = Pose2{driven_m, 0, 0.002 * index};
    result.left = image(driven_m, index, 0);
    result.right = image(driven_m, index, rig_.baseline_m);
    return result;
  }

 private:
  /// An upright board: its distance at the start, its speed ahead, from where to where (m to the right), how high.
  struct Board {
    double x_m;
    double speed_mps;
    double right_begin_m;
    double right_end_m;
    double height_m;
  };
  static constexpr Board boards[]{
      {9, 5, -0.3, 1.4, 1.5}, {12, 0, -4.5, -2.5, 1.6}, {15, -2, 2.6, 4.2, 1.7}, {40, 0, -60, 60, 6}};

  static double hash(int a, int b, int seed) {
    std::uint32_t x{static_cast<std::uint32_t>(a) * 0x9E3779B1U ^ static_cast<std::uint32_t>(b) * 0x85EBCA77U ^
                    static_cast<std::uint32_t>(seed) * 0xC2B2AE3DU};
    x = (x ^ x >> 15) * 0x2C1B3C6DU;
    x = (x ^ x >> 12) * 0x297A2D39U;
    return static_cast<double>(x >> 8 & 0xffffU) / 65535;
  }

  // Smooth noise in 0 … 1.
  static double noise(double a, double b, int seed) {
    const int ia{static_cast<int>(std::floor(a))};
    const int ib{static_cast<int>(std::floor(b))};
    const double fa{a - ia};
    const double fb{b - ib};
    return (1 - fb) * ((1 - fa) * hash(ia, ib, seed) + fa * hash(ia + 1, ib, seed)) +
           fb * ((1 - fa) * hash(ia, ib + 1, seed) + fa * hash(ia + 1, ib + 1, seed));
  }
  static double texture(double a, double b, int seed) {
    return 40 + 110 * noise(a * 3, b * 3, seed) + 60 * noise(a * 11, b * 11, seed + 100);
  }

  // Grey level seen along a ray: per metre ahead it goes `right` m to the right and `down` m down.
  [[nodiscard]] double grey(double right, double down, double camera_m, double driven_m, int index) const {
    double nearest{down > 1e-6 ? rig_.camera_height_m / down : 1e9};
    double value{nearest < 300 ? texture(camera_m + right * nearest, driven_m + nearest, 7) : 210};
    int seed{0};
    for (const Board& board : boards) {
      ++seed;
      const double ahead{board.x_m + board.speed_mps * 0.1 * index - driven_m};
      const double at{camera_m + right * ahead};
      const double up{rig_.camera_height_m - down * ahead};
      if (ahead < 1 || ahead >= nearest || at < board.right_begin_m || at > board.right_end_m || up < 0 ||
          up > board.height_m) {
        continue;
      }
      nearest = ahead;
      value = texture(at, up, seed);
    }
    return value;
  }

  [[nodiscard]] Image<std::uint8_t> image(double driven_m, int index, double camera_m) const {
    Image<std::uint8_t> result{rig_.width_px, rig_.height_px};
    const double c{std::cos(pitch_rad_)};
    const double s{std::sin(pitch_rad_)};
    for (int v{0}; v < rig_.height_px; ++v) {
      const double y{(v - rig_.cy_px) / rig_.focal_px};
      const double ahead{c - s * y};
      for (int u{0}; u < rig_.width_px; ++u) {
        const double x{(u - rig_.cx_px) / rig_.focal_px};
        result(u, v) = static_cast<std::uint8_t>(grey(x / ahead, (s + c * y) / ahead, camera_m, driven_m, index) + 0.5);
      }
    }
    return result;
  }

  Rig rig_;
  double pitch_rad_;
};

}  // namespace stereogrid::test
