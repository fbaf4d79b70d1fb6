// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "accuracy/truth_points.hpp"

namespace stereogrid::bench {

using Count = std::int64_t;

/// 0 where there is nothing to share out.
inline double share(Count part, Count whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

/// Errors of the disparities of a set of truth points.
class DisparityTally {
 public:
  /// `disparity`: the matcher's, 0 = none.
  void add(float disparity, float truth);
  DisparityTally& operator+=(const DisparityTally& other);

  [[nodiscard]] Count points() const { return points_; }
  [[nodiscard]] double density() const { return share(matched_, points_); }
  [[nodiscard]] double wrong_by_3_of_matched() const { return share(wrong_by_3_, matched_); }
  [[nodiscard]] double wrong_by_1_of_matched() const { return share(wrong_by_1_, matched_); }
  [[nodiscard]] double wrong_by_3_of_all() const { return share(wrong_by_3_, points_); }
  [[nodiscard]] double wrong_by_1_of_all() const { return share(wrong_by_1_, points_); }
  /// Median absolute error of matched points, px, to 0.01 px; 10: larger.
  [[nodiscard]] double median_error_px() const;

 private:
  static constexpr int bins_per_px{100};

  Count points_{0};
  Count matched_{0};
  Count wrong_by_3_{0};
  Count wrong_by_1_{0};
  std::array<Count, 10 * bins_per_px + 1> errors_{};
};

/// Errors of the labels road and obstacle.
struct LabelTally {
  Count points{0};        ///< points with truth
  Count matched{0};       ///< with a label
  Count right{0};         ///< with that label
  Count matched_away{0};  ///< the same further than contact_px from the boundary of the two
  Count right_away{0};
  Count points_away{0};

  void add(Surface label, const TruthPoint& point);
  LabelTally& operator+=(const LabelTally& other);
  [[nodiscard]] double accuracy() const { return share(right, matched); }
  [[nodiscard]] double accuracy_away() const { return share(right_away, matched_away); }
  /// Points with the other label, of all points of truth, matched or not.
  [[nodiscard]] double mistaken() const { return share(matched - right, points); }
  [[nodiscard]] double mistaken_away() const { return share(matched_away - right_away, points_away); }
};

/// Calibration of confidences: a confidence of 0.9 should be right nine times of ten. Ten bins of confidence; the last
/// one includes 1.
class Reliability {
 public:
  static constexpr int bins{10};
  struct Bin {
    Count points{0};
    Count right{0};
    double confidence_sum{0};
    [[nodiscard]] double mean_confidence() const {
      return points == 0 ? 0 : confidence_sum / static_cast<double>(points);
    }
    [[nodiscard]] double right_share() const { return share(right, points); }
  };

  /// `confidence` is clamped to [0, 1]; not a number counts as 0.
  void add(float confidence, bool is_right);
  Reliability& operator+=(const Reliability& other);
  [[nodiscard]] Count points() const;
  [[nodiscard]] const std::array<Bin, bins>& table() const { return table_; }
  /// Mean over the points of |mean confidence − share right| of their bin.
  [[nodiscard]] double expected_calibration_error() const;

 private:
  std::array<Bin, bins> table_{};
};

/// Event that a confidence predicts: the disparity is right to a pixel.
bool is_right(float disparity, float truth);

/// Everything measured about one matcher on one set.
struct MatcherTally {
  DisparityTally road, obstacle, all;
  LabelTally road_label, obstacle_label;
  Reliability reliability;

  MatcherTally& operator+=(const MatcherTally& other);
};

}  // namespace stereogrid::bench
