// SPDX-License-Identifier: Apache-2.0
//
// Pixels that show the vehicle itself, taken out of the whole pipeline by a mask.
#include "chain_run.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/level_mapping.hpp"

namespace stereogrid::test {
namespace {

using Mask = Image<std::uint8_t>;

constexpr const char* street{"street?width=320&height=160&frames=8"};

Mask mask_of(const Rig& rig, const auto& is_masked) {
  Mask mask{rig.width_px, rig.height_px, 255};
  for (const auto [u, v] : raster(rig.width_px, rig.height_px)) mask(u, v) = is_masked(u, v) ? 0 : 255;
  return mask;
}

Pipeline pipeline_of(const Rig& rig, Mask mask, BackEnd back_end = BackEnd::cpu) {
  return {small_grid(), rig, {.back_end = back_end, .threads = 2, .mask = std::move(mask)}};
}

bool has_disparity(const FrameResult& result, int u, int v) {
  const StageImages& stages{result.stages};
  return stages.obstacle_disparity(u, v) != 0 || stages.road_disparity(u, v) != 0 || stages.match_confidence(u, v) != 0;
}

TEST(MaskChain, MaskedPixelsHaveNoDisparity) {
  for (const bool is_given : {false, true}) {
    const Scene scene{"street?width=160&height=100"};
    const auto is_masked = [](int u, int v) { return v > 70 || (u > 40 && u < 60); };
    Pipeline cpu{pipeline_of(scene.rig(), mask_of(scene.rig(), is_masked))};
    Pipeline reference{pipeline_of(scene.rig(), mask_of(scene.rig(), is_masked), BackEnd::reference)};
    for (std::size_t i{0}; i < 3; ++i) {
      const StereoFrame frame{is_given ? given_frame(scene, i) : scene.load(i)};
      const FrameResult& result{cpu.process(frame)};
      int elsewhere{0};
      for (const auto [u, v] : raster(160, 100)) {
        const bool has{has_disparity(result, u, v)};
        EXPECT_FALSE(has && is_masked(u, v)) << u << " " << v;
        elsewhere += has ? 1 : 0;
      }
      EXPECT_GT(elsewhere, 3000);
      expect_equal(result, reference.process(frame));
    }
  }
}

TEST(MaskChain, OneThatUsesAllPixelsChangesNothing) {
  for (const char* text : {street, "street?width=320&height=160&pitch_deg=5"}) {
    Drive plain{text, small_grid()};
    Pipeline masked{pipeline_of(plain.scene.rig(), Mask{320, 160, 1})};
    for (std::size_t i{0}; i < 3; ++i) expect_equal(plain.step(i), masked.process(plain.scene.load(i)));
  }
}

TEST(MaskChain, WhatIsSeenThroughItAloneStaysUnknown) {
  const Scene scene{"occlusion?width=620&height=188"};
  const Rig& rig{scene.rig()};
  // a post 1 m wide at the crate's distance of 6 m
  const double half_px{rig.focal_px * 0.5 / 6};
  const Mask mask{mask_of(rig, [&](int u, int) { return std::abs(u - rig.cx_px) < half_px; })};
  Pipeline plain{small_grid(), rig, {.threads = 2}};
  Pipeline masked{pipeline_of(rig, mask)};
  const FrameResult& seen{plain.process(scene.load(0))};
  const FrameResult& unseen{masked.process(scene.load(0))};
  const GridGeometry& grid{seen.vehicle.geometry};
  float highest{0};
  for (const auto [ix, iy] : raster(grid.nx, grid.ny)) {
    const Point2 centre{grid.centre(ix, iy)};
    if (centre.x < 4 || centre.x > 7 || std::abs(centre.y) > 0.05 * centre.x) continue;
    highest = std::max(highest, seen.observed(ix, iy));
    EXPECT_NEAR(unseen.observed(ix, iy), 0.5f, 0.02f) << centre.x << " " << centre.y;
    EXPECT_FALSE(std::isfinite(unseen.vehicle.age_s(ix, iy))) << centre.x << " " << centre.y;
  }
  EXPECT_GT(highest, 0.9f) << "the crate's face lies there";
}

TEST(MaskChain, IsGivenInTheImageOfAPitchedCamera) {
  const Scene scene{"street?width=320&height=160&pitch_deg=6"};
  const auto is_masked = [](int u, int v) { return v > 120 && u > 100; };
  Pipeline pipeline{pipeline_of(scene.rig(), mask_of(scene.rig(), is_masked))};
  const FrameResult& result{pipeline.process(scene.load(0))};
  const LevelMapping mapping{pipeline.next_rig()};
  ASSERT_FALSE(mapping.is_identity());
  int near_it{0};
  for (const auto [u, v] : raster(result.level_rig.width_px, result.level_rig.height_px)) {
    const std::optional<ImagePoint> place{mapping.camera_from_level({static_cast<double>(u), static_cast<double>(v)})};
    if (!place || !has_disparity(result, u, v)) continue;
    EXPECT_FALSE(place->v > 120.5 && place->u > 100.5) << u << " " << v;
    near_it += place->v > 120 && place->u < 99 ? 1 : 0;
  }
  EXPECT_GT(near_it, 500) << "beside the mask";
}

// Without a mask the bonnet is an obstacle right ahead, or the frame is rejected.
TEST(MaskChain, TakesTheBonnetOut) {
  const Scene scene{"street?width=400&height=250&frames=6"};
  const Bonnet bonnet{200, 34.3};
  Pipeline plain{small_grid(), scene.rig(), {.threads = 2}};
  Pipeline masked{pipeline_of(scene.rig(), bonnet.mask(400, 250, 10))};
  Pipeline without{pipeline_of(scene.rig(), bonnet.mask(400, 250, 10))};
  for (std::size_t i{0}; i < 6; ++i) {
    StereoFrame frame{scene.load(i)};
    const FrameResult& expected{without.process(frame)};
    bonnet.paint(frame);
    const FrameResult& seen{plain.process(frame)};
    EXPECT_GT(seen.obstacle_density, 0.1) << "frame " << i;
    const FrameResult& result{masked.process(frame)};
    EXPECT_TRUE(expected.status.empty()) << "frame " << i;
    EXPECT_TRUE(result.status.empty()) << "frame " << i;
    EXPECT_NEAR(result.ground.height_m, expected.ground.height_m, 0.02);
    double different{0};
    for (std::size_t k{0}; k < result.observed.size(); ++k) {
      different += std::abs(result.observed.data()[k] - expected.observed.data()[k]) > 0.3f ? 1 : 0;
    }
    EXPECT_LT(different / static_cast<double>(result.observed.size()), 0.02) << "frame " << i;
  }
}

// Half of the image matches nothing; the rest is enough to know the street.
TEST(MaskChain, WhatItHidesDoesNotSpeakAgainstTheFrame) {
  const Scene scene{"street?width=320&height=200"};
  std::mt19937 generator{7};
  const auto is_masked = [](int u, int v) { return v > 95 && (u < 110 || u > 210); };
  Pipeline plain{small_grid(), scene.rig(), {.threads = 2}};
  Pipeline masked{pipeline_of(scene.rig(), mask_of(scene.rig(), is_masked))};
  for (std::size_t i{0}; i < 3; ++i) {
    StereoFrame frame{scene.load(i)};
    for (Image<std::uint8_t>* image : {&frame.left, &frame.right}) {
      const Image<std::uint8_t> noise{noise_image(320, 200, generator)};
      for (const auto [u, v] : raster(320, 200)) (*image)(u, v) = is_masked(u, v) ? noise(u, v) : (*image)(u, v);
    }
    EXPECT_EQ(std::ranges::count(plain.process(frame).status, FrameStatus::few_matches), 1) << "frame " << i;
    EXPECT_TRUE(masked.process(frame).status.empty()) << "frame " << i;
  }
}

TEST(MaskChain, HoldsWhenAnotherMountingIsFound) {
  const Scene scene{"street?width=320&height=200&pitch_deg=8&camera_height=1.0"};
  Rig rig{scene.rig()};
  rig.camera_height_m = 1.65;
  rig.camera_pitch_rad = 0;
  const auto is_masked = [](int, int v) { return v > 170; };
  Pipeline pipeline{small_grid(), rig, {.threads = 2, .mask = mask_of(rig, is_masked), .extrinsics_given = false}};
  for (std::size_t i{0}; i < 4; ++i) pipeline.process(scene.load(i));
  ASSERT_NEAR(pipeline.next_rig().camera_pitch_rad / degree, 8, 0.2);
  const FrameResult& result{pipeline.process(scene.load(4))};
  const LevelMapping mapping{pipeline.next_rig()};
  const auto first_masked{mapping.level_from_camera({160, 171})};
  ASSERT_TRUE(first_masked);
  for (int v{static_cast<int>(first_masked->v) + 1}; v < result.level_rig.height_px; ++v) {
    EXPECT_FALSE(has_disparity(result, 160, v)) << v;
  }
  int above{0};
  for (int v{0}; v < static_cast<int>(first_masked->v) - 1; ++v) above += has_disparity(result, 160, v) ? 1 : 0;
  EXPECT_GT(above, 30);
}

TEST(MaskChain, AMaskThatDoesNotFitIsRefused) {
  const Rig rig{Scene{street}.rig()};
  const auto error_text = [&](Mask mask) {
    return error_text_of<ConfigError>([&] { pipeline_of(rig, std::move(mask)); });
  };
  EXPECT_NE(error_text(Mask{160, 320, 1}).find("size"), std::string::npos);
  EXPECT_NE(error_text(Mask{320, 160, 0}).find("leaves no pixel"), std::string::npos);
  EXPECT_EQ(error_text(Mask{320, 160, 1}), "");
  EXPECT_EQ(error_text(Mask{}), "");
}

TEST(MaskChain, AStateOfAnotherMaskIsRefused) {
  const Scene scene{street};
  Mask mask{320, 160, 1};
  Pipeline first{pipeline_of(scene.rig(), mask)};
  first.process(scene.load(0));
  Pipeline same{pipeline_of(scene.rig(), mask)};
  same.load_state(first.save_state());
  mask(7, 9) = 0;
  Pipeline other{pipeline_of(scene.rig(), mask)};
  EXPECT_THROW(other.load_state(first.save_state()), InputError);
}

}  // namespace
}  // namespace stereogrid::test
