// SPDX-License-Identifier: Apache-2.0
//
// Wrong extrinsics in the rig: the pipeline estimates the right ones and continues as with given ones.
#include "chain_run.hpp"
#include "geometry/road_plane.hpp"
#include "matching/matching.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/level_mapping.hpp"

namespace stereogrid::test {
namespace {

constexpr int disparities_unmounted{128};  // number without extrinsics

using ::testing::HasSubstr;

constexpr const char* pitched_street{"street?width=320&height=200&pitch_deg=8&camera_height=1.0"};
/// Little of it is road.
constexpr const char* pitched_bank{
    "terrain?kind=bank&at=5&width=320&height=200&pitch_deg=8&camera_height=1.0&frames=8"};

Rig usual_extrinsics(Rig rig) {
  rig.camera_height_m = 1.65;
  rig.camera_pitch_rad = rig.camera_roll_rad = 0;
  return rig;
}

struct WrongRig {
  explicit WrongRig(const char* scene_text = pitched_bank, BackEnd back_end = BackEnd::cpu,
                    std::function<void(const FrameResult&)> on_grids = {})
      : scene{scene_text},
        pipeline{small_grid(),
                 usual_extrinsics(scene.rig()),
                 {.back_end = back_end, .threads = 2, .extrinsics_given = false, .on_grids = std::move(on_grids)}} {}

  const FrameResult& step(std::size_t index) { return pipeline.process(scene.load(index)); }

