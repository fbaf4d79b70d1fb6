// SPDX-License-Identifier: Apache-2.0
//
// Evidence of ground planes in made-up disparities.
#include "ground_scene.hpp"

namespace stereogrid::test {
namespace {

// Samples on the plane support it. Samples above it cost little, samples below it contradict it. The space in front of
// the wheels is free.
struct TermCase {
  const char* what;
  float x;
  float y;
  float d;
  double nats;
};

class EvidenceOfASample : public ::testing::TestWithParam<TermCase> {};

TEST_P(EvidenceOfASample, FollowsVisibility) {
  const Rig rig{scene_rig()};
  const PlaneSamples samples{weighed(rig, {})};
  const PlaneHypothesis plane{road_plane(rig, {1.2, 0.2, 0}), rig, samples};  // 28.0 px at the lower border
  const TermCase& given{GetParam()};
  EXPECT_NEAR(term_of(plane, 128, given.x, given.y, given.d).evidence, given.nats, 0.05) << given.what;
}

INSTANTIATE_TEST_SUITE_P(Cases, EvidenceOfASample,
                         ::testing::Values(TermCase{"on the plane, near", 0, 195, 27.45F, 3.58},
                                           TermCase{"a pixel above it", 0, 195, 28.45F, 2.65},
                                           TermCase{"in front of the wheels", 0, 195, 40, -1.88},
                                           TermCase{"above it, beside the path", 300, 195, 40, -0.51},
                                           TermCase{"below it, near", 0, 195, 15, -1.97},
                                           TermCase{"on the plane, far", 0, -40, 4.41F, 3.93},
                                           TermCase{"above it, far", 0, -40, 20, -0.72},
                                           TermCase{"below it, far", 0, -40, 1, -0.14},
                                           TermCase{"above the horizon", 0, -150, 5, 0}));

struct EvidenceCase {
  std::string what;
  GroundScene scene;
  Ground plane;
  double least;
  double most;
};

class EvidenceOfAPlane : public ::testing::TestWithParam<EvidenceCase> {};

TEST_P(EvidenceOfAPlane, IsWithinBounds) {
  const Rig rig{scene_rig()};
  const EvidenceCase& given{GetParam()};
  const PlaneSamples samples{weighed(rig, given.scene.samples(rig))};
  const PlaneHypothesis plane{road_plane(rig, given.plane), rig, samples};
  const PlaneSupport support{support_of(plane, samples)};
  for (const double number : {support.evidence, support.on, support.below, support.near_all, support.near_on,
                              support.depth_ratio, support.near_share()}) {
    EXPECT_TRUE(std::isfinite(number)) << given.what;
  }
  EXPECT_GE(support.evidence, given.least) << given.what;
  EXPECT_LE(support.evidence, given.most) << given.what;
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, EvidenceOfAPlane,
    ::testing::Values(EvidenceCase{"floor", {}, {1.2, 0.2, 0}, 350, 500},
                      EvidenceCase{"floor, a lower plane", {}, {1.8, 0.2, 0}, -200, 0},
                      EvidenceCase{"floor, a higher plane", {}, {0.8, 0.2, 0}, -400, -100},
                      EvidenceCase{"floor with boxes", {.boxes = 4}, {1.2, 0.2, 0}, 250, 450},
                      EvidenceCase{"wall", {.has_floor = false, .wall_m = 5}, {1.2, 0.2, 0}, -200, 0},
                      EvidenceCase{
                          "lower floor alone", {.has_floor = false, .lower_floor_m = 2}, {1.2, 0.2, 0}, -300, 0},
                      EvidenceCase{"bonnet", {.bonnet_from_row = 320}, {1.2, 0.2, 0}, 150, 450},
                      EvidenceCase{"empty", {.has_floor = false, .outliers = 0}, {1.2, 0.2, 0}, 0, 0}));

TEST(PlaneEvidence, IsTheSameInAMirror) {
  const Rig rig{scene_rig()};
  std::vector<GroundSample> seen{GroundScene{.floor = {1.2, 0.2, 0.05}, .boxes = 3}.samples(rig)};
  const PlaneSamples samples{weighed(rig, seen)};
  for (GroundSample& sample : seen) sample.u = static_cast<float>(rig.width_px) - sample.u;
  const PlaneSamples mirrored{weighed(rig, seen)};
  const PlaneHypothesis plane{road_plane(rig, {1.2, 0.2, 0.05}), rig, samples};
  const PlaneHypothesis other{road_plane(rig, {1.2, 0.2, -0.05}), rig, mirrored};
  EXPECT_NEAR(support_of(plane, samples).evidence, support_of(other, mirrored).evidence, 1e-3);
}

TEST(PlaneEvidence, DoesNotGrowWithTheLattice) {
  const Rig rig{scene_rig()};
  const auto evidence = [&](int step) {
    const PlaneSamples samples{weighed(rig, GroundScene{.boxes = 3}.samples(rig, step), step)};
    return support_of({road_plane(rig, {1.2, 0.2, 0}), rig, samples}, samples).evidence;
  };
  const double usual{evidence(6)};
  for (const int step : {3, 4, 8, 10}) EXPECT_NEAR(evidence(step) / usual, 1, 0.1) << step;
}

TEST(PlaneEvidence, ConflictsByTheNearestGround) {
  const Rig rig{scene_rig()};
  const PlaneSamples samples{weighed(rig, GroundScene{}.samples(rig))};
  const auto hypothesis = [&](const Ground& ground) { return PlaneHypothesis{road_plane(rig, ground), rig, samples}; };
  const PlaneHypothesis floor{hypothesis({1.2, 0.2, 0})};
  EXPECT_FALSE(are_in_conflict(floor, floor, samples));
  EXPECT_FALSE(are_in_conflict(floor, hypothesis({1.21, 0.203, 0.005}), samples));
  EXPECT_TRUE(are_in_conflict(floor, hypothesis({1.6, 0.2, 0}), samples));
  EXPECT_TRUE(are_in_conflict(floor, hypothesis({1.2, 0.35, 0}), samples));
  EXPECT_GT(ring_margin(floor, hypothesis({1.6, 0.2, 0}), samples), 100);
  EXPECT_EQ(ring_margin(floor, floor, samples), 0);
}

}  // namespace
}  // namespace stereogrid::test
