// SPDX-License-Identifier: Apache-2.0
//
// The ground of made-up frames, as values.
#include "ground/ground_estimator.hpp"

#include "ground_scene.hpp"
#include "pipeline/saved_state.hpp"

namespace stereogrid::test {
namespace {

constexpr double dt_s{0.1};

Config config_of(int disparities) {
  Config config;
  config.matching.disparities = disparities;
  return config;
}

struct Frames {
  Rig rig{scene_rig()};
  GroundEstimator estimator{rig, config_of(128), 0};
  GroundWorkspace space{rig};

  GroundFit fit(const GroundState& state, const GroundScene& scene, unsigned seed = 1) {
    space.samples = weighed(rig, scene.samples(rig, 6, seed));
    return estimator.fit(state, dt_s, space);
  }
  SettledGround next(const GroundState& state, const GroundScene& scene, unsigned seed = 1, Point2 place = {}) {
    return estimator.settle(state, fit(state, scene, seed), true, dt_s, place);
  }
};

void expect_near(const Ground& seen, const Ground& truth, const std::string& what) {
  EXPECT_NEAR(seen.height_m, truth.height_m, 0.03 * truth.height_m) << what;
  EXPECT_NEAR(seen.pitch_rad, truth.pitch_rad, 0.01) << what;
  EXPECT_NEAR(seen.roll_rad, truth.roll_rad, 0.01) << what;
}

struct SearchCase {
  std::string what;
  GroundScene scene;
  bool is_sound;
};

class SearchWithoutExtrinsics : public ::testing::TestWithParam<SearchCase> {};

TEST_P(SearchWithoutExtrinsics, FindsTheFloor) {
  Frames frames;
  const auto& [what, scene, is_sound] = GetParam();
  const GroundFit fit{frames.fit(first_ground({1.65, 0, 0}, GroundMode::assumed), scene)};
  EXPECT_EQ(fit.is_sound, is_sound) << what;
  if (is_sound) expect_near(fit.plane, scene.floor, what);
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, SearchWithoutExtrinsics,
    ::testing::Values(SearchCase{"floor", {}, true}, SearchCase{"rolled", {.floor = {0.3, 0.25, 0.08}}, true},
                      SearchCase{"mast", {.floor = {3.5, 0.5, -0.05}}, true}, SearchCase{"boxes", {.boxes = 6}, true},
                      SearchCase{"wall ahead", {.wall_m = 5}, true}, SearchCase{"wet", {.mirrored = 0.2}, true},
                      SearchCase{"under water", {.mirrored = 0.9}, false},
                      SearchCase{"own floor, then a lower one", {.floor_ends_at_m = 5, .lower_floor_m = 2}, true},
                      SearchCase{"wall", {.has_floor = false, .wall_m = 2}, false},
                      SearchCase{"outliers", {.has_floor = false, .outliers = 0.8}, false},
                      SearchCase{"empty", {.has_floor = false, .outliers = 0}, false}));

// A roll beyond the search is named, and nothing is found.
TEST(GroundEstimator, ReportsARolledCamera) {
  Frames frames;
  const GroundState start{first_ground({1.65, 0, 0}, GroundMode::assumed)};
  for (const double roll_deg : {-120.0, -90.0, -40.0, 20.0, 60.0, 90.0, 175.0}) {
    const Ground floor{1.2, 0.1, roll_deg * degree};
    const GroundFit fit{frames.fit(start, {.floor = floor})};
    EXPECT_FALSE(fit.is_sound || fit.is_candidate) << roll_deg;
    ASSERT_TRUE(fit.rolled) << roll_deg;
    expect_near(*fit.rolled, floor, std::to_string(roll_deg));
    EXPECT_EQ(frames.estimator.reason_to_reject(start, fit, dt_s), Rejection::camera_rolled);
    EXPECT_FALSE(frames.estimator.settle(start, fit, true, dt_s, {}).new_extrinsics);
  }
  EXPECT_FALSE(frames.fit(start, {}).rolled);
}

TEST(GroundEstimator, FindsExtrinsicsOnce) {
  Frames frames;
  const GroundState start{first_ground({1.65, 0, 0}, GroundMode::assumed)};
  EXPECT_LT(road_plane(frames.rig, frames.estimator.expected(start, dt_s)).disparity(320, 400), 0) << "no road";
  const SettledGround found{frames.next(start, {})};
  ASSERT_TRUE(found.new_extrinsics);
  EXPECT_EQ(found.state.mode, GroundMode::found);
  expect_near(found.state.extrinsics, {1.2, 0.2, 0}, "found");
  const SettledGround next{frames.next(found.state, {}, 2)};
  EXPECT_FALSE(next.new_extrinsics);
  EXPECT_TRUE(next.state.plane.estimated);
  EXPECT_EQ(next.state.agreeing, 1);
}

TEST(GroundEstimator, WeakFramesMustAgreeThreeTimes) {
  Frames frames;
  GroundState state{first_ground({1.65, 0, 0}, GroundMode::assumed)};
  GroundFit weak;
  weak.plane = {1.2, 0.2, 0};
  weak.is_candidate = true;
  for (int frame{0}; frame < 2; ++frame) {
    const SettledGround settled{frames.estimator.settle(state, weak, true, dt_s, {})};
    EXPECT_FALSE(settled.new_extrinsics) << frame;
    state = settled.state;
  }
  GroundFit other{weak};
  other.plane.height_m = 1.6;
  EXPECT_FALSE(frames.estimator.settle(state, other, true, dt_s, {}).new_extrinsics);
  EXPECT_FALSE(frames.estimator.settle(state, weak, false, dt_s, {}).new_extrinsics) << "rejected for its images";
  EXPECT_TRUE(frames.estimator.settle(state, weak, true, dt_s, {}).new_extrinsics);
}

// A plane that explains the nearest ground replaces extrinsics that are not confirmed yet.
TEST(GroundEstimator, FoundMovesAtOnceBeforeItIsConfirmed) {
  Frames frames;
  const SettledGround moved{frames.next(first_ground({1.8, 0.1, 0}, GroundMode::found), {})};
  ASSERT_TRUE(moved.new_extrinsics);
  expect_near(*moved.new_extrinsics, {1.2, 0.2, 0}, "moved");
}

// Later it must do so while the vehicle travels four heights of the camera.
TEST(GroundEstimator, FoundMovesByTravelOnceItIsConfirmed) {
  Frames frames;
  GroundState state{first_ground({1.8, 0.1, 0}, GroundMode::found)};
  state.agreeing = agreeing_min;
  for (int frame{0}; frame < 5; ++frame) {
    const SettledGround settled{frames.next(state, {}, 1, {1.0 * frame, 0})};
    EXPECT_FALSE(settled.new_extrinsics) << frame;
    state = settled.state;
  }
  EXPECT_TRUE(frames.next(state, {}, 1, {4.9, 0}).new_extrinsics);
  state.better = std::nullopt;
  EXPECT_FALSE(frames.next(state, {}, 1, {100, 0}).new_extrinsics) << "travel begins with the plane";
}

TEST(GroundEstimator, GivenNeverMoves) {
  Frames frames;
  const Ground given{1.8, 0.1, 0};
  GroundState state{first_ground(given, GroundMode::given)};
  for (int frame{0}; frame < 40; ++frame) {
    const GroundFit fit{frames.fit(state, {}, static_cast<unsigned>(frame))};
    EXPECT_FALSE(fit.plane.estimated) << frame;
    EXPECT_TRUE(fit.disagreeing) << frame;
    const bool is_rejected{frames.estimator.reason_to_reject(state, fit, dt_s) != Rejection::none};
    EXPECT_TRUE(is_rejected || frame <= 30) << frame;
    const SettledGround settled{frames.estimator.settle(state, fit, true, dt_s, {1.0 * frame, 0})};
    EXPECT_FALSE(settled.new_extrinsics) << frame;
    state = settled.state;
  }
  expect_near(state.extrinsics, given, "extrinsics");
}

// The extrinsics follow small errors of the calibration, to a bound.
TEST(GroundEstimator, GivenLearnsWithinItsBounds) {
  Frames frames;
  GroundState state{first_ground({1.2 * 1.08, 0.2, 0}, GroundMode::given)};
  for (int frame{0}; frame < 30; ++frame) state = frames.next(state, {}, static_cast<unsigned>(frame)).state;
  EXPECT_TRUE(state.plane.estimated);
  EXPECT_NEAR(state.plane.height_m, 1.2, 0.02);
  EXPECT_GE(state.extrinsics.height_m, 1.2 * 1.08 * 0.94 - 1e-9);
}

// From a crest the nearest ground falls to both sides, from a dip it rises. Lower ground that falls may be behind an
// edge.
TEST(GroundEstimator, CrestsAndDipsAreSlopesAhead) {
  Frames frames;
  GroundState state{first_ground({1.2, 0.2, 0}, GroundMode::given)};
  state.agreeing = agreeing_min;
  for (const auto& [floor, is_slope] :
       {std::pair{Ground{1.0, 0.12, 0}, true}, std::pair{Ground{1.35, 0.26, 0}, true},
        std::pair{Ground{1.5, 0.14, 0}, false}, std::pair{Ground{0.8, 0.2, 0}, false}}) {
    const GroundFit fit{frames.fit(state, {.floor = floor})};
    EXPECT_EQ(fit.slope.has_value(), is_slope) << floor.height_m;
    EXPECT_EQ(fit.disagreeing.has_value(), !is_slope) << floor.height_m;
  }
}

TEST(GroundEstimator, CoastsOnTheExtrinsicsWhereTheGroundIsHidden) {
  Frames frames;
  GroundState state{frames.next(first_ground({1.2, 0.2, 0}, GroundMode::given), {}).state};
  const GroundScene van{.has_floor = false, .wall_m = 2};
  double hidden_s{0};
  for (int frame{0}; frame < 40; ++frame) {
    const GroundFit fit{frames.fit(state, van, static_cast<unsigned>(frame))};
    hidden_s += dt_s;
    EXPECT_FALSE(fit.plane.estimated) << frame;
    EXPECT_EQ(fit.plane.height_m, state.extrinsics.height_m) << frame;
    const bool is_lost{frames.estimator.reason_to_reject(state, fit, dt_s) == Rejection::road_not_seen};
    EXPECT_TRUE(is_lost == (hidden_s > 3) || std::abs(hidden_s - 3) < 0.06) << frame;
    state = frames.estimator.settle(state, fit, true, dt_s, {}).state;
  }
}

TEST(GroundEstimator, ContinuesFromASavedState) {
  Frames frames;
  GroundState state{frames.next(first_ground({1.2, 0.2, 0}, GroundMode::found), {}).state};
  state.better = Ground{1.3, 0.1, 0};
  StateWriter writer;
  writer(state);
  GroundState loaded{first_ground({1, 0, 0}, GroundMode::given)};
  StateReader reader{writer.bytes()};
  reader(loaded);
  ASSERT_TRUE(reader.fits());
  const GroundFit a{frames.fit(state, {.boxes = 2}, 7)};
  const GroundFit b{frames.fit(loaded, {.boxes = 2}, 7)};
  EXPECT_EQ(a.plane, b.plane);
  EXPECT_EQ(loaded.better, state.better);
}

}  // namespace
}  // namespace stereogrid::test
