// SPDX-License-Identifier: Apache-2.0
#include "motion/scene_flow.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "motion/ego_error.hpp"
#include "motion/patch_search.hpp"
#include "painted_obstacles.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

constexpr double dt_s{0.1};

// A textured wall across the view, at a place of its own in every frame; the vehicle drives along x.
class Street {
 public:
  Street(Point2 wall, Point2 wall_velocity, double vehicle_mps = 0)
      : wall_{wall}, wall_velocity_{wall_velocity}, vehicle_mps_{vehicle_mps} {}

  // One more frame through scene flow.
  void step(SceneFlow& flow) {
    const double t_s{dt_s * frame_};
    const Point2 wall{wall_.x + (wall_velocity_.x - vehicle_mps_) * t_s, wall_.y + wall_velocity_.y * t_s};
    const double disparity{rig.focal_px * rig.baseline_m / wall.x};
    const Image<std::uint8_t> left{view_of(wall, 0)};
    const Image<std::uint8_t> right{view_of(wall, disparity, right_rows_off)};
    FlowFrame frame{left.view(), right.view(), {}, {vehicle_mps_ * t_s, 0, 0}, frame_ == 0 ? 0 : dt_s};
    Image<float> external{rig.width_px, rig.height_px};
    external.fill(static_cast<float>(disparity));
    if (is_external) {
      frame.right = {};
      frame.disparity = external.view();
    }
    Matches matches{rig.width_px, rig.height_px};
    for (int v{first_matched_row}; v < std::min(end_of_matched_rows, rig.height_px); ++v) {
      std::fill_n(matches.obstacle.row(v), rig.width_px, static_cast<float>(disparity + 0.2));  // as matching errs
    }
    const auto here = [](int count, const auto& work) { work(0, count); };
    flow.follow(frame, here);
    flow.add_points(frame, matches, here);
    ++frame_;
  }

  Rig rig{small_kitti_rig()};
  int right_rows_off{0};
  bool is_external{false};  ///< disparities in place of the right image
  int first_matched_row{0};
  int end_of_matched_rows{rig.height_px};
  /// Grey level by the place on the wall, in 40ths of a metre.
  std::function<double(double, double)> shade{[texture = Texture{7}](double x, double y) { return texture.at(x, y); }};

 private:
  // Metres of the wall are 40 px of its texture, so that it grows as it comes near.
  [[nodiscard]] Image<std::uint8_t> view_of(Point2 wall, double disparity, int rows_off = 0) const {
    Image<std::uint8_t> image{rig.width_px, rig.height_px};
    const double scale{40 * wall.x / rig.focal_px};
    for (const auto [u, v] : raster(rig.width_px, rig.height_px)) {
      const double across{scale * (u + disparity - rig.cx_px) + 40 * wall.y};
      image(u, v) = static_cast<std::uint8_t>(shade(across, scale * (v - rows_off - rig.cy_px)) + 0.5);
    }
    return image;
  }

  Point2 wall_;
  Point2 wall_velocity_;
  double vehicle_mps_;
  int frame_{0};
};

