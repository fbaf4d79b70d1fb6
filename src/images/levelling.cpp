// SPDX-License-Identifier: Apache-2.0
#include "images/levelling.hpp"

#include <cmath>

#include "backend/cpu.hpp"

namespace stereogrid {
namespace {

constexpr int rows_grain{16};

std::uint8_t interpolated(View<const std::uint8_t> image, double u, double v) {
  if (!(u >= 0 && v >= 0 && u <= image.width - 1 && v <= image.height - 1)) return 0;
  const int left{static_cast<int>(u)};
  const int top{static_cast<int>(v)};
  const int right{left + 1 < image.width ? left + 1 : left};
  const int bottom{top + 1 < image.height ? top + 1 : top};
  const double fu{u - left};
  const double fv{v - top};
  const double upper{(1 - fu) * image(left, top) + fu * image(right, top)};
  const double lower{(1 - fu) * image(left, bottom) + fu * image(right, bottom)};
  return static_cast<std::uint8_t>((1 - fv) * upper + fv * lower + 0.5);
}

float nearest(View<const float> image, double u, double v) {
  if (!(u > -0.5 && v > -0.5 && u < image.width - 0.5 && v < image.height - 0.5)) return 0;
  return image(static_cast<int>(u + 0.5), static_cast<int>(v + 0.5));
}

}  // namespace

Levelling::Levelling(const Rig& rig)
    : mapping_{rig},
      centre_v_px_{rig.cy_px},
      sin_pitch_{std::sin(rig.camera_pitch_rad)},
      cos_pitch_{std::cos(rig.camera_pitch_rad)} {}

template <class Pixel>
void Levelling::for_pixels(Cpu& cpu, View<Pixel> level, const auto& pixel_at) const {
  cpu.for_ranges(level.height, rows_grain, [&](int begin, int end) {
    for (int v{begin}; v < end; ++v) {
      const TurnedRow pitched{level_rig(), centre_v_px_, sin_pitch_, cos_pitch_, static_cast<double>(v)};
      for (int u{0}; u < level.width; ++u) {
        level(u, v) = pitched.depth > 0 ? pixel_at(pitched.u_of(u), pitched.v, pitched.depth) : Pixel{0};
      }
    }
  });
}

void Levelling::apply(Cpu& cpu, View<const std::uint8_t> pitched, View<std::uint8_t> level) const {
  for_pixels(cpu, level, [pitched](double u, double v, double) { return interpolated(pitched, u, v); });
}

void Levelling::apply(Cpu& cpu, View<const float> pitched, View<float> level) const {
  // d = f·b/Z, and a point at depth Z along the level axis is at Z·depth along the pitched one
  for_pixels(cpu, level, [pitched](double u, double v, double depth) {
    return nearest(pitched, u, v) * static_cast<float>(depth);
  });
}

}  // namespace stereogrid
