// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "stereogrid/camera.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid::test {

/// A small car's camera: 621 × 188, f·b = 194 px·m.
Rig small_kitti_rig();

/// FilterConfig::speeds_mps in even steps.
std::vector<double> uniform_speeds(double step_mps, int count);

/// A function of the plane that looks like plaster: smooth, of no period, within 20 … 180 grey levels. It can be
/// sampled anywhere, so that sub-pixel shifts are exact.
class Texture {
 public:
  explicit Texture(unsigned seed);
  [[nodiscard]] double at(double u, double v) const;

 private:
  struct Wave {
    double per_u;
    double per_v;
    double phase;
  };
  std::vector<Wave> waves_;
};

/// image(u, v) = texture at (column_of(u, v), v).
template <class ColumnOf>
Image<std::uint8_t> textured_image(const Texture& texture, int width, int height, const ColumnOf& column_of) {
  Image<std::uint8_t> image{width, height};
  for (int v{0}; v < height; ++v) {
    for (int u{0}; u < width; ++u) image(u, v) = static_cast<std::uint8_t>(texture.at(column_of(u, v), v) + 0.5);
  }
  return image;
}

/// Independent grey levels.
Image<std::uint8_t> noise_image(int width, int height, std::mt19937& generator);

/// Same numbers on every machine, unlike std::uniform_real_distribution.
double uniform(std::mt19937& generator, double low, double high);
int uniform_int(std::mt19937& generator, int low, int high);
/// Standard deviation 1; the sum of twelve uniform numbers.
double gaussian(std::mt19937& generator);

/// Elements that differ, bit for bit.
template <class T>
int count_differences(const Image<T>& a, const Image<T>& b) {
  if (a.width() != b.width() || a.height() != b.height()) return -1;
  int different{0};
  for (std::size_t i{0}; i < a.size(); ++i) different += a.data()[i] == b.data()[i] ? 0 : 1;
  return different;
}

constexpr double pi{3.14159265358979323846};
constexpr double degree{pi / 180};

}  // namespace stereogrid::test
