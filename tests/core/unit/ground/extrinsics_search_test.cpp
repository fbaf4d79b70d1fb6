// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// The road plane of a camera of which nothing is known, from made-up disparities.
#include "ground/extrinsics_search.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "support.hpp"

namespace stereogrid::test {
namespace {

GroundConfig gates() {
  GroundConfig config;
  config.estimate = true;
  return config;
}

struct Around {
  double kerb_to_wall_m{6};  // walls of houses along the road, to both sides
  double ahead_m{0};         // a wall across the road; 0: none
  double noise_px{0.3};
  double outliers{0.1};
  bool has_road{true};
};

// Matches of a street at every sixth pixel.
std::vector<GroundSample> seen(const Rig& rig, const Ground& ground, const Around& around, unsigned seed) {
  std::mt19937 generator{seed};
  const RoadPlane road{road_plane(rig, ground)};
  std::vector<GroundSample> samples;
  for (int v{6}; v < rig.height_px; v += 6) {
    for (int u{6}; u < rig.width_px; u += 6) {
      // inverse depths; walls stand upright whatever the pitch, which is close enough here
      double d{around.has_road ? road.disparity(u, v) : 0};
      if (around.kerb_to_wall_m > 0) {
        d = std::max(d, rig.baseline_m * std::abs(u - rig.cx_px) / around.kerb_to_wall_m);
      }
      if (around.ahead_m > 0) d = std::max(d, rig.focal_px * rig.baseline_m / around.ahead_m);
      d += around.noise_px * gaussian(generator);
      if (uniform(generator, 0, 1) < around.outliers) d = uniform(generator, 1, 60);
      if (d > 0.5) samples.push_back({static_cast<float>(u), static_cast<float>(v), static_cast<float>(d)});
    }
  }
  return samples;
}

struct SupportCase {
  const char* what;
  RoadSupport support;
  bool is_road;
};

// Near: a fifth of all at least. Below: a fifth of all and a third of the near ones at most.
TEST(RoadSupport, IsARoad) {
  constexpr int least{ground_samples_min};
  for (const SupportCase& one :
       {SupportCase{"all near", {5 * least, 5 * least, 0, 3, 8}, true},
        {"as few as may be", {least, least, 0, 3, 8}, true},
        {"too few", {least - 1, least - 1, 0, 3, 8}, false},
        {"a fifth near", {50 * least, 10 * least, 0, 3, 8}, true},
        {"less than a fifth near", {50 * least, 10 * least - 1, 0, 3, 8}, false},
        {"a fifth below", {50 * least, 40 * least, 10 * least, 3, 8}, true},
        {"more than a fifth below", {50 * least, 39 * least, 10 * least + 1, 3, 8}, false},
        {"a third of the near ones below", {50 * least, 12 * least, 4 * least, 3, 8}, true},
        {"more than a third of the near ones below", {50 * least, 12 * least, 4 * least + 1, 3, 8}, false},
        {"a range of depths", {5 * least, 5 * least, 0, 1.4, 8}, true},
        {"one depth", {5 * least, 5 * least, 0, 1.39, 8}, false},
        {"half of the columns", {5 * least, 5 * least, 0, 3, 4}, true},
        {"less than half of the columns", {5 * least, 5 * least, 0, 3, 3}, false}}) {
    EXPECT_EQ(one.support.is_road(), one.is_road) << one.what;
  }
}

TEST(RoadSupport, SamplesBelowThePlaneSpeakAgainstIt) {
  const Rig rig{small_kitti_rig()};
  const RoadPlane plane{road_plane(rig, {rig.camera_height_m, rig.camera_pitch_rad, 0, true})};
  for (int percent{0}; percent <= 90; percent += 10) {
    std::vector<GroundSample> samples;
    for (int v{120}; v < rig.height_px; v += 2) {
      for (int u{5}; u < rig.width_px; u += 7) {
        const double d{plane.disparity(u, v)};
        const bool is_below{static_cast<int>(samples.size()) % 10 < percent / 10};
        samples.push_back({static_cast<float>(u), static_cast<float>(v), static_cast<float>(is_below ? 0.6 * d : d)});
      }
    }
    const RoadSupport support{support_of(rig, samples, plane)};
    EXPECT_EQ(support.all, static_cast<int>(samples.size()));
    EXPECT_EQ(support.near + support.below, support.all);
    EXPECT_NEAR(support.below, percent / 100.0 * support.all, 10);
    EXPECT_EQ(support.is_road(), percent < 20) << percent;
  }
}

void expect_found(const std::optional<Ground>& found, const Ground& truth) {
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->height_m, truth.height_m, 0.03 * truth.height_m);
  EXPECT_NEAR(found->pitch_rad / degree, truth.pitch_rad / degree, 0.4);
  EXPECT_NEAR(found->roll_rad / degree, truth.roll_rad / degree, 0.4);
}

TEST(ExtrinsicsSearch, FindsTheRoadOfAnyCamera) {
  const Rig rig{small_kitti_rig()};
  unsigned seed{1};
  for (const double height_m : {0.4, 1.0, 1.65, 2.6, 3.9}) {
    for (const double pitch_deg : {-4.0, 0.0, 8.0, 20.0, 33.0}) {
      if (height_m > 3 && pitch_deg < 0) continue;  // hardly any road in view
      for (const double roll_deg : {-8.0, 0.0, 3.0}) {
        const Ground truth{height_m, pitch_deg * degree, roll_deg * degree};
        SCOPED_TRACE(std::to_string(height_m) + " m, " + std::to_string(pitch_deg) + "°, " + std::to_string(roll_deg));
        expect_found(search_extrinsics(rig, 0, seen(rig, truth, {std::max(6.0, 3 * height_m)}, seed++)), truth);
      }
    }
  }
}

TEST(ExtrinsicsSearch, FindsTheFloorUnderASmallRobot) {
  Rig rig{320, 240, 160, 160, 120, 0.06};
  for (const double pitch_deg : {0.0, 12.5, 25.0}) {
    const Ground truth{0.28, pitch_deg * degree, 0};
    SCOPED_TRACE(pitch_deg);
    expect_found(search_extrinsics(rig, 0, seen(rig, truth, {1.5, 4, 0.2, 0.1}, 5)), truth);
  }
}

TEST(ExtrinsicsSearch, AWallIsNoRoad) {
  const Rig rig{small_kitti_rig()};
  const Rig small{320, 240, 160, 160, 120, 0.06};
  unsigned seed{100};
  for (const Rig& any : {rig, small}) {
    for (const double ahead_m : {1.0, 2.0, 3.5, 6.0, 12.0, 25.0}) {
      SCOPED_TRACE(ahead_m);
      EXPECT_FALSE(search_extrinsics(any, 0, seen(any, {}, {0, ahead_m, 0.3, 0.1, false}, seed++)));
      EXPECT_FALSE(search_extrinsics(any, 0, seen(any, {}, {3, ahead_m, 0.3, 0.1, false}, seed++))) << "a corridor";
    }
  }
}

TEST(ExtrinsicsSearch, ChanceIsNoRoad) {
  const Rig rig{small_kitti_rig()};
  for (unsigned seed{1}; seed <= 5; ++seed) {
    EXPECT_FALSE(search_extrinsics(rig, 0, seen(rig, {}, {6, 0, 0.3, 1.0}, seed)));
  }
  EXPECT_FALSE(search_extrinsics(rig, 0, {}));
}

TEST(RoadSupport, IsCertainWhereTheLowestRowsAreRoad) {
  const RoadSupport certain{
      .all = 1000, .near = 700, .below = 20, .depth_ratio = 3, .columns = 8, .nearest_all = 200, .nearest = 180};
  EXPECT_TRUE(certain.is_certain());
  const auto without = [&](const auto& change) {
    RoadSupport support{certain};
    change(support);
    return support.is_certain();
  };
  EXPECT_FALSE(without([](RoadSupport& s) { s.near = 590; }));
  EXPECT_FALSE(without([](RoadSupport& s) { s.below = 60; }));
  EXPECT_FALSE(without([](RoadSupport& s) { s.nearest = 150; }));
  EXPECT_FALSE(without([](RoadSupport& s) { s.nearest_all = s.nearest = 40; }));
  EXPECT_FALSE(without([](RoadSupport& s) { s.depth_ratio = 1.9; }));
  EXPECT_FALSE(without([](RoadSupport& s) { s.columns = 6; }));
}

TEST(ExtrinsicsSearch, ALevelledImageShiftsTheRange) {
  const Rig rig{small_kitti_rig()};
  const Ground steep{1.2, 33 * degree, 0};
  const std::vector<GroundSample> samples{seen(rig, steep, {}, 9)};
  EXPECT_TRUE(search_extrinsics(rig, 0, samples));
  EXPECT_FALSE(search_extrinsics(rig, 10 * degree, samples)) << "the camera would look down by 43°";
}

TEST(SeenFrom, TurnsPitchAndKeepsTheRest) {
  const Ground level{seen_from({1.2, 3 * degree, 0}, 10 * degree)};
  EXPECT_EQ(level.height_m, 1.2);
  EXPECT_NEAR(level.pitch_rad / degree, 13, 1e-9);
  EXPECT_NEAR(level.roll_rad, 0, 1e-12);
  const Ground rolled{1.2, 3 * degree, 4 * degree};
  const Ground back{seen_from(seen_from(rolled, 20 * degree), -20 * degree)};
  EXPECT_NEAR(back.pitch_rad, rolled.pitch_rad, 1e-12);
  EXPECT_NEAR(back.roll_rad, rolled.roll_rad, 1e-12);
}

struct Watch {
  explicit Watch(bool is_given = false) : search{rig, gates(), 0, is_given} {}

