// SPDX-License-Identifier: Apache-2.0
#include "images/levelling.hpp"

#include "backend/cpu.hpp"
#include "matching/checks/mask.hpp"
#include "pipeline/frame_input.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

struct Point {
  double right;
  double down;
  double forward;
};

struct Pixel {
  double u;
  double v;
};

// The camera is pitched down by pitch_rad: a rotation about the axis to its right.
Pixel seen_by(const Rig& rig, double pitch_rad, const Point& point) {
  const double down{std::cos(pitch_rad) * point.down - std::sin(pitch_rad) * point.forward};
  const double depth{std::sin(pitch_rad) * point.down + std::cos(pitch_rad) * point.forward};
  return {rig.cx_px + rig.focal_px * point.right / depth, rig.cy_px + rig.focal_px * down / depth};
}

// A soft blob, whose centre of mass is its place to a fraction of a pixel.
void draw_blob(Image<std::uint8_t>& image, Pixel at) {
  for (const auto [u, v] : raster(image)) {
    const double r2{(u - at.u) * (u - at.u) + (v - at.v) * (v - at.v)};
    image(u, v) = static_cast<std::uint8_t>(std::min(255.0, image(u, v) + 200 * std::exp(-r2 / 8)));
  }
}

Pixel centre_of_mass(const Image<std::uint8_t>& image) {
  double sum{0};
  Pixel centre{0, 0};
  for (const auto [u, v] : raster(image)) {
    sum += image(u, v);
    centre.u += u * static_cast<double>(image(u, v));
    centre.v += v * static_cast<double>(image(u, v));
  }
  return {centre.u / sum, centre.v / sum};
}

Rig pitched_rig(double pitch_deg) {
  return {161, 121, 130, 78.3, 57.9, 0.3, 1.4, pitch_deg * degree, 0.01};
}

TEST(Levelling, PutsPointsWhereALevelCameraSeesThem) {
  Cpu cpu{2};
  for (const double pitch_deg : {3.0, -4.0, 12.0}) {
    const Rig rig{pitched_rig(pitch_deg)};
    const Levelling levelling{rig};
    ASSERT_TRUE(levelling.is_needed());
    for (const Point point : {Point{1.0, 0.5, 8}, Point{-2, 1.2, 9}, Point{0.3, 1.0, 6}}) {
      Image<std::uint8_t> pitched{rig.width_px, rig.height_px};
      draw_blob(pitched, seen_by(rig, rig.camera_pitch_rad, point));
      Image<std::uint8_t> level{rig.width_px, levelling.level_rig().height_px, 77};
      levelling.apply(cpu, pitched.view(), level.view());
      const Pixel expected{seen_by(levelling.level_rig(), 0, point)};
      const Pixel found{centre_of_mass(level)};
      EXPECT_NEAR(found.u, expected.u, 0.1) << pitch_deg;
      EXPECT_NEAR(found.v, expected.v, 0.1) << pitch_deg;
    }
  }
}

// Both cameras are turned about the baseline: a point stays in one row, and its disparity is that of a level pair.
TEST(Levelling, KeepsRowsAlignedAndTheDisparityRight) {
  Cpu cpu{1};
  const Rig rig{pitched_rig(3)};
  const Levelling levelling{rig};
  const Point of_left{0.8, 0.9, 7};
  const Point of_right{of_left.right - rig.baseline_m, of_left.down, of_left.forward};
  Image<std::uint8_t> left{rig.width_px, rig.height_px};
  Image<std::uint8_t> right{rig.width_px, rig.height_px};
  draw_blob(left, seen_by(rig, rig.camera_pitch_rad, of_left));
  draw_blob(right, seen_by(rig, rig.camera_pitch_rad, of_right));
  Image<std::uint8_t> level_left{left};
  Image<std::uint8_t> level_right{right};
  levelling.apply(cpu, left.view(), level_left.view());
  levelling.apply(cpu, right.view(), level_right.view());
  EXPECT_NEAR(centre_of_mass(level_left).v, centre_of_mass(level_right).v, 0.05);
  EXPECT_NEAR(centre_of_mass(level_left).u - centre_of_mass(level_right).u,
              rig.focal_px * rig.baseline_m / of_left.forward, 0.05);
}

