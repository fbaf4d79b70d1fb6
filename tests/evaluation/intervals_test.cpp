// SPDX-License-Identifier: Apache-2.0
#include "support.hpp"

namespace stereogrid::evaluation::testing {
namespace {

/// Frames whose cells have a share of misses of their own.
Scores drive(const std::vector<double>& miss_shares) {
  Scores scores;
  std::mt19937 random{3};
  for (const double share : miss_shares) {
    std::vector<float> p(300);
    std::string labels(p.size(), '0');
    for (std::size_t i{0}; i < p.size(); ++i) {
      if (i % 3 == 0) labels[i] = i % 6 == 0 ? '1' : 'o';
      const bool wrong{static_cast<double>(random() % 10000) / 10000 < share};
      p[i] = (labels[i] != '0') != wrong ? 0.9F : 0.1F;
      p[i] += static_cast<float>(random() % 100) / 1000;
    }
    const Image<float> grid(lane_of(p));
    scores.add("", grid.view(), lane_labels(labels));
  }
  return scores;
}

TEST(Intervals, HoldTheFigures) {
  const Scores scores(drive({0.1, 0.2, 0.15, 0.1, 0.3, 0.1, 0.2, 0.15, 0.2, 0.1, 0.1, 0.3}));
  const Summary summary(scores.summary(everything));
  for (const Metric& metric : metrics) {
    const Estimate& estimate{summary.*metric.estimate};
    if (std::isnan(estimate.value)) continue;
    EXPECT_LE(estimate.low, estimate.value + 1e-3) << metric.name;
    EXPECT_GE(estimate.high, estimate.value - 1e-3) << metric.name;
  }
  EXPECT_GT(summary.missed.high, summary.missed.low);
}

TEST(Intervals, AreTheSameEveryTime) {
  const Scores scores(drive({0.1, 0.4, 0.2, 0.3, 0.1, 0.2}));
  EXPECT_EQ(scores.summary(everything).auc.low, scores.summary(everything).auc.low);
}

TEST(Intervals, AreAsWideAsFramesDiffer) {
  const Summary even(drive(std::vector<double>(16, 0.2)).summary(everything));
  // first half good, second half bad: neighbours are alike, so that few frames are as good as independent
  std::vector<double> halves(8, 0.05);
  halves.resize(16, 0.35);
  const Summary uneven(drive(halves).summary(everything));
  EXPECT_NEAR(even.missed.value, uneven.missed.value, 0.03);
  EXPECT_GT(uneven.missed.high - uneven.missed.low, 3 * (even.missed.high - even.missed.low));
  // expected for 16 independent frames of this spread: ± 2 · 0.15 / 4
  EXPECT_GT(uneven.missed.high - uneven.missed.low, 0.15);
}

TEST(Intervals, OfRanksAreThoseOfTheExactRanks) {
  // more values than the resamples have groups
  const Scores scores(drive(std::vector<double>(30, 0.2)));
  const Summary summary(scores.summary(everything));
  EXPECT_NEAR((summary.auc.low + summary.auc.high) / 2, summary.auc.value, 0.005);
  EXPECT_LT(summary.auc.high - summary.auc.low, 0.05);
}

TEST(Intervals, NeedSomeFrames) {
  const Summary summary(drive({0.2, 0.2, 0.2}).summary(everything));
  EXPECT_FALSE(std::isnan(summary.missed.value));
  EXPECT_TRUE(std::isnan(summary.missed.low));
  const Summary without(drive(std::vector<double>(10, 0.2)).summary(everything, 0));
  EXPECT_TRUE(std::isnan(without.missed.high));
}

}  // namespace
}  // namespace stereogrid::evaluation::testing
