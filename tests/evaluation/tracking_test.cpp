// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/evaluation/tracking.hpp"

#include <gmock/gmock.h>

#include <cmath>

namespace stereogrid::evaluation::testing {
namespace {

constexpr double no{TrackingFrame::no_match};

TrackingFrame frame(std::vector<std::int64_t> objects, const std::vector<std::int64_t>& hypotheses,
                    std::vector<double> distances) {
  TrackingFrame made{std::move(objects), {}, std::move(distances)};
  for (const std::int64_t id : hypotheses) made.hypotheses.push_back({id, false});
  return made;
}

TEST(Tracking, OfAPerfectTracker) {
  TrackingScores scores;
  for (int i{0}; i < 3; ++i) scores.add(frame({1, 2}, {20, 10}, {no, 0.5, 0.25, no}));
  const TrackingSummary s(scores.summary());
  EXPECT_EQ(s.tracks, 2U);
  EXPECT_EQ(s.objects, 6U);
  EXPECT_EQ(s.matches, 6U);
  EXPECT_EQ(s.mostly_tracked, 2U);
  EXPECT_EQ(s.mostly_lost, 0U);
  EXPECT_EQ(s.mota, 1);
  EXPECT_EQ(s.motp, 0.375);
  EXPECT_EQ(s.idf1, 1);
}

TEST(Tracking, CountsWhatNothingBelongsTo) {
  TrackingScores scores;
  scores.add(frame({1, 2}, {10, 11, 12}, {0, no, no, no, no, no}));  // a miss, two false positives
  scores.add(frame({1, 2}, {}, {}));                                 // two misses
  TrackingFrame last{frame({}, {13, 14}, {})};
  last.hypotheses[1].ignored = true;
  scores.add(last);  // a false positive
  const TrackingSummary s(scores.summary());
  EXPECT_EQ(s.misses, 3U);
  EXPECT_EQ(s.false_positives, 3U);
  EXPECT_EQ(s.mota, 1 - 6.0 / 4);
  EXPECT_EQ(s.id_true_positives, 1U);
  EXPECT_EQ(s.id_false_positives, 3U);
  EXPECT_EQ(s.id_misses, 3U);
  EXPECT_EQ(s.idf1, 2.0 / (2 + 3 + 3));
  EXPECT_EQ(s.mostly_lost, 1U);
}

TEST(Tracking, CountsSwitchesAndInterruptions) {
  TrackingScores scores;
  // found as 10 10 – 10 11 – 11, then not to be found
  for (const std::int64_t id : {10, 10, 0, 10, 11, 0, 11}) {
    scores.add(id == 0 ? frame({1}, {}, {}) : frame({1}, {id}, {0}));
  }
  const TrackingSummary s(scores.summary());
  EXPECT_EQ(s.id_switches, 1U);
  EXPECT_EQ(s.fragmentations, 2U);
  EXPECT_EQ(s.matches, 5U);
  EXPECT_DOUBLE_EQ(s.mota, 1 - (2.0 + 0 + 1) / 7);
  EXPECT_EQ(s.id_true_positives, 3U);
  EXPECT_DOUBLE_EQ(s.idf1, 2.0 * 3 / (7 + 5));
  EXPECT_DOUBLE_EQ(s.id_precision, 3.0 / 5);
  EXPECT_DOUBLE_EQ(s.id_recall, 3.0 / 7);
}

TEST(Tracking, KeepsAMatchThatStillHolds) {
  TrackingScores scores;
  scores.add(frame({1}, {10}, {0.1}));
  const auto matches{scores.add(frame({1}, {11, 10}, {0.1, 0.9}))};  // 11 is nearer now
  ASSERT_EQ(matches.size(), 1U);
  EXPECT_EQ(matches[0].hypothesis, 1U);
  EXPECT_EQ(scores.summary().id_switches, 0U);
  EXPECT_EQ(scores.summary().false_positives, 1U);
  scores.add(frame({1}, {11, 10}, {0.1, no}));
  EXPECT_EQ(scores.summary().id_switches, 1U);
}

TEST(Tracking, MatchesAsManyAsCanBe) {
  TrackingScores scores;
  // the nearest pair first would leave object 2 alone
  EXPECT_EQ(scores.add(frame({1, 2}, {10, 11}, {0.1, 1, 0.2, no})).size(), 2U);
  EXPECT_DOUBLE_EQ(scores.summary().motp, 0.6);
  TrackingScores others;
  others.add(frame({1, 2, 3}, {10, 11, 12}, {4, 1, 3, 2, 0, 5, 3, 2, 2}));
  EXPECT_DOUBLE_EQ(others.summary().motp, 5.0 / 3);  // 1 + 2 + 2
}

TEST(Tracking, OneHypothesisStandsForOneObjectOfTheDrive) {
  TrackingScores scores;
  // 10 is with 1 for two frames and with 2 for three
  for (int i{0}; i < 2; ++i) scores.add(frame({1, 2}, {10}, {0, no}));
  for (int i{0}; i < 3; ++i) scores.add(frame({1, 2}, {10}, {no, 0}));
  const TrackingSummary s(scores.summary());
  EXPECT_EQ(s.id_switches, 0U);
  EXPECT_EQ(s.matches, 5U);
  EXPECT_EQ(s.id_true_positives, 3U);
  EXPECT_DOUBLE_EQ(s.idf1, 2.0 * 3 / (10 + 5));
}

TEST(Tracking, OfNothing) {
  const TrackingSummary s(TrackingScores{}.summary());
  EXPECT_TRUE(std::isnan(s.mota));
  EXPECT_TRUE(std::isnan(s.idf1));
  EXPECT_EQ(s.objects, 0U);
}

}  // namespace
}  // namespace stereogrid::evaluation::testing
