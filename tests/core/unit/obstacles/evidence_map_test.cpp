// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

#include "flow_vectors.hpp"
#include "motion/velocity_evidence.hpp"
#include "painted_obstacles.hpp"

namespace stereogrid::test {
namespace {

constexpr GridGeometry window{-4, -4, 0.2, 40, 40};

// Velocities up to 8 m/s in steps without effect.
std::vector<double> continuous_axis() {
  std::vector<double> axis_mps;
  for (int i{-20000}; i <= 20000; ++i) axis_mps.push_back(0.0004 * i);
  return axis_mps;
}

TEST(EvidenceMap, CoversTheCellsAroundAPoint) {
  EvidenceMap map{40, continuous_axis()};
  const std::vector<VelocityEvidence> evidence{map.gather({vector_at({0.1, 0.1}, {2, -1})}, window, in_one)};
  ASSERT_GT(evidence.size(), 9u);
  EXPECT_TRUE(std::is_sorted(evidence.begin(), evidence.end(),
                             [](const VelocityEvidence& a, const VelocityEvidence& b) { return a.cell < b.cell; }));
  float most{0};
  int surest{-1};
  for (const VelocityEvidence& one : evidence) {
    EXPECT_NEAR(one.x, 2, 1e-5);
    EXPECT_NEAR(one.y, -1, 1e-5);
    if (one.xx > most) surest = one.cell;
    most = std::max(most, one.xx);
    const double away_m{std::hypot(one.cell % 40 - 20, one.cell / 40 - 20) * 0.2};
    EXPECT_LT(away_m, 0.8);
  }
  EXPECT_EQ(surest, 20 * 40 + 20) << "the point's own cell";
  EXPECT_TRUE(map.gather({}, window, in_one).empty()) << "nothing is left of the frame before";
}

// Points share errors: twenty of them count as four.
TEST(EvidenceMap, InformationOfManyPointsIsBounded) {
  EvidenceMap map{40, continuous_axis()};
  const auto information_of = [&](std::size_t points) {
    const std::vector<FlowVector> equal(points, vector_at({0.1, 0.1}, {2, -1}));
    for (const VelocityEvidence& one : map.gather(equal, window, in_one)) {
      if (one.cell == 20 * 40 + 20) return one.xx;
    }
    return -1.0f;
  };
  constexpr double of_one{0.5 / (0.5 * 0.5)};  // half of a point's information, which enters several frames
  EXPECT_NEAR(information_of(1), of_one, 1e-5);
  EXPECT_NEAR(information_of(4), 4 * of_one, 1e-5);
  EXPECT_NEAR(information_of(20), 4 * of_one, 1e-5);
}

// A lattice with steps of 3 m/s has no velocity near one in the middle between two.
TEST(EvidenceMap, IsNoMorePreciseThanTheLattice) {
  EvidenceMap map{40, {-6, -3, 0, 3, 6}};
  const std::vector<FlowVector> precise(4, vector_at({0.1, 0.1}, {1.5, 1.5}, 0.1));
  for (const VelocityEvidence& one : map.gather(precise, window, in_one)) {
    if (one.cell != 20 * 40 + 20) continue;
    EXPECT_NEAR(one.xx, 1 / (0.1 * 0.1 / 2 + 3 * 3 / 6.0), 1e-5);
    EXPECT_GT(likelihood_of(one, 3.0f, 3.0f), 0.05f);
  }
}

TEST(EvidenceMap, IsTheSameHoweverTheRowsAreDivided) {
  const std::vector<FlowVector> points{vector_at({0.1, 0.1}, {2, -1}), vector_at({0.4, 0.3}, {3, 0}),
                                       vector_at({-2, 1.5}, {0, 1}), vector_at({0.2, -0.2}, {1, 1})};
  EvidenceMap map{40, continuous_axis()};
  const std::vector<VelocityEvidence> expected{map.gather(points, window, in_one)};
  ASSERT_FALSE(expected.empty());
  const auto from_the_end = [](int count, const auto& work) {
    for (int end{count}; end > 0; end -= 3) work(std::max(end - 3, 0), end);
  };
  const std::vector<VelocityEvidence>& divided{map.gather(points, window, from_the_end)};
  ASSERT_EQ(divided.size(), expected.size());
  for (std::size_t i{0}; i < expected.size(); ++i) {
    const auto numbers = [](const VelocityEvidence& one) {
      return std::tuple{one.cell, one.x, one.y, one.xx, one.xy, one.yy};
    };
    EXPECT_EQ(numbers(divided[i]), numbers(expected[i]));
  }
}

TEST(EvidenceMap, PointsThatContradictEachOtherSayLittle) {
  EvidenceMap map{40, continuous_axis()};
  const auto information_at_middle = [&](Point2 second) {
    for (const VelocityEvidence& one :
         map.gather({vector_at({0.1, 0.1}, {2, 0}), vector_at({0.1, 0.1}, second)}, window, in_one)) {
      if (one.cell == 20 * 40 + 20) return one.xx;
    }
    return -1.0f;
  };
  const float agreeing{information_at_middle({2, 0})};
  EXPECT_GT(agreeing, 0);
  EXPECT_LT(information_at_middle({-4, 0}), agreeing / 5);
}

// Three features at 3 m/s; one measured 9 m/s, with a large error, the other place is a wrong match.
TEST(EvidenceMap, FeaturesAreAveragedWithThoseThatAgree) {
  EvidenceMap map{40, continuous_axis()};
  std::vector<FlowVector> features(3, vector_at({0.1, 0.1}, {3, 0}));
  features.push_back(vector_at({-1.3, 0.1}, {6, 0}, 2));
  features.push_back(vector_at({-1.3, 0.1}, {-8, 0}));
  const auto at = [&](int cell) {
    for (const VelocityEvidence& one : map.gather(features, window, in_one)) {
      if (one.cell == cell) return one;
    }
    return VelocityEvidence{};
  };
  constexpr int near_both{20 * 40 + 13};
  EXPECT_EQ(at(20 * 40 + 20).starts_motion, 1);
  EXPECT_EQ(at(near_both).starts_motion, 0) << "one supported feature";
  features.pop_back();
  EXPECT_NEAR(at(near_both).x, 3, 0.1);
  features.back().place.x = 3.5;  // too far away
  EXPECT_EQ(at(20 * 40 + 20).starts_motion, 0) << "three in all";
  EXPECT_NEAR(at(20 * 40 + 37).x, 6, 1e-5);
}

TEST(EvidenceMap, MarksStandstillThatIsSeenAgainFromTheSamePlace) {
  EvidenceMap map{40, continuous_axis()};
  const auto mark = [&](Point2 velocity, double travelled_m) {
    const CameraView view{{-3, 0, 0}, 1, 1, 56 * travelled_m, 56};
    for (const VelocityEvidence& one : map.gather({vector_at({0.1, 0.1}, velocity)}, window, in_one, view)) {
      if (one.cell == 20 * 40 + 20) return one.is_repeated;
    }
    return -1;
  };
  EXPECT_EQ(mark({0, 0}, 0), 1);
  EXPECT_EQ(mark({3, 0}, 0), 0) << "it moves";
  EXPECT_EQ(mark({0, 0}, 0.5), 0) << "3 m away the disparity has changed by 3 px";
}

TEST(EvidenceMap, IsNotFasterThanTheLatticeAndStaysInTheWindow) {
  EvidenceMap map{40, continuous_axis()};
  for (const VelocityEvidence& one :
       map.gather({vector_at({3.9, 3.9}, {13, -20}), vector_at({50, 0}, {1, 1})}, window, in_one)) {
    EXPECT_EQ(one.x, 8);
    EXPECT_EQ(one.y, -8);
    EXPECT_LT(one.cell, 1600);
  }
}

}  // namespace
}  // namespace stereogrid::test