  Scene scene;
  Pipeline pipeline;
};

bool is_unknown(const FrameResult& result) {
  return std::ranges::count(result.status, FrameStatus::road_unknown) == 1 &&
         std::ranges::all_of(result.observed, [](float p) { return p == 0.5f; });
}

TEST(ExtrinsicsChain, IsFoundInOneFrameAndKept) {
  WrongRig drive;
  for (std::size_t frame{0}; frame < 6; ++frame) {
    const FrameResult& result{drive.step(frame)};
    EXPECT_TRUE(result.status.empty()) << frame;
    const bool is_reported{std::ranges::any_of(result.warnings, [](const Warning& warning) {
      return warning.text.find("mount: {camera_height_m: ") != std::string::npos;
    })};
    EXPECT_EQ(is_reported, frame == 0);
    EXPECT_NEAR(drive.pipeline.next_rig().camera_height_m, 1.0, 0.02);
    EXPECT_NEAR(drive.pipeline.next_rig().camera_pitch_rad / degree, 8, 0.2);
    EXPECT_NEAR(drive.pipeline.next_rig().camera_roll_rad / degree, 0, 0.3);
    EXPECT_EQ(LevelMapping{drive.pipeline.next_rig()}.level_rig().camera_pitch_rad, 0);
  }
}

// Grids by the assumed extrinsics are not the frame's.
TEST(ExtrinsicsChain, GridsAreReportedOnceAFrame) {
  std::vector<FrameResult> reported;
  WrongRig drive{pitched_bank, BackEnd::cpu, [&reported](const FrameResult& result) { reported.push_back(result); }};
  for (std::size_t frame{0}; frame < 3; ++frame) {
    const FrameResult& result{drive.step(frame)};
    ASSERT_EQ(reported.size(), frame + 1);
    EXPECT_EQ(reported.back().rig, result.rig);
    EXPECT_EQ(reported.back().observed, result.observed);
    EXPECT_EQ(reported.back().vehicle.occupancy, result.vehicle.occupancy);
    EXPECT_EQ(reported.back().obstacles.size(), frame == 0 ? result.obstacles.size() : 0) << "computed again";
  }
  EXPECT_NEAR(reported.front().rig.camera_height_m, 1.0, 0.02);
}

/// Exact disparities of level ground 1.65 m below the camera.
StereoFrame frame_of_level_ground(const Rig& rig, int index) {
  StereoFrame frame;
  frame.name = "frame";
  frame.index = index;
  frame.stamp_ns = 100'000'000LL * index;
  frame.world_from_vehicle = Pose2{};
  frame.left = {rig.width_px, rig.height_px};
  frame.disparity = {rig.width_px, rig.height_px};
  for (int v{0}; v < rig.height_px; ++v) {
    const double ground_px{rig.baseline_m / 1.65 * (v - rig.cy_px)};
    std::fill_n(frame.disparity.row(v), rig.width_px, static_cast<float>(std::max(ground_px, 0.1)));
  }
  return frame;
}

TEST(ExtrinsicsChain, AnEstimateThatEqualsTheAssumedExtrinsicsIsOne) {
  const Rig rig{usual_extrinsics(Scene{pitched_street}.rig())};
  const PipelineOptions options{.threads = 2, .extrinsics_given = false};
  Pipeline pipeline{small_grid(), rig, options};
  for (int index{0}; index < 3; ++index) {
    const FrameResult& result{pipeline.process(frame_of_level_ground(rig, index))};
    EXPECT_TRUE(result.status.empty()) << index;
  }
  ASSERT_EQ(pipeline.next_rig(), rig);
  Pipeline other{small_grid(), rig, options};
  other.load_state(pipeline.save_state());
  EXPECT_TRUE(other.process(frame_of_level_ground(rig, 3)).status.empty());
}

// Also of frames that were matched again to verify a plane, and rejected.
TEST(ExtrinsicsChain, TheGroundOfAResultIsThatOfItsDisparities) {
  WrongRig drive;
  for (std::size_t frame{0}; frame < 5; ++frame) {
    const FrameResult& result{drive.step(frame)};
    const RoadPlane plane{road_plane(result.level_rig, result.ground)};
    int road{0};
    for (const auto [u, v] : raster(result.stages.road_disparity)) {
      const float d{result.stages.road_disparity(u, v)};
      if (!(d > 0)) continue;
      ++road;
      ASSERT_NEAR(d, plane.disparity(u, v), road_margin_px + 1) << frame << ": " << u << ", " << v;
    }
    EXPECT_GT(road, 1000) << frame;
  }
}

TEST(ExtrinsicsChain, AreUsedAsIfTheyHadBeenGiven) {
  WrongRig drive{"crossing?width=512&height=320&pitch_deg=8&camera_height=1.0"};
  const FrameResult& result{drive.step(0)};
  const Rig found{drive.pipeline.next_rig()};
  EXPECT_NEAR(found.camera_height_m, 1.0, 0.01);
  EXPECT_NEAR(found.camera_pitch_rad / degree, 8, 0.1);
  Config config{small_grid()};
  config.matching.disparities = disparities_unmounted;
  Pipeline given{config, found, {.threads = 2}};
  for (std::size_t frame{0}; frame < 3; ++frame) {
    if (frame > 0) drive.step(frame);
    const FrameResult& expected{given.process(drive.scene.load(frame))};
    EXPECT_GT(std::ranges::count_if(expected.observed, [](float p) { return p < 0.3f; }), 500);
    EXPECT_EQ(count_differences(result.observed, expected.observed), 0) << frame;
    EXPECT_EQ(count_differences(result.world.occupancy, expected.world.occupancy), 0) << frame;
  }
}

TEST(ExtrinsicsChain, APairAloneIsNotEnoughBeforeALowerFloor) {
  WrongRig drive{"terrain?kind=stairs&rise=-0.17&at=3&width=512&height=320&pitch_deg=6&camera_height=0.9"};
  EXPECT_TRUE(is_unknown(drive.step(0)));
  EXPECT_EQ(drive.pipeline.next_rig(), usual_extrinsics(drive.scene.rig()));
}

// A wall of a corridor would be the ground of a camera that lies on its side.
TEST(ExtrinsicsChain, ARolledCameraIsReported) {
  const auto message = [](const std::string& scene) {
    WrongRig drive{scene.c_str()};
    const FrameResult& result{drive.step(0)};
    EXPECT_TRUE(is_unknown(result)) << scene;
    return result.warnings.empty() ? std::string{} : result.warnings.front().text;
  };
  const std::string corridor{"corridor?width=512&height=320&seed=9&roll_deg="};
  EXPECT_THAT(message(corridor + "30"), HasSubstr("rolled by 30°"));
  EXPECT_THAT(message(corridor + "30"), HasSubstr("mount: {camera_height_m: 1.2"));
  EXPECT_THAT(message(corridor + "90"), HasSubstr("rolled by 90°"));
  EXPECT_THAT(message("street?width=320&height=200&roll_deg=180"), HasSubstr("upside down"));
  EXPECT_FALSE(is_unknown(WrongRig{(corridor + "0").c_str()}.step(0)));
}

// From level ground on, before a crest and a dip.
TEST(ExtrinsicsChain, TheGroundUnderTheWheelsIsFoundBeforeACrest) {
  for (const std::string kind : {"hill", "valley"}) {
    WrongRig drive{("terrain?kind=" + kind + "&slope_deg=12&at=2&speed=8&frames=9").c_str()};
    for (std::size_t frame{0}; frame < 9; frame += 2) {
      drive.step(frame);
      EXPECT_NEAR(drive.pipeline.next_rig().camera_height_m, 1.25, 0.05 * 1.25) << kind << ' ' << frame;
      EXPECT_NEAR(drive.pipeline.next_rig().camera_pitch_rad / degree, 0, 1) << kind << ' ' << frame;
    }
  }
}

// A bonnet has the shape of ground. Its texture stays while the vehicle travels.
TEST(ExtrinsicsChain, ABonnetIsNoGround) {
  WrongRig drive{"street?width=512&height=320&seed=3&frames=12"};
  const Bonnet bonnet{.top_row = 240, .disparity = 56};
  std::size_t warnings{0};
  for (std::size_t index{0}; index < 10; ++index) {
    StereoFrame frame{drive.scene.load(index)};
    bonnet.paint(frame);
    const FrameResult& result{drive.pipeline.process(frame)};
    const auto is_reported = [](const Warning& warning) {
      return warning.text.find("vehicle itself") != std::string::npos;
    };
    warnings += static_cast<std::size_t>(std::ranges::count_if(result.warnings, is_reported));
    if (index < 6) continue;
    EXPECT_FALSE(is_unknown(result)) << index;
    EXPECT_NEAR(drive.pipeline.next_rig().camera_height_m, 1.25, 0.1) << index;
  }
  EXPECT_EQ(warnings, 1U);
}

TEST(ExtrinsicsChain, TheReferenceFindsTheSame) {
  WrongRig drive{"street?width=128&height=96&pitch_deg=8&camera_height=1.0"};
  WrongRig reference{"street?width=128&height=96&pitch_deg=8&camera_height=1.0", BackEnd::reference};
  for (std::size_t frame{0}; frame < 4; ++frame) expect_equal(reference.step(frame), drive.step(frame));
  EXPECT_EQ(reference.pipeline.next_rig(), drive.pipeline.next_rig());
  EXPECT_NE(drive.pipeline.next_rig(), usual_extrinsics(drive.scene.rig()));
}

TEST(ExtrinsicsChain, ASavedStateHasIt) {
  WrongRig drive;
  for (std::size_t frame{0}; frame < 4; ++frame) drive.step(frame);
  WrongRig twin;
  const std::vector<std::byte> nothing{twin.pipeline.save_state()};
  twin.pipeline.load_state(drive.pipeline.save_state());
  EXPECT_EQ(twin.pipeline.next_rig(), drive.pipeline.next_rig());
  expect_equal(twin.step(4), drive.step(4));
  twin.pipeline.load_state(nothing);
  EXPECT_EQ(twin.pipeline.next_rig(), usual_extrinsics(drive.scene.rig()));
  twin.step(0);
  EXPECT_NE(twin.pipeline.next_rig(), usual_extrinsics(drive.scene.rig()));
}

TEST(ExtrinsicsChain, IsKeptWhenThePipelineIsReset) {
  WrongRig drive;
  for (std::size_t frame{0}; frame < 3; ++frame) drive.step(frame);
  const Rig found{drive.pipeline.next_rig()};
  drive.pipeline.reset();
  EXPECT_TRUE(drive.step(3).status.empty());
  EXPECT_EQ(drive.pipeline.next_rig(), found);
}

TEST(ExtrinsicsChain, GivenExtrinsicsStayAndTheDisagreementIsReported) {
  Scene scene{pitched_street};
  const Rig given{usual_extrinsics(scene.rig())};
  Pipeline pipeline{small_grid(), given, {.threads = 2}};
  for (std::size_t frame{0}; frame < 6; ++frame) {
    const FrameResult& result{pipeline.process(scene.load(frame))};
    EXPECT_TRUE(is_unknown(result)) << frame;
    EXPECT_EQ(std::ranges::count(result.status, FrameStatus::extrinsics_disagree), 1) << frame;
    EXPECT_NE(result.warnings.back().text.find("camera height 1.65 m, pitch 0.0°"), std::string::npos);
    EXPECT_NE(result.warnings.back().text.find("pitch 8."), std::string::npos) << result.warnings.back().text;
  }
  EXPECT_EQ(pipeline.next_rig(), given);
}

TEST(ExtrinsicsChain, AnAssumedPitchThatIsNotThereIsFound) {
  Scene scene{"street?width=320&height=200"};
  Rig rig{scene.rig()};
  rig.camera_pitch_rad = 10 * degree;
  Pipeline pipeline{small_grid(), rig, {.threads = 2, .extrinsics_given = false}};
  for (std::size_t frame{0}; frame < 4; ++frame) pipeline.process(scene.load(frame));
  EXPECT_NEAR(pipeline.next_rig().camera_pitch_rad / degree, 0, 0.3);
  EXPECT_NEAR(pipeline.next_rig().camera_height_m, scene.rig().camera_height_m, 0.05);
}

TEST(ExtrinsicsChain, AWallAheadMovesNothing) {
  Scene scene{"wall?width=320&height=200&frames=8"};
  Pipeline pipeline{small_grid(), scene.rig(), {.threads = 2}};
  for (std::size_t frame{0}; frame < 6; ++frame) EXPECT_TRUE(pipeline.process(scene.load(frame)).status.empty());
  EXPECT_EQ(pipeline.next_rig(), scene.rig());
}

}  // namespace
}  // namespace stereogrid::test
