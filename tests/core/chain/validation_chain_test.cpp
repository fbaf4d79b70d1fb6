// SPDX-License-Identifier: Apache-2.0
//
// Frames that cannot be relied on: pairs that do not belong together, cameras that are not mounted as assumed.
#include "ground/frame_validator.hpp"

#include "chain_run.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

constexpr const char* street{"street?width=256&height=160&focal=205"};

Image<std::uint8_t> turned(const Image<std::uint8_t>& image) {
  Image<std::uint8_t> result{image};
  std::reverse(result.begin(), result.end());
  return result;
}

// extrinsics_disagree may stand beside the flag.
void expect_unknown(const FrameResult& result, FrameStatus flag) {
  std::vector<FrameStatus> status{result.status};
  std::erase(status, FrameStatus::extrinsics_disagree);
  ASSERT_EQ(status, std::vector<FrameStatus>{flag});
  EXPECT_FALSE(result.warnings.empty());
  EXPECT_FALSE(result.ground.estimated);
  const auto are_all = [](const auto& image, auto value) {
    return std::all_of(image.begin(), image.end(), [&](auto x) { return x == value; });
  };
  EXPECT_TRUE(are_all(result.observed, 0.5f));
  EXPECT_TRUE(are_all(result.stages.occupancy, 0.5f));
  EXPECT_TRUE(are_all(result.stages.occupancy_smooth, 0.5f));
  EXPECT_TRUE(are_all(result.stages.visible, 0));
  EXPECT_TRUE(are_all(result.stages.possible, 0));
}

struct Spoilt {
  std::string how;
  std::function<void(StereoFrame&)> spoil;
  FrameStatus flag;
};

std::vector<Spoilt> spoilt_pairs() {
  const auto noise = [](StereoFrame& frame) {
    std::mt19937 generator{static_cast<unsigned>(frame.index + 5)};
    frame.left = noise_image(frame.left.width(), frame.left.height(), generator);
    frame.right = noise_image(frame.left.width(), frame.left.height(), generator);
  };
  const auto stripes = [](StereoFrame& frame) {
    for (const auto [u, v] : raster(frame.left)) frame.left(u, v) = frame.right(u, v) = u / 8 % 2 == 0 ? 40 : 200;
  };
  const auto rows_off = [](StereoFrame& frame) {
    std::rotate(frame.right.begin(), frame.right.begin() + 12 * frame.right.width(), frame.right.end());
  };
  const auto upside_down = [](StereoFrame& frame) {
    frame.left = turned(std::exchange(frame.right, turned(frame.left)));
  };
  return {{"black",
           [](StereoFrame& frame) {
             frame.left.fill(0);
             frame.right.fill(0);
           },
           FrameStatus::few_matches},
          {"right lens covered", [](StereoFrame& frame) { frame.right.fill(3); }, FrameStatus::few_matches},
          {"identical", [](StereoFrame& frame) { frame.right = frame.left; }, FrameStatus::few_matches},
          {"noise", noise, FrameStatus::few_matches},
          {"stripes", stripes, FrameStatus::few_matches},
          {"swapped", [](StereoFrame& frame) { std::swap(frame.left, frame.right); }, FrameStatus::few_matches},
          {"rows off", rows_off, FrameStatus::few_matches},
          {"upside down", upside_down, FrameStatus::road_unknown}};
}

void expect_nothing_known(const Scene& scene, const Spoilt& spoilt, BackEnd back_end) {
  SCOPED_TRACE(spoilt.how);
  StereoFrame frame{scene.load(0)};
  spoilt.spoil(frame);
  Pipeline pipeline{small_grid(), scene.rig(), {.back_end = back_end, .threads = 2}};
  for (int i{0}; i < 2; ++i) {
    frame.stamp_ns += 100'000'000;
    const FrameResult& result{pipeline.process(frame)};
    expect_unknown(result, spoilt.flag);
    EXPECT_TRUE(result.obstacles.empty());
  }
}

