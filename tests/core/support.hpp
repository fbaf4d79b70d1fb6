// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../prelude.hpp"
#include "stereogrid/camera.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/image.hpp"
#include "stereogrid/pipeline.hpp"

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
  for (const auto [u, v] : raster(width, height))
    image(u, v) = static_cast<std::uint8_t>(texture.at(column_of(u, v), v) + 0.5);
  return image;
}

/// Independent grey levels.
Image<std::uint8_t> noise_image(int width, int height, std::mt19937& generator);

/// Same numbers on every machine, unlike std::uniform_real_distribution.
double uniform(std::mt19937& generator, double low, double high);
int uniform_int(std::mt19937& generator, int low, int high);
/// Standard deviation 1; the sum of twelve uniform numbers.
double gaussian(std::mt19937& generator);

/// Message of the Error that `action` throws; empty: it throws nothing.
template <class Error>
std::string error_text_of(const auto& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

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

/// NaN, too.
inline bool have_equal_bits(const Image<float>& a, const Image<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

inline void expect_equal(const GridLayers& a, const GridLayers& b) {
  EXPECT_EQ(a.geometry, b.geometry);
  for (const auto layer :
       {&GridLayers::occupancy, &GridLayers::velocity_x, &GridLayers::velocity_y, &GridLayers::age_s,
        &GridLayers::velocity_xx, &GridLayers::velocity_xy, &GridLayers::velocity_yy, &GridLayers::moving}) {
    EXPECT_TRUE(have_equal_bits(a.*layer, b.*layer));
  }
}

inline void expect_equal(const FrameResult& a, const FrameResult& b) {
  EXPECT_EQ(a.ground, b.ground);
  EXPECT_EQ(a.stages.obstacle_disparity, b.stages.obstacle_disparity);
  EXPECT_EQ(a.stages.road_disparity, b.stages.road_disparity);
  EXPECT_EQ(a.stages.possible, b.stages.possible);
  EXPECT_EQ(a.stages.visible, b.stages.visible);
  EXPECT_EQ(a.stages.observed, b.stages.observed);
  EXPECT_EQ(a.stages.occupancy_smooth, b.stages.occupancy_smooth);
  EXPECT_EQ(a.observed, b.observed);
  expect_equal(a.vehicle, b.vehicle);
  expect_equal(a.world, b.world);
  ASSERT_EQ(a.obstacles.size(), b.obstacles.size());
  for (std::size_t i{0}; i < a.obstacles.size(); ++i) {
    EXPECT_EQ(a.obstacles[i].id, b.obstacles[i].id);
    EXPECT_EQ(a.obstacles[i].x_m, b.obstacles[i].x_m);
    EXPECT_EQ(a.obstacles[i].y_m, b.obstacles[i].y_m);
    EXPECT_EQ(a.obstacles[i].vx_mps, b.obstacles[i].vx_mps);
    EXPECT_EQ(a.obstacles[i].vy_mps, b.obstacles[i].vy_mps);
  }
}

/// The vehicle's own bonnet in every frame of both cameras: an upright, textured surface below an arched line.
struct Bonnet {
  int top_row;       ///< highest image row of the bonnet
  double disparity;  ///< px
  int arch_px{6};    ///< difference to its row at the image's sides

  [[nodiscard]] bool covers(int u, int v, int width) const {
    const double x{(2.0 * u - width) / width};
    return v >= top_row + arch_px * x * x;
  }

  void paint(StereoFrame& frame) const {
    const Texture texture{91};
    const int width{frame.left.width()};
    for (const auto [u, v] : raster(0, width, top_row, frame.left.height())) {
      if (covers(u, v, width)) frame.left(u, v) = static_cast<std::uint8_t>(texture.at(u, v));
      const double in_left{u + disparity};
      if (covers(static_cast<int>(std::lround(in_left)), v, width)) {
        frame.right(u, v) = static_cast<std::uint8_t>(texture.at(in_left, v));
      }
    }
  }

  /// PipelineOptions::mask, which leaves a margin.
  [[nodiscard]] Image<std::uint8_t> mask(int width, int height, int margin_px) const {
    Image<std::uint8_t> mask{width, height, 255};
    for (const auto [u, v] : raster(width, height)) mask(u, v) = covers(u, v + margin_px, width) ? 0 : 255;
    return mask;
  }
};

}  // namespace stereogrid::test
