// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "stereogrid/export.hpp"

namespace stereogrid::evaluation {

/// True objects and found obstacles of a frame, by their ids.
struct TrackingFrame {
  static constexpr double no_match{std::numeric_limits<double>::infinity()};
  struct Hypothesis {
    std::int64_t id{0};
    bool ignored{false};  ///< not counted if unmatched, as its truth is unknown
  };
  std::vector<std::int64_t> objects;
  std::vector<Hypothesis> hypotheses;
  std::vector<double> distances;  ///< [object][hypothesis]; no_match: they cannot belong together
};

/// CLEAR MOT (Bernardin and Stiefelhagen 2008), identity scores (Ristani and others 2016), and what MOTChallenge counts
/// besides. NaN: nothing to say it of.
struct TrackingSummary {
  static constexpr double nothing{std::numeric_limits<double>::quiet_NaN()};
  std::size_t tracks{0};   ///< true objects
  std::size_t objects{0};  ///< × frames
  std::size_t matches{0};
  std::size_t misses{0};
  std::size_t false_positives{0};
  std::size_t id_switches{0};
  std::size_t fragmentations{0};  ///< matched, missed, matched again
  std::size_t mostly_tracked{0};  ///< tracks matched in 80 % of their frames or more
  std::size_t mostly_lost{0};     ///< in less than 20 %
  double mota{nothing};
  double motp{nothing};  ///< mean distance of the matches
  std::size_t id_true_positives{0};
  std::size_t id_false_positives{0};
  std::size_t id_misses{0};
  double idf1{nothing};
  double id_precision{nothing};
  double id_recall{nothing};
};

/// Follows objects and hypotheses over the frames of a drive.
class STEREOGRID_EXPORT TrackingScores {
 public:
  struct Match {
    std::size_t object{0};  ///< place in the frame
    std::size_t hypothesis{0};
  };
  /// Frames in their order. An object keeps the hypothesis that it had where the two may still match; of the others as
  /// many are matched as can be, with the least sum of distances.
  std::vector<Match> add(const TrackingFrame& frame);
  [[nodiscard]] TrackingSummary summary() const;

 private:
  struct Track {
    std::size_t frames{0};
    std::size_t matched{0};
    std::size_t fragmentations{0};
    std::optional<std::int64_t> hypothesis;  // the last one
    bool missed{false};                      // since then
  };
  [[nodiscard]] std::vector<Match> match(const TrackingFrame& frame) const;
  void follow(const TrackingFrame& frame, const std::vector<Match>& matches);
  void count_identities(const TrackingFrame& frame, const std::vector<bool>& counted);
  void add_identities(TrackingSummary& summary) const;

  std::map<std::int64_t, Track> tracks_;
  std::map<std::pair<std::int64_t, std::int64_t>, std::size_t> together_;  // object and hypothesis: frames
  std::size_t hypotheses_{0};                                              // × frames, that count
  std::size_t false_positives_{0};
  std::size_t id_switches_{0};
  double distance_sum_{0};
};

}  // namespace stereogrid::evaluation