// A slanted wall, known at every pixel: the levelled disparities are those that a level camera would have.
TEST(Levelling, DisparitiesAreThoseOfALevelCamera) {
  Cpu cpu{2};
  for (const double pitch_deg : {3.0, -6.0}) {
    const Rig rig{pitched_rig(pitch_deg)};
    const Levelling levelling{rig};
    const Rig& level_rig{levelling.level_rig()};
    // the wall n·X = 1 in the level camera's frame; a ray r meets it at depth r_z/(n·r)
    const Point wall{0.02, 0.05, 0.1};
    const auto level_disparity = [&](double u, double v) {
      return rig.baseline_m *
             (wall.right * (u - rig.cx_px) + wall.down * (v - level_rig.cy_px) + wall.forward * rig.focal_px);
    };
    const double c{std::cos(rig.camera_pitch_rad)};
    const double s{std::sin(rig.camera_pitch_rad)};
    const Point in_pitched{wall.right, c * wall.down - s * wall.forward, s * wall.down + c * wall.forward};
    Image<float> pitched{rig.width_px, rig.height_px};
    for (const auto [u, v] : raster(rig.width_px, rig.height_px)) {
      pitched(u, v) =
          static_cast<float>(rig.baseline_m * (in_pitched.right * (u - rig.cx_px) + in_pitched.down * (v - rig.cy_px) +
                                               in_pitched.forward * rig.focal_px));
    }
    Image<float> level{rig.width_px, level_rig.height_px, 77};
    levelling.apply(cpu, pitched.view(), level.view());
    int known{0};
    for (const auto [u, v] : raster(rig.width_px, level_rig.height_px)) {
      if (level(u, v) == 0) continue;
      ++known;
      // half a pixel of the nearest neighbour, times the wall's slant
      EXPECT_NEAR(level(u, v), level_disparity(u, v), 0.02) << u << " " << v;
    }
    EXPECT_GT(known, 0.8 * rig.width_px * rig.height_px);
  }
}

TEST(Levelling, WhatTheCameraDoesNotSeeIsBlack) {
  Cpu cpu{1};
  const Rig rig{pitched_rig(10)};
  const Image<std::uint8_t> pitched{rig.width_px, rig.height_px, 200};
  Image<std::uint8_t> level{rig.width_px, rig.height_px, 77};
  Levelling{rig}.apply(cpu, pitched.view(), level.view());
  // looking down, the camera sees nothing of what a level one has in its uppermost rows
  for (int u{0}; u < rig.width_px; ++u) EXPECT_EQ(level(u, 0), 0);
  EXPECT_EQ(level(80, 118), 200);
  for (const std::uint8_t pixel : level) EXPECT_TRUE(pixel == 0 || pixel == 200);
}

TEST(Levelling, OnlyPitchBeyondOneDegreeNeedsIt) {
  EXPECT_FALSE(Levelling{pitched_rig(0.99)}.is_needed());
  EXPECT_FALSE(Levelling{pitched_rig(-0.99)}.is_needed());
  EXPECT_TRUE(Levelling{pitched_rig(1.01)}.is_needed());
  EXPECT_TRUE(Levelling{pitched_rig(-1.01)}.is_needed());
}

TEST(Levelling, LevelRigDiffersInItsPitchItsRowsAndTheirCentreOnly) {
  const Rig level{Levelling{pitched_rig(3)}.level_rig()};
  Rig expected{pitched_rig(3)};
  expected.camera_pitch_rad = 0;
  expected.height_px = level.height_px;
  expected.cy_px = level.cy_px;
  EXPECT_EQ(level, expected);
  EXPECT_NEAR(level.cy_px, pitched_rig(3).cy_px - pitched_rig(3).focal_px * std::tan(3 * degree), 8);
  EXPECT_GE(level.height_px, pitched_rig(3).height_px) << "no row that the camera sees is cut off";
  EXPECT_EQ(Levelling{pitched_rig(0.5)}.level_rig(), pitched_rig(0.5));
}

TEST(Levelling, TheViewBeginsWhereTheLastRowMeetsTheLeastHeight) {
  Config config{preset("default")};
  config.u_disparity.obstacle_min_height_m = 0.2;
  for (const double pitch_deg : {-9.0, 0.5, 5.0, 20.0}) {
    const Rig rig{pitched_rig(pitch_deg)};
    FrameInput input{config, {&rig, 1}, {}};
    StereoFrame frame;
    frame.left = frame.right = Image<std::uint8_t>{rig.width_px, rig.height_px};
    const CameraImages images{frame, {frame.left.view(), frame.right.view()}};
    Cpu cpu{1};
    FrameResult result;
    const double last{rig.camera_pitch_rad + std::atan((rig.height_px - 1 - rig.cy_px) / rig.focal_px)};
    const double nearest_m{input.convert({&images, 1}, cpu, result).views[0].nearest_m};
    EXPECT_NEAR(nearest_m * std::tan(last) / (rig.camera_height_m - 0.2), 1, 0.02) << pitch_deg;
  }
}

TEST(LevelMapping, ThereAndBackIsTheSamePlace) {
  for (const double pitch_deg : {3.0, -4.0, 12.0, 0.5}) {
    const LevelMapping mapping{pitched_rig(pitch_deg)};
    for (const ImagePoint point : {ImagePoint{0, 0}, ImagePoint{160, 120}, ImagePoint{30.25, 77.5}}) {
      const std::optional<ImagePoint> level{mapping.level_from_camera(point)};
      ASSERT_TRUE(level);
      const std::optional<ImagePoint> back{mapping.camera_from_level(*level)};
      ASSERT_TRUE(back);
      EXPECT_NEAR(back->u, point.u, 1e-9);
      EXPECT_NEAR(back->v, point.v, 1e-9);
    }
  }
}