TEST(Trust, NothingIsKnownFromUselessPairs) {
  const Scene scene{street};
  for (const Spoilt& spoilt : spoilt_pairs()) expect_nothing_known(scene, spoilt, BackEnd::cpu);
}

TEST(Trust, TheReferenceSaysTheSame) {
  const Scene scene{"street?width=96&height=60&focal=77"};
  for (const Spoilt& spoilt : spoilt_pairs()) {
    if (spoilt.how == "identical") expect_nothing_known(scene, spoilt, BackEnd::reference);
  }
}

TEST(Trust, NothingIsKnownWhereTheRightImageIsAFrameLate) {
  const Scene scene{street};
  Pipeline pipeline{small_grid(), scene.rig(), {.threads = 2}};
  for (std::size_t i{0}; i < 2; ++i) {
    StereoFrame frame{scene.load(i + 1)};
    frame.right = scene.load(i).right;
    expect_unknown(pipeline.process(frame), FrameStatus::few_matches);
  }
}

TEST(Trust, ARoadThatIsNotWhereTheExtrinsicsSayIsUnknown) {
  for (const double pitch_deg : {8.0, 10.0, -8.0}) {
    SCOPED_TRACE(pitch_deg);
    const Scene scene{std::string{street} + "&pitch_deg=" + std::to_string(pitch_deg)};
    Rig assumed{scene.rig()};
    assumed.camera_pitch_rad = 0;
    Pipeline pipeline{small_grid(), assumed, {.threads = 2}};
    for (std::size_t i{0}; i < 2; ++i) expect_unknown(pipeline.process(scene.load(i)), FrameStatus::road_unknown);
  }
}

TEST(Trust, SoIsOneSeenFromHigherUp) {
  const Scene scene{street};
  Rig assumed{scene.rig()};
  assumed.camera_height_m -= 0.55;
  Pipeline pipeline{small_grid(), assumed, {.threads = 2}};
  expect_unknown(pipeline.process(scene.load(0)), FrameStatus::road_unknown);
}

TEST(Trust, ScenesWithTheRightMountingAreKnown) {
  for (const char* name : {"street", "crossing", "empty", "wall", "van", "boxes", "occlusion", "street?pitch_deg=10"}) {
    SCOPED_TRACE(name);
    const std::string text{std::string{name} + (std::string{name}.find('?') != std::string::npos ? "&" : "?") +
                           "width=256&height=160&focal=205"};
    const Scene scene{text};
    Pipeline pipeline{small_grid(), scene.rig(), {.threads = 2}};
    for (std::size_t i{0}; i < 2; ++i) EXPECT_TRUE(pipeline.process(scene.load(i)).status.empty()) << i;
  }
}

TEST(Trust, ATrustedCalibrationIsKnown) {
  const Scene scene{std::string{street} + "&pitch_deg=8"};
  Rig assumed{scene.rig()};
  assumed.camera_pitch_rad = 0;
  Config config{small_grid()};
  config.ground.estimate = false;
  Pipeline pipeline{config, assumed, {.threads = 2}};
  EXPECT_TRUE(pipeline.process(scene.load(0)).status.empty());
}

constexpr const char* low_camera{"street?width=320&height=240&focal=160&baseline=0.3&camera_height=0.25"};

// Nothing matches there, and that is no fault of the images.
TEST(Trust, ARoadTooNearForTheDisparitiesDoesNotCount) {
  const Scene scene{low_camera};
  Config config{small_grid()};
  config.matching.disparities = 64;
  Pipeline pipeline{config, scene.rig(), {.threads = 2}};
  StereoFrame frame{scene.load(0)};
  EXPECT_TRUE(pipeline.process(frame).status.empty());
  pipeline.reset();
  std::swap(frame.left, frame.right);
  EXPECT_EQ(pipeline.process(frame).status, std::vector<FrameStatus>{FrameStatus::few_matches});
}

