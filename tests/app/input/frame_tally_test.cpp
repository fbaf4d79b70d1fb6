// SPDX-License-Identifier: Apache-2.0
#include "diagnostics/frame_tally.hpp"

#include <gmock/gmock.h>

#include <numbers>

#include "stereogrid/scenes/scene.hpp"

namespace stereogrid::app {
namespace {

using ::testing::AllOf, ::testing::Contains, ::testing::ElementsAre, ::testing::HasSubstr, ::testing::IsEmpty,
    ::testing::Not;

io::FrameSummary frame(std::size_t index, std::vector<FrameStatus> status, bool is_road_measured = true) {
  const bool is_known{status.empty()};
  return {index, {}, {}, std::move(status), "f" + std::to_string(index), {1.65, 0.02, 0, is_road_measured}, is_known};
}

Rig rig_with(double pitch_rad) {
  Rig rig;
  rig.camera_height_m = 1.65;
  rig.camera_pitch_rad = pitch_rad;
  return rig;
}

std::vector<std::string> texts_of(const FrameTally& tally, const Rig& given = rig_with(0),
                                  const Rig& used = rig_with(0)) {
  const Input input;
  const Config config{preset("default")};
  return findings_of(tally, {input, config, given, used, [](std::size_t) { return std::nullopt; }}).texts;
}

TEST(FrameTally, GoodFramesGiveNoFinding) {
  FrameTally tally;
  for (std::size_t i{0}; i < 40; ++i) tally.add(frame(i, {}));
  tally.add(frame(40, {}, false));  // a van before the camera
  tally.add(frame(41, {FrameStatus::clock_gap, FrameStatus::pose_missing}));
  EXPECT_THAT(texts_of(tally), IsEmpty());
}

TEST(FrameTally, TooFewDisparitiesForTheNearestGroundAreSaid) {
  FrameTally tally;
  tally.add(frame(0, {}));
  Config config{preset("default")};
  Rig robot{640, 480, 400, 320, 240, 0.09, 0.25, 0, 0};  // 239 rows · 0.09/0.25 = 86 px
  const auto texts = [&] {
    const Input input;
    return findings_of(tally, {input, config, robot, robot, [](std::size_t) { return std::nullopt; }}).texts;
  };
  EXPECT_THAT(texts(), IsEmpty()) << "automatic";
  config.matching.disparities = 64;
  EXPECT_THAT(texts(), ElementsAre(AllOf(HasSubstr("matching.disparities 64 is too small"), HasSubstr("needs 87"),
                                         HasSubstr("from 0.57 m on"), HasSubstr("set it to 96"))));
  robot.camera_height_m = 0.3;
  EXPECT_THAT(texts(), IsEmpty());
}

/// Disparities of level ground below a camera.
StereoFrame frame_above_ground(const Rig& rig, double height_m, double pitch_rad) {
  StereoFrame frame;
  frame.left = {rig.width_px, rig.height_px};
  frame.disparity = {rig.width_px, rig.height_px};
  for (int v{0}; v < rig.height_px; ++v) {
    const double below{std::cos(pitch_rad) * (v - rig.cy_px) + std::sin(pitch_rad) * rig.focal_px};
    std::fill_n(frame.disparity.row(v), rig.width_px,
                static_cast<float>(std::max(0.0, rig.baseline_m / height_m * below)));
  }
  return frame;
}

TEST(FrameTally, GroundOfACameraThatIsTooSteepOrTooHighIsNamed) {
  const Rig rig{160, 120, 150, 79.5, 59.5, 0.1, 1.65, 0, 0};
  const Input input;
  const Config config{preset("default")};
  const TallyContext context{input, config, rig, rig, [](std::size_t) { return std::nullopt; }};
  const auto fault = [&](double height_m, double pitch_deg) {
    const double pitch_rad{pitch_deg / 180 * std::numbers::pi};
    return fault_of_view(frame_above_ground(rig, height_m, pitch_rad), context).value_or("");
  };
  EXPECT_THAT(fault(1.2, 50), HasSubstr("the ground 1.20 m below a camera pitched down by 50°. Pitches are supported"));
  EXPECT_THAT(fault(2, 60), AllOf(HasSubstr("2.00 m below"), HasSubstr("by 60°"), Not(HasSubstr("wall"))));
  EXPECT_THAT(fault(2, 90), AllOf(HasSubstr("by 90°"), HasSubstr("If it is a wall")));
  EXPECT_THAT(fault(10, 40), AllOf(HasSubstr("estimated up to 4.5 m"), Not(HasSubstr("flatter")),
                                   HasSubstr("mount: {camera_height_m: 10.00, camera_pitch_rad: 0.698}")));
  EXPECT_EQ(fault(1.2, 40), "");
}

TEST(FrameTally, ARoadThatIsCarriedOverIsSaid) {
  FrameTally tally;
  for (std::size_t i{0}; i < 10; ++i) tally.add(frame(i, {}, i % 3 != 1));
  EXPECT_THAT(texts_of(tally), ElementsAre(AllOf(HasSubstr("road not found in 3 of 10 frames (first: f1)"),
                                                 HasSubstr("the extrinsics in the calibration may be wrong"),
                                                 HasSubstr("mount.camera_pitch_rad"), Not(HasSubstr("unknown")))));
}

TEST(FrameTally, MostGridsUnknownIsSaidWithTheShare) {
  FrameTally tally;
  for (std::size_t i{0}; i < 10; ++i) {
    tally.add(i < 2 ? frame(i, {}) : frame(i, {FrameStatus::road_unknown}, false));
  }
  EXPECT_THAT(texts_of(tally), ElementsAre(AllOf(HasSubstr("road not found in 8 of 10 frames (first: f2)"),
                                                 HasSubstr("in 8 of 10 frames the ground plane is unknown")),
                                           HasSubstr("most grids are unknown: those of 8 of 10 frames (80 %)")));
}

TEST(FrameTally, AnEstimatedMountingIsProposedOnce) {
  FrameTally tally;
  for (std::size_t i{0}; i < 3; ++i) tally.add(frame(i, {FrameStatus::road_unknown}, false));
  for (std::size_t i{3}; i < 9; ++i) tally.add(frame(i, {}));
  EXPECT_THAT(texts_of(tally, rig_with(0), rig_with(0.14)),
              ElementsAre(HasSubstr("mount: {camera_height_m: 1.650, camera_pitch_rad: 0.1400")));
}

TEST(FrameTally, AWrongPitchIsSaidWithTheRightOne) {
  FrameTally tally;
  for (std::size_t i{0}; i < 5; ++i) tally.add(frame(i, {}));
  EXPECT_THAT(
      texts_of(tally, rig_with(-0.017), rig_with(-0.017)),
      ElementsAre(AllOf(HasSubstr("camera pitch 1.1° (calibration: -1.0°)"), HasSubstr("camera_pitch_rad: 0.020"))));
}

TEST(FrameTally, UnequalExposuresAreSaidOnce) {
  FrameTally tally;
  for (std::size_t i{0}; i < 3; ++i) {
    io::FrameSummary summary{frame(i, {})};
    summary.exposure_warning = "the right image is 1." + std::to_string(6 + i) + " × brighter than the left";
    tally.add(summary);
  }
  EXPECT_THAT(texts_of(tally), ElementsAre(AllOf(HasSubstr("in 3 of 3 frames (first: f0)"), HasSubstr("1.6 ×"))));
}

// Each by its own warning.
TEST(FrameTally, EveryFlagOfTheImagesIsSaid) {
  for (std::size_t i{0}; i < names_of(FrameStatus{}).size(); ++i) {
    const auto flag{static_cast<FrameStatus>(i)};
    if (flag < FrameStatus::few_matches) continue;
    FrameTally tally;
    io::FrameSummary summary{frame(7, {flag})};
    summary.warnings = {{"another one"}, {"the reason", flag}, {"a third"}};
    tally.add(summary);
    const char* const reason{flag > FrameStatus::road_unknown ? ": the reason" : ""};
    EXPECT_THAT(texts_of(tally), Contains(AllOf(HasSubstr("(first: f7)"), HasSubstr(reason)))) << names_of(flag)[i];
  }
}

TEST(FrameTally, TextsThatDifferInNumbersAreTheSame) {
  EXPECT_EQ(without_digits("1.6 × and 20 %"), without_digits("1.5 × and 5 %"));
  EXPECT_NE(without_digits("left 1"), without_digits("right 1"));
  EXPECT_NE(without_digits("camera1: 5 px"), without_digits("camera2: 5 px"));
  EXPECT_EQ(without_digits("camera1: 5 px"), without_digits("camera1: 6 px"));
}

// Steps of a camera along a bent path, and those of a frame in which the camera is at `place`.
std::vector<MotionPair> steps_of(const Pose2& place, double turn_factor = 1) {
  std::vector<MotionPair> steps;
  for (int i{0}; i < 20; ++i) {
    const Pose2 seen{0.5, 0.002 * (i % 3), i < 10 ? 0.08 : -0.05};
    const Pose2 turned{seen.x_m, seen.y_m, turn_factor * seen.yaw_rad};
    steps.push_back({seen, place * turned * inverse(place)});
  }
  return steps;
}

TEST(PoseCheck, PosesThatContradictTheImagesAreReported) {
  EXPECT_FALSE(contradiction_of(steps_of({})));
  EXPECT_FALSE(contradiction_of(steps_of({0.1, -0.1, 0.05}))) << "errors of a calibration";
  EXPECT_FALSE(contradiction_of({}));
  EXPECT_THAT(contradiction_of(steps_of({1, -0.2, 1.5707963})).value_or(""),
              AllOf(HasSubstr("turned by 90°"), HasSubstr("x 1.00 m, y -0.20 m"), HasSubstr("--poses odometry")));
  EXPECT_THAT(contradiction_of(steps_of({}, -1)).value_or(""), HasSubstr("another path"));
  std::vector<MotionPair> jump{steps_of({})};
  jump[4].external.x_m += 20;
  EXPECT_FALSE(contradiction_of(jump)) << "jumps have a status of their own";
  for (MotionPair& step : jump) step.external.x_m *= 2;
  EXPECT_THAT(contradiction_of(jump).value_or(""), HasSubstr("2.00 times as far"));
}

TEST(PoseCheck, AFewStepsShowLargeContradictions) {
  const auto of_one = [](const Pose2& external) {
    return contradiction_of(std::vector<MotionPair>{{{0.6, 0, 0}, external}}).value_or("");
  };
  EXPECT_EQ(of_one({0.6, 0, 0}), "");
  EXPECT_EQ(of_one({0.9, 0.3, 0.1}), "") << "within the errors of a single step";
  EXPECT_THAT(of_one({-0.6, 0, 0}), HasSubstr("turned by 180°"));
  EXPECT_THAT(of_one({1.8, 0, 0}), HasSubstr("3.00 times as far"));
}

TEST(PoseCheck, ASlowTurnToTheOtherSideIsReported) {
  const std::vector<MotionPair> steps(12, {{0.8, 0, 0.005}, {0.8, 0, -0.005}});
  EXPECT_THAT(contradiction_of(steps).value_or(""), HasSubstr("another path"));
  EXPECT_FALSE(contradiction_of(std::vector<MotionPair>(12, {{0.8, 0, 0.005}, {0.8, 0, 0.006}})));
}

TEST(PoseCheck, ABaselineThatIsFarTooShortIsReported) {
  std::vector<MotionPair> steps(8, {{0.01, 0, 0}, {0.5, 0, 0}});
  steps[3].seen = {};
  EXPECT_THAT(contradiction_of(steps).value_or(""),
              AllOf(HasSubstr("over 0.1 m: they move 4.0 m"), HasSubstr("baseline_m")));
}

/// Findings of two cameras whose views overlap, the second one turned by `error_deg` in its rig.
std::vector<std::string> findings_of_places(const std::string& scene_text, double error_deg) {
  const scenes::Scene scene{scenes::parse_scene(scene_text)};
  std::vector<Rig> rigs(scene.rigs().begin(), scene.rigs().end());
  rigs.back().camera_yaw_rad += error_deg * std::numbers::pi / 180;
  Pipeline pipeline{preset("default"), rigs, {.stages = false, .camera_names = {"front", "left"}}};
  PlaceCheck places{1};
  for (std::size_t i{0}; i < scene.size(); ++i) places.add(pipeline.process(scene.load(i)));
  return places.findings();
}

TEST(PlaceCheck, FindsAWrongYaw) {
  for (const char* const layout : {"street", "occlusion"}) {
    const std::string scene{std::string{layout} + "?cameras=2&turn_deg=25&focal=256&frames=3&seed=3"};
    EXPECT_THAT(findings_of_places(scene, 0), IsEmpty()) << scene;
    EXPECT_THAT(
        findings_of_places(scene, 4),
        ElementsAre(AllOf(HasSubstr("front and left"), ::testing::ContainsRegex("left turned by -(3.5|4.0|4.5)°"))))
        << scene;
    EXPECT_THAT(findings_of_places(scene, -5),
                ElementsAre(::testing::ContainsRegex("left turned by [+](4.5|5.0|5.5)°")))
        << scene;
  }
}

TEST(PlaceCheck, HasNothingToCompareOfOneCameraOrSeparateViews) {
  EXPECT_THAT(findings_of_places("street?cameras=2&turn_deg=120&focal=256&frames=2", 5), IsEmpty());
  const scenes::Scene scene{scenes::parse_scene("street?frames=1&width=160&height=100")};
  Pipeline pipeline{preset("default"), scene.rig()};
  PlaceCheck places{1};
  places.add(pipeline.process(scene.load(0)));
  EXPECT_THAT(places.findings(), IsEmpty());
}

}  // namespace
}  // namespace stereogrid::app