double median(const std::vector<FlowVector>& vectors, double Point2::*axis) {
  std::vector<double> values;
  for (const FlowVector& vector : vectors) values.push_back(vector.velocity.*axis);
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

TEST(SceneFlow, MeasuresVelocitiesByExternalDisparities) {
  for (const Point2 velocity : {Point2{0, 0}, Point2{0, 3}, Point2{-5, 0}, Point2{4, 1.5}}) {
    Street street{{12, 0}, velocity};
    street.is_external = true;
    SceneFlow flow{street.rig};
    for (int i{0}; i < 5; ++i) street.step(flow);
    ASSERT_GT(flow.vectors().size(), 20U);
    EXPECT_NEAR(median(flow.vectors(), &Point2::x), velocity.x, 0.05);
    EXPECT_NEAR(median(flow.vectors(), &Point2::y), velocity.y, 0.05);
  }
}

TEST(SceneFlow, MeasuresVelocities) {
  for (const Point2 velocity : {Point2{0, 0}, Point2{0, 3}, Point2{0, -6}, Point2{-5, 0}, Point2{4, 1.5}}) {
    SCOPED_TRACE(testing::Message() << velocity.x << ", " << velocity.y << " m/s");
    Street street{{9, 0}, velocity};
    SceneFlow flow{street.rig};
    for (int i{0}; i < 6; ++i) street.step(flow);
    ASSERT_GT(flow.vectors().size(), 40u);
    EXPECT_NEAR(median(flow.vectors(), &Point2::x), velocity.x, 0.3);
    EXPECT_NEAR(median(flow.vectors(), &Point2::y), velocity.y, 0.15);
  }
}

TEST(SceneFlow, WhatStandsStandsForADrivingCamera) {
  Street street{{12, 0}, {0, 0}, 8};
  SceneFlow flow{street.rig};
  for (int i{0}; i < 6; ++i) street.step(flow);
  ASSERT_GT(flow.vectors().size(), 40u);
  EXPECT_NEAR(median(flow.vectors(), &Point2::x), 0, 0.3);
  EXPECT_NEAR(median(flow.vectors(), &Point2::y), 0, 0.15);
}

// Its texture grows by a sixth in a frame.
TEST(SceneFlow, FollowsAnOncomingCar) {
  Street street{{16, 0}, {-8, 0}, 8};
  SceneFlow flow{street.rig};
  for (int i{0}; i < 5; ++i) street.step(flow);
  EXPECT_GT(flow.vectors().size(), 40u);
  EXPECT_NEAR(median(flow.vectors(), &Point2::x), -8, 0.2);
}

TEST(SceneFlow, SmoothsByTheBinomial) {
  Image<std::uint8_t> image{600, 5, 32};
  image(255, 2) = 48;
  image(599, 4) = 80;
  Image<std::uint8_t> smoothed{600, 5};
  smooth_rows(image.view(), 0, 3, smoothed.view());
  smooth_rows(image.view(), 3, 5, smoothed.view());
  EXPECT_EQ(smoothed(255, 2), 36);
  EXPECT_EQ(smoothed(256, 2), 34);
  EXPECT_EQ(smoothed(254, 1), 33);
  EXPECT_EQ(smoothed(255, 3), 34);
  EXPECT_EQ(smoothed(0, 0), 32);
  EXPECT_EQ(smoothed(599, 4), 59);  // the border repeats: 9 of 16 parts
  EXPECT_EQ(smoothed(598, 3), 35);
}

TEST(SceneFlow, IsLessSureAlongTheRayAndAtFirst) {
  Street street{{12, 0}, {0, 0}};
  SceneFlow flow{street.rig};
  street.step(flow);
  EXPECT_TRUE(flow.vectors().empty()) << "a point that has been seen once says nothing";
  street.step(flow);
  ASSERT_FALSE(flow.vectors().empty());
  const auto spread = [&] {
    const FlowVector& vector{*std::min_element(
        flow.vectors().begin(), flow.vectors().end(),
        [](const FlowVector& a, const FlowVector& b) { return std::abs(a.place.y) < std::abs(b.place.y); })};
    EXPECT_GT(vector.place_covariance.xx, 10 * vector.place_covariance.yy);
    EXPECT_NEAR(vector.place.x, 12, 0.5);
    return vector.velocity_covariance.xx;
  };
  const double at_first{spread()};
  for (int i{0}; i < 5; ++i) street.step(flow);
  EXPECT_LT(spread(), at_first / 4);
}

TEST(SceneFlow, LosesWhatIsNoLongerThereAndDropsOnRequest) {
  Street street{{9, 0}, {0, 0}};
  SceneFlow flow{street.rig};
  for (int i{0}; i < 3; ++i) street.step(flow);
  ASSERT_FALSE(flow.vectors().empty());
  const Image<std::uint8_t> grey{street.rig.width_px, street.rig.height_px, std::uint8_t{90}};
  const auto here = [](int count, const auto& work) { work(0, count); };
  flow.follow({grey.view(), grey.view(), {}, {}, dt_s}, here);
  EXPECT_TRUE(flow.vectors().empty());

  for (int i{0}; i < 3; ++i) street.step(flow);
  ASSERT_FALSE(flow.vectors().empty());
  flow.clear();
  EXPECT_TRUE(flow.vectors().empty());
}

std::size_t vectors_of(Street street, int frames = 2) {
  SceneFlow flow{street.rig};
  for (int i{0}; i < frames; ++i) street.step(flow);
  return flow.vectors().size();
}

// Aperture problem: a horizontal edge may slide along itself.
TEST(SceneFlow, HorizontalEdgesAreNotFollowed) {
  for (const auto& [contrast, is_followed] : {std::pair{10.0, false}, {15.0, true}}) {
    Street street{{9, 0}, {0, 0}};
    street.shade = [contrast = contrast](double x, double y) {
      return 100 + 60 * std::sin(y / 3) + contrast * std::sin(x / 2.5) * std::cos(y / 9);
    };
    const std::size_t vectors{vectors_of(street)};
    EXPECT_TRUE(is_followed ? vectors > 20 : vectors == 0) << contrast << ": " << vectors;
  }
}

TEST(SceneFlow, ARightImageOfOtherRowsHasNoPoints) {
  for (const int rows : {0, 2, -2}) {
    Street street{{9, 0}, {0, 0}};
    street.right_rows_off = rows;
    const std::size_t vectors{vectors_of(street)};
    EXPECT_TRUE(rows == 0 ? vectors > 40 : vectors < 4) << rows << ": " << vectors;
  }
}

// A crown hangs above moving objects.
TEST(SceneFlow, WhatIsHigherThanThreeMetresIsNotFollowed) {
  Street street{{20, 0}, {0, 0}};
  const auto row_at = [&](double height_m) {
    return static_cast<int>(street.rig.cy_px - (height_m - street.rig.camera_height_m) * street.rig.focal_px / 20);
  };
  street.end_of_matched_rows = row_at(3.2);
  ASSERT_GT(street.end_of_matched_rows, 24);
  EXPECT_EQ(vectors_of(street), 0u);
  street.first_matched_row = row_at(2.8);
  street.end_of_matched_rows = street.rig.height_px;
  EXPECT_GT(vectors_of(street), 40u);
}

// Whether another place fits nearly as well does not depend on the order in which places are compared.
TEST(SceneFlow, SearchesAlikeFromBothSides) {
  constexpr int width{120};
  constexpr int middle_v{15};
  constexpr int columns{40};
  constexpr int trials{400};
  std::mt19937 generator{5};
  const auto random = [&](int range) {
    return static_cast<int>(generator() % static_cast<unsigned>(2 * range + 1)) - range;
  };
  int found{0};
  for (int trial{0}; trial < trials; ++trial) {
    // columns of slowly changing shades, and the same with noise
    Image<std::uint8_t> image{width, 2 * middle_v + 1};
    Image<std::uint8_t> noisy{width, image.height()};
    int shade{128};
    for (int u{0}; u < width; ++u) {
      shade = std::clamp(shade + random(8), 60, 195);
      for (int v{0}; v < image.height(); ++v) {
        image(u, v) = static_cast<std::uint8_t>(shade);
        noisy(u, v) = static_cast<std::uint8_t>(shade + random(trial % 60));
      }
    }
    const auto mirrored = [&](const Image<std::uint8_t>& of) {
      Image<std::uint8_t> mirror{width, of.height()};
      for (const auto [u, v] : raster(width, of.height())) mirror(u, v) = of(width - 1 - u, v);
      return mirror;
    };
    const auto search = [&](const Image<std::uint8_t>& from, const Image<std::uint8_t>& in) {
      constexpr Place middle{width / 2, middle_v};
      ScaledPatch patch;
      EXPECT_TRUE(patch.take(from.view(), middle, 1));
      return searched(patch, in.view(), middle, columns, 0);
    };
    const auto here = search(image, noisy);
    const auto there = search(mirrored(image), mirrored(noisy));
    ASSERT_EQ(here.has_value(), there.has_value()) << trial;
    if (!here) continue;
    EXPECT_EQ(here->u, static_cast<float>(width) - there->u) << trial;
    ++found;
  }
  EXPECT_GT(found, trials / 10);
  EXPECT_LT(found, trials * 9 / 10);
}

// Pickets of 12 px that have moved by nearly 2.5 of them, 29.5 px: several fit alike, and none of them is taken.
TEST(SceneFlow, APicketFenceIsNotSearchedAtRandom) {
  for (const bool has_pickets : {true, false}) {
    Street street{{9, 0}, {0, 29.5 / dt_s * 9 / small_kitti_rig().focal_px}};
    if (has_pickets) {
      const double period{12 * 40 * 9 / street.rig.focal_px};
      street.shade = [period](double x, double y) {
        return 100 + 60 * std::sin(2 * std::numbers::pi * x / period) + 20 * std::sin(y / 3);
      };
    }
    const std::size_t vectors{vectors_of(street, 2)};
    EXPECT_TRUE(has_pickets ? vectors < 10 : vectors > 40) << has_pickets << ": " << vectors;
  }
}

constexpr double speed_mps{10};
constexpr double focal_baseline{80};  // PaintedObstacles

using Vectors = std::vector<FlowVector>;

// Drives along x for two seconds. `vectors(x)`: of the frame with the vehicle at x.
template <class VectorsAt>
struct Drive {
  explicit Drive(const VectorsAt& vectors, double speed = speed_mps) {
    for (int frame{0}; frame <= 20; ++frame) {
      last = vectors(frame * dt_s * speed);
      error.correct({frame * dt_s * speed, 0}, dt_s, last);
    }
  }
  EgoError error{PaintedObstacles::rig(), 100};
  Vectors last;
};

// Static objects in eight sectors, 6 to 20 m ahead of the vehicle at x. `velocity(m)` ahead.
template <class Velocity>
Vectors static_scene(double x, const Velocity& velocity) {
  Vectors vectors;
  for (int object{0}; object < 8; ++object) {
    const double ahead_m{6.0 + 2 * object};
    const double y{ahead_m * (0.12 * object - 0.4)};
    for (int i{0}; i < 4; ++i) vectors.push_back(vector_at({x + ahead_m, y}, {velocity(ahead_m), 0}));
  }
  return vectors;
}

void add_object(Point2 at, Point2 velocity, Vectors& vectors) {
  for (int i{0}; i < 6; ++i) vectors.push_back(vector_at(at, velocity));
}

TEST(EgoError, ScaleOfTheMotionIsMeasuredAndRemoved) {
  const Drive drive{[](double x) { return static_scene(x, [](double) { return 0.07 * speed_mps; }); }};
  for (const FlowVector& vector : drive.last) EXPECT_NEAR(vector.velocity.x, 0, 0.15);
  EXPECT_LT(drive.last.front().common_covariance.xx, 0.3 * 0.3);
  EXPECT_EQ(drive.last.front().common_covariance.yy, 0) << "only along the motion";
}

// Disparities that are too small by 0.5 px, and the true motion.
TEST(EgoError, OffsetOfTheDisparitiesIsMeasuredAndRemoved) {
  const auto seeming = [](double ahead_m) { return -2 * 0.5 * ahead_m / focal_baseline * speed_mps; };
  const Drive drive{[&](double x) { return static_scene(x, seeming); }};
  EXPECT_GT(drive.error.offset_px(), 0.3);
  for (const FlowVector& vector : drive.last) EXPECT_NEAR(vector.velocity.x, 0, 0.2);
}

TEST(EgoError, MovingObjectsAmongStaticOnesKeepTheirVelocity) {
  const Drive drive{[](double x) {
    Vectors vectors{static_scene(x, [](double) { return 0.0; })};
    add_object({x + 8, 4.5}, {1.4, 0}, vectors);     // a pedestrian in the vehicle's direction
    add_object({x + 15, -7.5}, {-1.4, 0}, vectors);  // and another one
    add_object({x + 12, 1}, {speed_mps, 0}, vectors);
    return vectors;
  }};
  const FlowVector& pedestrian{drive.last[32]};
  EXPECT_NEAR(pedestrian.velocity.x, 1.4, 0.2);
  EXPECT_NEAR(drive.last.back().velocity.x, speed_mps, 0.2);
  EXPECT_GT(pedestrian.velocity.x * pedestrian.velocity.x, 9 * pedestrian.common_covariance.xx) << "still significant";
}

// One object says nothing about the ego-motion, however many features it has.
TEST(EgoError, AnObjectAloneIsNoMeasurement) {
  const Drive drive{[](double x) {
    Vectors vectors;
    add_object({x + 8, 1}, {1.4, 0}, vectors);
    return vectors;
  }};
  EXPECT_EQ(drive.error.scale(), 0);
  EXPECT_EQ(drive.last.front().velocity.x, 1.4);
  const double scale_mps{0.05 * speed_mps};
  const double offset_mps{2 * 0.5 * 8 / focal_baseline * speed_mps};
  EXPECT_NEAR(drive.last.front().common_covariance.xx, scale_mps * scale_mps + offset_mps * offset_mps, 1e-9);
}

TEST(EgoError, AStandingVehicleHasNone) {
  const Drive drive{[](double x) { return static_scene(x, [](double) { return 1.0; }); }, 0};
  EXPECT_EQ(drive.last.front().velocity.x, 1);
  EXPECT_EQ(drive.last.front().common_covariance.xx, 0);
}

}  // namespace
}  // namespace stereogrid::test
