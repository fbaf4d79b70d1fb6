// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "stereogrid/evaluation/labels.hpp"
#include "stereogrid/export.hpp"

namespace stereogrid::evaluation {

/// Cells whose centres are from_m ≤ x < to_m ahead.
struct Band {
  double from_m{0};
  double to_m{0};
  bool clear{false};  ///< without Labels::hidden_ground
};
inline constexpr std::array<Band, 5> bands{{{3, 10}, {10, 20}, {20, 30}, {3, 20}, {3, 20, true}}};

/// A figure with its 95 % interval. NaN: nothing to say it of, or too few frames for an interval.
struct Estimate {
  double value{std::numeric_limits<double>::quiet_NaN()};
  double low{std::numeric_limits<double>::quiet_NaN()};
  double high{std::numeric_limits<double>::quiet_NaN()};
};

struct ReliabilityBin {
  std::size_t cells{0};
  double mean_probability{0};
  double share_occupied{0};
};
inline constexpr std::size_t reliability_bins{15};

/// Figures defined in docs/evaluation.md, over all frames of a series in one band. p is clipped to [0.001, 0.999].
struct Summary {
  std::size_t frames{0};  ///< with cells in the band
  std::size_t cells{0};
  std::size_t occupied{0};
  std::size_t hidden_occupied{0};  ///< partly hidden ones among them
  std::size_t hidden_free{0};
  std::size_t columns{0};  ///< image columns whose truth ends in the band

  Estimate balanced_log_loss;
  Estimate brier;
  Estimate auc;
  Estimate iou_occupied;  ///< p > 0.55
  Estimate iou_free;      ///< p < 0.45
  Estimate missed;        ///< share of the occupied cells with p < 0.45
  Estimate false_alarms;  ///< share of the free cells with p > 0.55
  Estimate known;         ///< share with |p − 0.5| > 0.05
  Estimate calibration_error;

  // Partly hidden cells.
  Estimate hidden_recall;         ///< at 1 % false alarms among all free cells of the band
  Estimate hidden_recall_strict;  ///< at 1 % false alarms among the partly hidden free cells
  Estimate hidden_recall_clear;   ///< at 1 % false alarms among the free cells that touch no occupied one
  Estimate hidden_missed;
  Estimate hidden_auc;  ///< against the partly hidden free cells

  // Free space along the image columns, found minus true.
  Estimate depth_error_m;         ///< mean |e|
  Estimate depth_error_median_m;  ///< median |e|
  Estimate depth_bias_m;          ///< mean e; positive: free space reaches too far
  Estimate depth_wrong;           ///< share with |e| > 10 % + 1 m
  Estimate depth_overshoot;       ///< share with e > 10 % + 1 m: dangerous

  std::array<ReliabilityBin, reliability_bins> reliability{};
};

enum class Better { lower, higher, zero };

/// One figure of a Summary, for tables and files.
struct Metric {
  std::string_view name;   ///< the member's
  std::string_view title;  ///< for people
  Estimate Summary::*estimate;
  Better better;
};
inline constexpr std::array<Metric, 19> metrics{{
    {"balanced_log_loss", "log-loss", &Summary::balanced_log_loss, Better::lower},
    {"auc", "AUC", &Summary::auc, Better::higher},
    {"brier", "Brier", &Summary::brier, Better::lower},
    {"iou_occupied", "IoU occupied", &Summary::iou_occupied, Better::higher},
    {"iou_free", "IoU free", &Summary::iou_free, Better::higher},
    {"missed", "missed", &Summary::missed, Better::lower},
    {"false_alarms", "false alarms", &Summary::false_alarms, Better::lower},
    {"known", "known", &Summary::known, Better::higher},
    {"calibration_error", "calibration error", &Summary::calibration_error, Better::lower},
    {"hidden_recall", "hidden: recall", &Summary::hidden_recall, Better::higher},
    {"hidden_recall_strict", "hidden: recall, strict", &Summary::hidden_recall_strict, Better::higher},
    {"hidden_recall_clear", "hidden: recall, clear", &Summary::hidden_recall_clear, Better::higher},
    {"hidden_missed", "hidden: missed", &Summary::hidden_missed, Better::lower},
    {"hidden_auc", "hidden: AUC", &Summary::hidden_auc, Better::higher},
    {"depth_error_m", "depth error, m", &Summary::depth_error_m, Better::lower},
    {"depth_error_median_m", "depth error, median, m", &Summary::depth_error_median_m, Better::lower},
    {"depth_bias_m", "depth bias, m", &Summary::depth_bias_m, Better::zero},
    {"depth_wrong", "depth wrong", &Summary::depth_wrong, Better::lower},
    {"depth_overshoot", "depth overshoot", &Summary::depth_overshoot, Better::lower},
}};

/// A point of a receiver operating characteristic.
struct RocPoint {
  double false_alarms{0};
  double recall{0};
};

/// Free space along one image column.
struct ColumnDepth {
  float truth_m{0};  ///< near edge of the first cell along the ray that is labelled occupied
  float found_m{0};  ///< first cell with p ≥ 0.5; the grid's end if there is none
};

/// Free space of one frame along every image column in which the truth has an occupied cell, from `from_m` ahead on.
[[nodiscard]] STEREOGRID_EXPORT std::vector<ColumnDepth> free_space(View<const float> probability, const Labels& labels,
                                                                    double from_m = 3);

/// Scores one series of grids, such as the observed grids of a run or what a baseline makes of the same drive.
class STEREOGRID_EXPORT Scores {
 public:
  /// Takes a frame. `probability`: P(occupied) on labels.geometry, 0.5 = unknown. Throws std::invalid_argument: sizes
  /// differ, or the geometry is not that of the frames before.
  void add(std::string frame_name, View<const float> probability, const Labels& labels);

  [[nodiscard]] std::size_t frames() const { return frames_.size(); }
  /// True if the labels say which free cells the camera cannot see. Clear bands require it.
  [[nodiscard]] bool has_hidden_ground() const { return has_hidden_ground_; }
  /// Everything about a band. Intervals are found by resampling blocks of neighbouring frames with a fixed seed;
  /// `resamples` 0: no intervals.
  [[nodiscard]] Summary summary(Band band, int resamples = 1000) const;

  enum class Positives { all, partly_hidden };
  /// Recall against false alarms among all free cells of the band, from (0, 0) to (1, 1), at most about 500 points.
  [[nodiscard]] std::vector<RocPoint> roc(Band band, Positives positives = Positives::all) const;

  struct FrameLoss {
    std::string name;
    double balanced_log_loss{0};  ///< NaN where there is no occupied or no free cell
  };
  [[nodiscard]] std::vector<FrameLoss> frame_losses(Band band) const;

  /// Signed errors (m) of free space, found minus true, over all frames, for columns whose truth ends in the band.
  [[nodiscard]] std::vector<float> depth_errors_m(Band band) const;

  /// A cell with a label, as it is kept.
  struct Cell {
    float probability{0};
    std::uint16_t ix{0};
    bool occupied{false};
    bool partly_hidden{false};
    bool is_border{false};  ///< free, and one of the eight cells around it is labelled occupied
    bool is_hidden_ground{false};
  };

 private:
  struct Frame {
    std::string name;
    std::vector<Cell> cells;
    std::vector<ColumnDepth> columns;
  };
  [[nodiscard]] bool contains(Band band, const Cell& cell) const;

  GridGeometry geometry_;
  bool has_hidden_ground_{false};
  std::vector<Frame> frames_;
};

}  // namespace stereogrid::evaluation
