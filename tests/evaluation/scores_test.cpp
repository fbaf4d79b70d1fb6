// SPDX-License-Identifier: Apache-2.0
#include "support.hpp"

namespace stereogrid::evaluation::testing {
namespace {

Summary summary_of(const std::vector<float>& probabilities, const std::string& labels) {
  Scores scores;
  const Image<float> grid(lane_of(probabilities));
  scores.add("a", grid.view(), lane_labels(labels));
  return scores.summary(everything);
}

TEST(Scores, AreWhatOneFindsByHand) {
  //                               hit   missed unknown  free  false alarm  free   not scored
  const Summary s(summary_of({0.9F, 0.2F, 0.5F, 0.1F, 0.8F, 0.4F, 0.7F}, "111000."));
  EXPECT_EQ(s.frames, 1U);
  EXPECT_EQ(s.cells, 6U);
  EXPECT_EQ(s.occupied, 3U);
  const double loss{-(std::log(0.9) + std::log(0.2) + std::log(0.5)) / 3 -
                    (std::log(0.9) + std::log(0.2) + std::log(0.6)) / 3};
  EXPECT_NEAR(s.balanced_log_loss.value, loss / 2, 1e-7);
  EXPECT_NEAR(s.brier.value, (0.01 + 0.64 + 0.25 + 0.01 + 0.64 + 0.16) / 6, 1e-7);
  EXPECT_NEAR(s.auc.value, 6.0 / 9, 1e-12);  // 0.9 beats three free cells, 0.5 two, 0.2 one
  EXPECT_NEAR(s.iou_occupied.value, 1.0 / 4, 1e-12);
  EXPECT_NEAR(s.iou_free.value, 2.0 / 4, 1e-12);
  EXPECT_NEAR(s.missed.value, 1.0 / 3, 1e-12);
  EXPECT_NEAR(s.false_alarms.value, 1.0 / 3, 1e-12);
  EXPECT_NEAR(s.known.value, 5.0 / 6, 1e-12);
  // every cell has a bin of its own but 0.5 and 0.4, which lie in bins 7 and 6
  EXPECT_NEAR(s.calibration_error.value, (0.1 + 0.8 + 0.5 + 0.1 + 0.8 + 0.4) / 6, 1e-7);
  EXPECT_EQ(s.reliability[13].cells, 1U);
  EXPECT_NEAR(s.reliability[13].mean_probability, 0.9, 1e-7);
  EXPECT_EQ(s.reliability[13].share_occupied, 1);
  EXPECT_EQ(s.reliability[0].cells, 0U);
}

TEST(Scores, TiesCountHalf) {
  EXPECT_NEAR(summary_of({0.5F, 0.5F, 0.5F, 0.5F}, "1100").auc.value, 0.5, 1e-12);
  EXPECT_NEAR(summary_of({0.9F, 0.5F, 0.5F, 0.1F}, "1100").auc.value, 3.5 / 4, 1e-12);
}

TEST(Scores, ClipProbabilities) {
  const Summary s(summary_of({1.0F, 0.0F, 1.0F, 0.0F}, "1100"));
  EXPECT_NEAR(s.balanced_log_loss.value, -0.5 * (std::log(0.999) + std::log(0.001)), 1e-9);
}

TEST(Scores, SayNothingWhereThereIsNothing) {
  const Summary s(summary_of({0.5F, 0.1F, 0.1F}, "000"));
  EXPECT_EQ(s.occupied, 0U);
  EXPECT_TRUE(std::isnan(s.auc.value));
  EXPECT_TRUE(std::isnan(s.balanced_log_loss.value));
  EXPECT_TRUE(std::isnan(s.hidden_recall.value));
  EXPECT_TRUE(std::isnan(s.depth_error_m.value));
  EXPECT_TRUE(std::isnan(Scores{}.summary(everything).known.value));
}

TEST(Scores, KeepToTheirBand) {
  Scores scores;
  const Image<float> grid(lane_of({0.1F, 0.9F, 0.2F, 0.8F}));
  scores.add("a", grid.view(), lane_labels("0101"));
  EXPECT_EQ(scores.summary({0, 2}).cells, 2U);  // centres at 0.5 and 1.5
  EXPECT_EQ(scores.summary({0.5, 1.5}).cells, 1U);
  EXPECT_NEAR(scores.summary({2, 4}).brier.value, 0.04, 1e-7);
}

TEST(Scores, ClearBandsLeaveHiddenGroundOut) {
  const Image<float> grid(lane_of({0.1F, 0.9F, 0.9F, 0.1F}));
  Labels labels(lane_labels("0100"));
  Scores exact;
  exact.add("", grid.view(), labels);
  EXPECT_FALSE(exact.has_hidden_ground());
  labels.hidden_ground = Image<std::uint8_t>{4, 1};
  labels.hidden_ground(2, 0) = 1;
  Scores scores;
  scores.add("", grid.view(), labels);
  EXPECT_TRUE(scores.has_hidden_ground());
  EXPECT_EQ(scores.summary(everything).cells, 4);
  EXPECT_NEAR(scores.summary(everything).false_alarms.value, 1.0 / 3, 1e-12);
  const Band clear{everything.from_m, everything.to_m, true};
  EXPECT_EQ(scores.summary(clear).cells, 3);
  EXPECT_EQ(scores.summary(clear).false_alarms.value, 0);
}

TEST(Scores, OfPartlyHiddenCells) {
  // 100 free cells of which one has p = 0.8: at 1 % false alarms the threshold lies below 0.8
  std::vector<float> p(104, 0.1F);
  std::string labels(104, '0');
  p[0] = 0.8F;
  p[100] = 0.9F;  // hidden, above all free cells
  p[101] = 0.5F;  // hidden, above all but one
  p[102] = 0.1F;  // hidden, as the other free ones: missed
  p[103] = 0.95F;
  labels.replace(100, 4, "ooo1");
  labels[1] = 'f';
  const Summary s(summary_of(p, labels));
  EXPECT_EQ(s.hidden_occupied, 3U);
  EXPECT_EQ(s.hidden_free, 1U);
  EXPECT_NEAR(s.hidden_recall.value, 2.0 / 3, 1e-12);
  EXPECT_NEAR(s.hidden_missed.value, 1.0 / 3, 1e-12);
  EXPECT_NEAR(s.hidden_auc.value, 2.5 / 3, 1e-12);
  // one hidden free cell, level with the last hidden occupied one: a hundredth of its step
  EXPECT_NEAR(s.hidden_recall_strict.value, (2 + 0.01) / 3, 1e-12);
}

// Three false alarms beside surfaces are more than 1 % of 200 free cells, but no phantoms.
TEST(Scores, OfPartlyHiddenCellsWithoutThoseBesideASurface) {
  std::vector<float> p(205, 0.1F);
  std::string labels(205, '0');
  for (const std::size_t occupied : {50U, 100U}) labels[occupied] = '1';
  for (const std::size_t beside : {49U, 51U, 99U}) p[beside] = 0.95F;
  p[200] = 0.9F;
  p[201] = 0.5F;
  labels.replace(200, 3, "ooo");
  const Summary s(summary_of(p, labels));
  EXPECT_NEAR(s.hidden_recall.value, 0, 1e-12);
  EXPECT_NEAR(s.hidden_recall_clear.value, 2.0 / 3, 0.01);
}

TEST(Scores, DrawTheRoc) {
  Scores scores;
  const Image<float> grid(lane_of({0.9F, 0.6F, 0.4F, 0.1F}));
  scores.add("a", grid.view(), lane_labels("1o00"));
  const auto all(scores.roc(everything));
  ASSERT_EQ(all.size(), 4U);
  EXPECT_EQ(all[1].recall, 0.5);
  EXPECT_EQ(all[2].recall, 1);
  EXPECT_EQ(all[2].false_alarms, 0);
  EXPECT_EQ(all[3].false_alarms, 1);
  EXPECT_EQ(scores.roc(everything, Scores::Positives::partly_hidden)[1].recall, 0);
}

/// Random probabilities and labels over some frames.
struct Drive {
  std::vector<std::vector<float>> probabilities;
  std::vector<std::string> labels;
};

template <class Probability>
Drive random_drive(int frames, Probability probability) {
  std::mt19937 random{5};
  Drive drive;
  for (int frame{0}; frame < frames; ++frame) {
    std::vector<float> p(400);
    std::string labels(p.size(), '0');
    for (std::size_t i{0}; i < p.size(); ++i) {
      const unsigned kind{static_cast<unsigned>(random() % 8)};
      labels[i] = "1of00000"[kind];
      p[i] = probability(kind < 2, static_cast<float>(random() % 10000) / 10000);
    }
    drive.probabilities.push_back(p);
    drive.labels.push_back(labels);
  }
  return drive;
}

Scores scores_of(const Drive& drive) {
  Scores scores;
  for (std::size_t i{0}; i < drive.labels.size(); ++i) {
    const Image<float> grid(lane_of(drive.probabilities[i]));
    scores.add(std::to_string(i), grid.view(), lane_labels(drive.labels[i]));
  }
  return scores;
}

TEST(Scores, OfGuessesAndOfTheTruth) {
  const Drive guesses(random_drive(20, [](bool, float chance) { return chance; }));
  EXPECT_NEAR(scores_of(guesses).summary(everything, 0).auc.value, 0.5, 0.02);
  EXPECT_NEAR(scores_of(guesses).summary(everything, 0).hidden_recall.value, 0.01, 0.01);
  const Drive truth(random_drive(20, [](bool occupied, float) { return occupied ? 1.0F : 0.0F; }));
  const Summary perfect(scores_of(truth).summary(everything, 0));
  EXPECT_EQ(perfect.auc.value, 1);
  EXPECT_EQ(perfect.iou_occupied.value, 1);
  EXPECT_EQ(perfect.iou_free.value, 1);
  EXPECT_EQ(perfect.hidden_recall.value, 1);
  EXPECT_LT(perfect.balanced_log_loss.value, 0.0011);
  EXPECT_EQ(perfect.depth_error_m.value, 0);
}

TEST(Scores, AMonotoneMapChangesNoRanks) {
  const auto noisy = [](bool occupied, float chance) { return 0.05F + 0.6F * chance + (occupied ? 0.3F : 0.0F); };
  Drive drive(random_drive(10, noisy));
  const Summary before(scores_of(drive).summary(everything, 0));
  for (auto& frame : drive.probabilities) {
    for (float& p : frame) p = p * p;
  }
  const Summary after(scores_of(drive).summary(everything, 0));
  EXPECT_EQ(after.auc.value, before.auc.value);
  EXPECT_EQ(after.hidden_recall.value, before.hidden_recall.value);
  EXPECT_EQ(after.hidden_auc.value, before.hidden_auc.value);
  EXPECT_NE(after.brier.value, before.brier.value);
}

TEST(Scores, ARightProbabilityIsCalibrated) {
  std::mt19937 random{9};
  Scores scores;
  std::vector<float> p(20000);
  std::string labels(p.size(), '0');
  for (std::size_t i{0}; i < p.size(); ++i) {
    p[i] = static_cast<float>(random() % 10000) / 10000;
    if (static_cast<float>(random() % 10000) / 10000 < p[i]) labels[i] = '1';
  }
  const Image<float> grid(lane_of(p));
  scores.add("a", grid.view(), lane_labels(labels));
  EXPECT_LT(scores.summary({0, 1e9}).calibration_error.value, 0.02);
}

TEST(Scores, NameTheWorstFrame) {
  Scores scores;
  const Image<float> good(lane_of({0.1F, 0.9F}));
  const Image<float> bad(lane_of({0.9F, 0.1F}));
  scores.add("good", good.view(), lane_labels("01"));
  scores.add("bad", bad.view(), lane_labels("01"));
  const auto losses(scores.frame_losses(everything));
  EXPECT_EQ(losses[1].name, "bad");
  EXPECT_NEAR(losses[0].balanced_log_loss, -std::log(0.9), 1e-6);
  EXPECT_NEAR(losses[1].balanced_log_loss, -std::log(0.1), 1e-6);
}

TEST(Scores, RefuseWhatDoesNotFit) {
  Scores scores;
  const Image<float> two(lane_of({0.1F, 0.9F}));
  EXPECT_THROW(scores.add("a", two.view(), lane_labels("010")), std::invalid_argument);
  scores.add("a", two.view(), lane_labels("01"));
  const Image<float> three(lane_of({0.1F, 0.9F, 0.1F}));
  EXPECT_THROW(scores.add("b", three.view(), lane_labels("010")), std::invalid_argument);
}

TEST(FreeSpace, EndsAtTheFirstOccupiedCell) {
  // 12 metre cells; truth and found at 8 m: an unknown cell ends nothing; everything before 3 m is left out
  const Image<float> grid(lane_of({0.9F, 0.9F, 0.9F, 0.1F, 0.1F, 0.1F, 0.5F, 0.1F, 0.9F, 0.1F, 0.1F, 0.1F}));
  const auto columns(free_space(grid.view(), lane_labels("1......01..."), 3));
  ASSERT_FALSE(columns.empty());
  const ColumnDepth middle{columns[columns.size() / 2]};
  EXPECT_EQ(middle.truth_m, 8);
  EXPECT_EQ(middle.found_m, 8);
  const Image<float> nearer(lane_of({0.9F, 0.9F, 0.9F, 0.1F, 0.1F, 0.1F, 0.51F, 0.1F, 0.9F, 0.1F, 0.1F, 0.1F}));
  const auto of_nearer(free_space(nearer.view(), lane_labels("1......01..."), 3));
  EXPECT_EQ(of_nearer[of_nearer.size() / 2].found_m, 6);
  // the cell of 1 m by 1 m at 8 m is 100·1/8 columns wide, to either side of the middle one
  EXPECT_EQ(columns.size(), 13U);
}

TEST(FreeSpace, ErrorsHaveSigns) {
  Scores scores;
  const Image<float> short_of(lane_of({0.1F, 0.1F, 0.1F, 0.9F, 0.1F, 0.1F, 0.1F, 0.1F}));
  const Image<float> beyond(lane_of({0.1F, 0.1F, 0.1F, 0.1F, 0.1F, 0.1F, 0.1F, 0.1F}));
  scores.add("short", short_of.view(), lane_labels(".....1.."));
  scores.add("beyond", beyond.view(), lane_labels(".....1.."));
  const auto errors(scores.depth_errors_m({5, 6}));
  EXPECT_THAT(errors, ::testing::Contains(-2.0F));
  EXPECT_THAT(errors, ::testing::Contains(3.0F));
  const Summary s(scores.summary(everything));
  EXPECT_NEAR(s.depth_error_m.value, 2.5, 1e-9);
  EXPECT_NEAR(s.depth_bias_m.value, 0.5, 1e-9);
  EXPECT_NEAR(s.depth_wrong.value, 1, 1e-9);  // beyond 10 % + 1 m = 1.5 m
  EXPECT_NEAR(s.depth_overshoot.value, 0.5, 1e-9);
  EXPECT_EQ(scores.summary({6, 7}).columns, 0U);
}

TEST(FreeSpace, FollowsObliqueRays) {
  // 10 × 10 m, half to either side; one occupied cell at x 6–7, y 2–3; wide enough for the columns around 60
  const GridGeometry grid{0, -5, 1, 10, 10};
  Labels labels{grid, small_rig(), {10, 10, not_scored}, {10, 10}};
  labels.cells(6, 7) = labelled_occupied;
  const Image<float> free_everywhere(10, 10, 0.1F);
  const auto columns(free_space(free_everywhere.view(), labels, 3));
  // rays with y/x from 2/7 to 3/6: u = 100 − 100·y/x from 50 to 71
  EXPECT_NEAR(static_cast<double>(columns.size()), 21, 1);
  for (const ColumnDepth& column : columns) {
    EXPECT_EQ(column.truth_m, 6);
    EXPECT_EQ(column.found_m, 10);
  }
}

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