// Most differences between neighbours are noise, which does not match.
TEST(Trust, ANoisyCameraIsTrusted) {
  const Scene scene{"street?width=621&height=188&focal=360&noise=10"};
  Pipeline pipeline{small_grid(), scene.rig(), {.threads = 2}};
  for (const std::size_t i : {0U, 1U, 2U}) {
    StereoFrame frame{scene.load(i)};
    EXPECT_TRUE(pipeline.process(frame).status.empty()) << i;
  }
  StereoFrame swapped{scene.load(3)};
  std::swap(swapped.left, swapped.right);
  EXPECT_EQ(pipeline.process(swapped).status, std::vector<FrameStatus>{FrameStatus::few_matches});
}

TEST(Trust, NoiseIsMeasured) {
  std::mt19937 generator{7};
  std::normal_distribution<double> noise{128, 9};
  Image<std::uint8_t> left{200, 100};
  for (std::uint8_t& grey : left) grey = static_cast<std::uint8_t>(std::clamp(noise(generator), 0.0, 255.0));
  const Matches matches{200, 100};
  EXPECT_NEAR(noise_of({left.view(), left.view(), matches}, 0), 9, 1.5);
  left.fill(80);
  EXPECT_EQ(noise_of({left.view(), left.view(), matches}, 0), 0);
  EXPECT_EQ(noise_of({left.view(), left.view(), matches}, 100), 0);
}

TEST(AutomaticDisparities, ReachTheNearestRoadInTheImage) {
  const auto disparities_of = [](const char* text) {
    const Scene scene{text};
    Config config{small_grid()};
    config.matching.disparities = 0;
    Pipeline pipeline{config, scene.rig(), {.threads = 1}};
    return pipeline.process(scene.load(0)).stages.occupancy.height();
  };
  EXPECT_EQ(disparities_of(street), 64);
  EXPECT_EQ(disparities_of("street?width=1010&height=40"), 112);
  EXPECT_EQ(disparities_of(low_camera), 144);  // (239 − 120) · 0.3/0.25 = 142.8 px
  EXPECT_EQ(disparities_of("street?width=320&height=240&focal=160&baseline=0.5&camera_height=0.2"), 256);
}

TEST(Trust, WhatWasKnownIsRememberedThroughABadFrame) {
  const Scene scene{"crossing?width=256&height=160&focal=205"};
  Pipeline pipeline{small_grid(), scene.rig(), {.threads = 2}};
  for (std::size_t i{0}; i < 4; ++i) {
    StereoFrame frame{scene.load(i)};
    const bool is_bad{i == 2};
    if (is_bad) std::swap(frame.left, frame.right);
    const FrameResult& result{pipeline.process(frame)};
    EXPECT_EQ(result.status.empty(), !is_bad);
    EXPECT_EQ(result.ground.estimated, !is_bad);
    if (!is_bad) continue;
    const auto remembered{[](float p) { return p > 0.6f || p < 0.4f; }};
    EXPECT_GT(std::ranges::count_if(result.vehicle.occupancy, remembered), 100);
    EXPECT_TRUE(std::ranges::all_of(result.obstacles, [](const Obstacle& obstacle) { return obstacle.coasting; }));
  }
}

TEST(Trust, OtherSourcesStillCount) {
  const Scene scene{street};
  Pipeline pipeline{small_grid(), scene.rig(), {.threads = 2}};
  StereoFrame frame{scene.load(0)};
  std::swap(frame.left, frame.right);
  frame.other_grids.push_back({{0, -4, 1, 10, 8}, Image<float>{10, 8, 0.9f}, {}});
  const FrameResult& result{pipeline.process(frame)};
  EXPECT_EQ(result.status, std::vector<FrameStatus>{FrameStatus::few_matches});
  EXPECT_GT(*std::ranges::min_element(result.observed), 0.7f);
}

}  // namespace
}  // namespace stereogrid::test