// A masked pixel of the camera masks all pixels of the level image that it is part of.
TEST(LevelMapping, LevelPixelsAreMaskedIfOneOfTheirFourPixelsIs) {
  const Rig rig{pitched_rig(5)};
  const LevelMapping mapping{rig};
  Image<std::uint8_t> camera{rig.width_px, rig.height_px, 255};
  for (int v{0}; v < rig.height_px; ++v) camera(80, v) = 0;
  const PixelMask mask{camera, mapping};
  int masked{0};
  for (const auto [u, v] : raster(mapping.level_rig().width_px, mapping.level_rig().height_px)) {
    const auto place = mapping.camera_from_level({static_cast<double>(u), static_cast<double>(v)});
    if (!place) continue;
    EXPECT_EQ(mask.view()(u, v), std::abs(place->u - 80) < 1 ? 1 : 0) << u << " " << v;
    masked += mask.view()(u, v);
  }
  EXPECT_GT(masked, 150);
}

// A point 8 m ahead, 2 m to the right and 1 m below the camera, which is pitched down by 5°.
TEST(LevelMapping, TakesAPointToWhereALevelCameraHasIt) {
  const Rig rig{pitched_rig(5)};
  const double c{std::cos(5 * degree)};
  const double s{std::sin(5 * degree)};
  const double down{c * 1 - s * 8};
  const double depth{s * 1 + c * 8};
  const LevelMapping mapping{rig};
  const std::optional<ImagePoint> level{
      mapping.level_from_camera({rig.cx_px + rig.focal_px * 2 / depth, rig.cy_px + rig.focal_px * down / depth})};
  ASSERT_TRUE(level);
  EXPECT_NEAR(level->u, rig.cx_px + rig.focal_px * 2 / 8, 1e-9);
  EXPECT_NEAR(level->v, mapping.level_rig().cy_px + rig.focal_px * 1 / 8, 1e-9);
}

TEST(LevelMapping, UpToOneDegreeNothingIsTurned) {
  const LevelMapping mapping{pitched_rig(0.99)};
  EXPECT_TRUE(mapping.is_identity());
  EXPECT_EQ(mapping.level_rig(), pitched_rig(0.99));
  EXPECT_EQ(mapping.level_from_camera({7, 8})->v, 8);
  EXPECT_EQ(mapping.camera_from_level({7, 8})->u, 7);
  const LevelMapping turned{pitched_rig(1.01)};
  EXPECT_FALSE(turned.is_identity());
  EXPECT_EQ(turned.level_rig().camera_pitch_rad, 0);
  EXPECT_GT(turned.level_from_camera({7, 8})->v, 8);
}

TEST(LevelMapping, WhatIsBehindTheOtherCameraHasNoPlace) {
  const LevelMapping mapping{pitched_rig(60)};
  EXPECT_FALSE(mapping.level_from_camera({80, 58 + 130 * 2}));
  EXPECT_TRUE(mapping.level_from_camera({80, 58}));
  EXPECT_FALSE(mapping.camera_from_level({80, mapping.level_rig().cy_px - 130 * 2}));
}

TEST(LevelMapping, TheLevelImageHasTheRowsThatTheCameraSees) {
  for (const double pitch_deg : {-9.0, 5.0, 12.5, 20.0}) {
    SCOPED_TRACE(pitch_deg);
    const Rig rig{pitched_rig(pitch_deg)};
    const LevelMapping mapping{rig};
    const Rig& level{mapping.level_rig()};
    const double top{mapping.level_from_camera({rig.cx_px, 0})->v};
    const double bottom{mapping.level_from_camera({rig.cx_px, rig.height_px - 1.0})->v};
    EXPECT_GE(top, 0);
    EXPECT_LT(top, 1);
    EXPECT_LE(bottom, level.height_px - 1);
    EXPECT_GT(bottom, level.height_px - 2);
    Rig same{level};
    same.cy_px = rig.cy_px;
    same.height_px = rig.height_px;
    same.camera_pitch_rad = rig.camera_pitch_rad;
    EXPECT_EQ(same, rig) << "nothing else differs";
  }
}

TEST(LevelMapping, OfASteepViewItHasWhatIsFarthest) {
  const Rig rig{pitched_rig(45)};
  const LevelMapping mapping{rig};
  EXPECT_EQ(mapping.level_rig().height_px, rig.height_px * 3 / 2);
  EXPECT_LT(mapping.level_from_camera({rig.cx_px, 0})->v, 1);
}

}  // namespace
}  // namespace stereogrid::test
