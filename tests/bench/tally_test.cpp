// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "accuracy/tally.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace stereogrid::bench {
namespace {

TEST(DisparityTally, CountsByHand) {
  DisparityTally tally;
  for (const float found : {0.0F, 20.0F, 21.0F, 21.5F, 17.0F, 23.5F, 60.0F, 0.0F}) tally.add(found, 20);
  EXPECT_EQ(tally.points(), 8);
  EXPECT_DOUBLE_EQ(tally.density(), 6.0 / 8);
  EXPECT_DOUBLE_EQ(tally.wrong_by_3_of_matched(), 2.0 / 6);  // exactly 3 px is not more than 3
  EXPECT_DOUBLE_EQ(tally.wrong_by_1_of_matched(), 4.0 / 6);
  EXPECT_DOUBLE_EQ(tally.wrong_by_3_of_all(), 2.0 / 8);
  EXPECT_DOUBLE_EQ(tally.wrong_by_1_of_all(), 4.0 / 8);
  EXPECT_NEAR(tally.median_error_px(), 1.5, 0.02);
}

TEST(DisparityTally, SumsAndNothing) {
  DisparityTally none;
  EXPECT_EQ(none.density(), 0);
  EXPECT_EQ(none.wrong_by_3_of_matched(), 0);
  EXPECT_EQ(none.median_error_px(), 0);
  DisparityTally a;
  a.add(10, 10.25F);
  DisparityTally b;
  b.add(100, 10);
  b.add(0, 10);
  a += b;
  EXPECT_EQ(a.points(), 3);
  EXPECT_DOUBLE_EQ(a.wrong_by_3_of_matched(), 0.5);
  EXPECT_NEAR(a.median_error_px(), 0.25, 0.02);
  DisparityTally far;
  far.add(100, 10);
  EXPECT_EQ(far.median_error_px(), 10);
}

TEST(LabelTally, OfMatchedAndOfAll) {
  const TruthPoint road{5, 5, 10, Surface::road, false};
  const TruthPoint road_at_contact{5, 5, 10, Surface::road, true};
  LabelTally tally;
  tally.add(Surface::road, road);
  tally.add(Surface::obstacle, road);
  tally.add(Surface::other, road);
  tally.add(Surface::obstacle, road_at_contact);
  EXPECT_DOUBLE_EQ(tally.accuracy(), 1.0 / 3);
  EXPECT_DOUBLE_EQ(tally.accuracy_away(), 1.0 / 2);
  EXPECT_DOUBLE_EQ(tally.mistaken(), 2.0 / 4);
  EXPECT_DOUBLE_EQ(tally.mistaken_away(), 1.0 / 3);
  LabelTally twice{tally};
  twice += tally;
  EXPECT_EQ(twice.points, 8);
  EXPECT_DOUBLE_EQ(twice.mistaken_away(), tally.mistaken_away());
}

TEST(Reliability, OfAnHonestConfidence) {
  Reliability reliability;
  for (int tenth{0}; tenth < 10; ++tenth) {
    for (int i{0}; i < 100; ++i) reliability.add(static_cast<float>(tenth) / 10 + 0.05F, i < 10 * tenth + 5);
  }
  EXPECT_EQ(reliability.points(), 1000);
  EXPECT_NEAR(reliability.expected_calibration_error(), 0, 1e-6);
  for (const Reliability::Bin& bin : reliability.table()) {
    EXPECT_EQ(bin.points, 100);
    EXPECT_NEAR(bin.mean_confidence(), bin.right_share(), 1e-6);
  }
}

TEST(Reliability, OfABraggart) {
  Reliability reliability;
  for (int i{0}; i < 100; ++i) reliability.add(0.95F, i < 60);
  EXPECT_NEAR(reliability.expected_calibration_error(), 0.35, 1e-6);
  EXPECT_NEAR(reliability.table()[9].right_share(), 0.6, 1e-12);
  Reliability half;  // the other half is honest: the error is shared out over all points
  for (int i{0}; i < 100; ++i) half.add(0.15F, i < 15);
  half += reliability;
  EXPECT_NEAR(half.expected_calibration_error(), 0.175, 1e-6);
}

TEST(Reliability, EndsOfTheRange) {
  Reliability reliability;
  EXPECT_EQ(reliability.expected_calibration_error(), 0);
  reliability.add(1, true);
  reliability.add(7, true);
  reliability.add(0, false);
  reliability.add(-1, false);
  reliability.add(std::numeric_limits<float>::quiet_NaN(), false);
  EXPECT_EQ(reliability.table()[9].points, 2);
  EXPECT_EQ(reliability.table()[0].points, 3);
  EXPECT_EQ(reliability.expected_calibration_error(), 0);
}

TEST(IsRight, ToAPixel) {
  EXPECT_TRUE(is_right(11, 10));
  EXPECT_TRUE(is_right(9, 10));
  EXPECT_FALSE(is_right(11.1F, 10));
}

}  // namespace
}  // namespace stereogrid::bench
