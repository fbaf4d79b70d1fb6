// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/level_mapping.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "matching/checks/mask.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

Rig pitched_rig(double pitch_deg) {
  return {161, 121, 130, 78.3, 57.9, 0.3, 1.4, pitch_deg * degree, 0.01};
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
  for (int v{0}; v < mapping.level_rig().height_px; ++v) {
    for (int u{0}; u < mapping.level_rig().width_px; ++u) {
      const auto place = mapping.camera_from_level({static_cast<double>(u), static_cast<double>(v)});
      if (!place) continue;
      EXPECT_EQ(mask.view()(u, v), std::abs(place->u - 80) < 1 ? 1 : 0) << u << " " << v;
      masked += mask.view()(u, v);
    }
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