  // True: the frame must not be relied on.
  bool take(const Ground& truth, const Ground& used, bool is_doubted, unsigned seed, Point2 place = {}) {
    return take(seen(rig, truth, {}, seed), used, is_doubted, place);
  }
  bool take(const std::vector<GroundSample>& samples, const Ground& used, bool is_doubted, Point2 place) {
    if (!search.is_wanted(is_doubted, 0.1)) return is_doubted;
    const std::optional<Ground> candidate{search.look(samples, used, is_doubted)};
    if (candidate && search.may_replace(samples, used, *candidate, place)) search.verify(samples, *candidate);
    return is_doubted || candidate;
  }

  Rig rig{small_kitti_rig()};
  ExtrinsicsSearch search;
};

TEST(ExtrinsicsSearch, BelievesWhatThreeFramesAgreeOn) {
  Watch watch;
  const Ground truth{1.1, 10 * degree, 0};
  for (unsigned frame{1}; frame <= 3; ++frame) {
    EXPECT_FALSE(watch.search.found());
    EXPECT_TRUE(watch.take(truth, {1.65, 0, 0}, false, frame)) << "nobody else doubts, but it lies elsewhere";
  }
  expect_found(watch.search.found(), truth);
}

TEST(ExtrinsicsSearch, DoesNotBelieveWhatKeepsChanging) {
  Watch watch;
  for (unsigned frame{1}; frame <= 8; ++frame) {
    watch.take({frame % 2 == 0 ? 1.1 : 2.4, 10 * degree, 0}, {1.65, 0, 0}, true, frame);
    EXPECT_FALSE(watch.search.found());
  }
}

TEST(ExtrinsicsSearch, AMountingThatFitsIsLeftAlone) {
  Watch watch;
  const Ground truth{1.75, 2 * degree, 1 * degree};
  for (unsigned frame{1}; frame <= 4; ++frame) EXPECT_FALSE(watch.take(truth, truth, false, frame));
  EXPECT_FALSE(watch.search.is_wanted(false, 0.1)) << "it has been seen to fit";
  EXPECT_FALSE(watch.search.found());
}

constexpr Ground assumed{1.65, 0, 0};
constexpr Ground moved{1.2, 8 * degree, 0};

// The first frames have shown that `assumed` fits.
Watch established(bool is_given = false) {
  Watch watch{is_given};
  for (unsigned frame{1}; frame <= 3; ++frame) watch.take(assumed, assumed, false, frame);
  return watch;
}

TEST(ExtrinsicsSearch, EstablishedExtrinsicsAreReplacedOnTheWay) {
  Watch watch{established()};
  int frames{0};
  while (frames < 60 && !watch.search.found()) {
    watch.take(moved, assumed, true, 50u + static_cast<unsigned>(frames), {0.5 * frames, 0});
    ++frames;
  }
  EXPECT_GE(frames, 20) << "lost for a second, then four heights of 1.2 m at 0.5 m a frame";
  EXPECT_LE(frames, 24);
  expect_found(watch.search.found(), moved);
}

TEST(ExtrinsicsSearch, EstablishedExtrinsicsStayWhileTheVehicleStands) {
  Watch watch{established()};
  for (unsigned frame{0}; frame < 60; ++frame) watch.take(moved, assumed, true, 50 + frame);
  EXPECT_FALSE(watch.search.found());
}

TEST(ExtrinsicsSearch, GivenExtrinsicsStay) {
  Watch watch{true};
  for (unsigned frame{0}; frame < 40; ++frame) {
    EXPECT_TRUE(watch.take(moved, assumed, frame > 2, 50 + frame, {0.5 * frame, 0})) << "another plane is seen";
  }
  EXPECT_FALSE(watch.search.found());
}

TEST(ExtrinsicsSearch, ALowerFloorDoesNotExplainTheNearestGround) {
  Watch watch{established()};
  const RoadPlane own{road_plane(watch.rig, assumed)};
  const RoadPlane lower{road_plane(watch.rig, {2.6, 0, 0})};
  std::vector<GroundSample> samples;
  for (int v{6}; v < watch.rig.height_px; v += 6) {
    for (int u{6}; u < watch.rig.width_px; u += 6) {
      const RoadPlane& floor{v > watch.rig.height_px - 20 ? own : lower};
      const double d{floor.disparity(u, v)};
      if (d > 1) samples.push_back({static_cast<float>(u), static_cast<float>(v), static_cast<float>(d)});
    }
  }
  ASSERT_TRUE(search_extrinsics(watch.rig, 0, samples)) << "the lower floor is found";
  for (int frame{0}; frame < 60; ++frame) watch.take(samples, assumed, true, {0.5 * frame, 0});
  EXPECT_FALSE(watch.search.found());
}

// Plane of a slope that begins `begin_m` ahead on the plane `assumed`.
Ground slope_from(double begin_m, double slope_deg) {
  const double slope{slope_deg * degree};
  return {assumed.height_m * std::cos(slope) + begin_m * std::sin(slope), slope, 0};
}

TEST(ExtrinsicsSearch, ASlopeBeginsBetweenTheVehicleAndTheNearestGround) {
  Watch watch{true};
  const auto finds = [&](const Ground& ground) {
    return watch.search.find_slope(seen(watch.rig, ground, {}, 7), {}).has_value();
  };
  for (const double slope_deg : {-8.0, -6.0, 6.0, 12.0}) {
    for (const double begin_m : {1.0, 2.5}) EXPECT_TRUE(finds(slope_from(begin_m, slope_deg))) << slope_deg;
    EXPECT_FALSE(finds({assumed.height_m, slope_deg * degree, 0})) << slope_deg << ": the camera was turned";
    EXPECT_FALSE(finds(slope_from(-2, slope_deg))) << slope_deg << ": the camera was moved";
  }
  EXPECT_FALSE(finds(slope_from(1, 25))) << "too steep";
  EXPECT_FALSE(finds({2.6, 0, 0})) << "a lower floor";
  EXPECT_FALSE((Watch{false}.search.find_slope(seen(watch.rig, slope_from(1, 6), {}, 7), {}))) << "assumed extrinsics";
}

TEST(ExtrinsicsSearch, ASlopeEnds) {
  Watch watch{true};
  const std::vector<GroundSample> samples{seen(watch.rig, slope_from(1, 6), {}, 7)};
  EXPECT_TRUE(watch.search.find_slope(samples, {}));
  EXPECT_TRUE(watch.search.find_slope(samples, {16, 0}));
  EXPECT_FALSE(watch.search.find_slope(samples, {17, 0}));
  watch.search.leave_slope();
  EXPECT_TRUE(watch.search.find_slope(samples, {17, 0}));
}

TEST(ExtrinsicsSearch, ANewBeginningKeepsWhatIsEstablished) {
  Watch watch{established()};
  watch.search.begin_again();
  EXPECT_FALSE(watch.search.is_wanted(false, 0));
}

TEST(ExtrinsicsSearch, WhatIsNotToBeEstimatedIsNotSearched) {
  GroundConfig trusted{gates()};
  trusted.estimate = false;
  ExtrinsicsSearch search{small_kitti_rig(), trusted, 0, false};
  EXPECT_FALSE(search.is_wanted(true, 5));
}

}  // namespace
}  // namespace stereogrid::test
