// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "obstacles/segmentation/side_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace stereogrid::test {
namespace {

/// Strips of 10 columns from column 0 on, with these disparities and 0.3 px of noise.
std::vector<SideSample> samples_of(const std::vector<double>& disparities) {
  std::vector<SideSample> samples;
  for (std::size_t i{0}; i < disparities.size(); ++i) {
    samples.push_back({10.0 * static_cast<double>(i), 10.0 * static_cast<double>(i) + 10, disparities[i], 0.3});
  }
  return samples;
}

TEST(SideFit, PlanesHaveTwoPoints) {
  std::mt19937 random{3};
  std::uniform_real_distribution<double> noise{-0.25, 0.25};
  std::vector<double> disparities;
  for (int i{0}; i < 12; ++i) disparities.push_back(20 + 0.05 * (10 * i + 5) + noise(random));
  const SideFit fit{samples_of(disparities), 12};
  ASSERT_EQ(fit.size(), 2U);
  EXPECT_EQ(fit.column(0), 0);
  EXPECT_EQ(fit.column(1), 120);
  EXPECT_NEAR(fit.disparity(0), 20, 0.3);
  EXPECT_NEAR(fit.disparity(1), 26, 0.3);
}

TEST(SideFit, CornersHaveAPoint) {
  std::vector<double> disparities;
  for (int i{0}; i < 12; ++i) disparities.push_back(30 - 0.1 * std::abs(10 * i + 5 - 40));
  const SideFit fit{samples_of(disparities), 4};
  ASSERT_EQ(fit.size(), 3U);
  EXPECT_EQ(fit.column(1), 40);
  EXPECT_NEAR(fit.disparity(0), 26, 0.05);
  EXPECT_NEAR(fit.disparity(1), 30, 0.05);
}

TEST(SideFit, PointsAreLimited) {
  std::vector<double> teeth;
  for (int i{0}; i < 12; ++i) teeth.push_back(i % 2 == 0 ? 20 : 30);
  for (const std::size_t most : {2U, 4U, 12U}) {
    SideFit fit{samples_of(teeth), most};
    EXPECT_LE(fit.size(), most);
    for (std::size_t i{0}; i < fit.size(); ++i) {
      EXPECT_GE(fit.disparity(i), 19);
      EXPECT_LE(fit.disparity(i), 31);
      EXPECT_TRUE(i == 0 || fit.column(i) > fit.column(i - 1)) << i;
    }
    const std::size_t points{fit.size()};
    fit.refit(samples_of(std::vector<double>(12, 15)));
    EXPECT_EQ(fit.size(), points);
    for (std::size_t i{0}; i < fit.size(); ++i) EXPECT_NEAR(fit.disparity(i), 15, 1e-9);
  }
}

TEST(SideFit, OneSampleIsLevel) {
  const SideFit fit{samples_of({25}), 4};
  ASSERT_EQ(fit.size(), 2U);
  EXPECT_NEAR(fit.disparity(0), 25, 1e-9);
  EXPECT_NEAR(fit.disparity(1), 25, 1e-9);
}

}  // namespace
}  // namespace stereogrid::test
