// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "accuracy/matchers.hpp"
#include "accuracy/sets.hpp"
#include "accuracy/tally.hpp"

namespace stereogrid::bench {

/// Raw observations, a row for each point of truth that a matcher matched; a column per quantity.
class Samples {
 public:
  using Row = std::vector<std::pair<std::string, double>>;

  /// Every row has the same columns in the same order.
  void add(const Row& row);
  /// As .npz of float32 arrays of equal length. Throws DeviceError.
  void write(const std::filesystem::path& path) const;

 private:
  std::vector<std::string> names_;
  std::vector<std::vector<float>> columns_;
};

/// The two of a comparison on the points that both matched.
struct CommonTally {
  Count points{0};  ///< points with truth
  DisparityTally ours, theirs;
  CommonTally& operator+=(const CommonTally& other);
};

struct MatcherResult {
  std::string name;
  std::string peer;
  MatcherTally tally;
  CommonTally road, obstacle, all;  ///< with the peer
};

/// One set, or the sum of several.
struct SetResult {
  std::string name;
  std::size_t frames{0};
  Count points{0};
  std::vector<MatcherResult> matchers;
  SetResult& operator+=(const SetResult& other);
};

struct MeasureOptions {
  int every{1};      ///< interval of the frames with truth
  std::string only;  ///< matchers whose name holds this, and their peers
  Config config;     ///< configuration of our matchers
  Samples* samples{nullptr};
  int set_number{0};  ///< column "set" of the samples
};

/// Progress goes to stderr.
SetResult measure(const TruthSet& set, const MeasureOptions& options);

}  // namespace stereogrid::bench
