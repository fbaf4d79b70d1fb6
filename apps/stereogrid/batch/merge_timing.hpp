// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "batch/plan.hpp"

namespace stereogrid::app::batch {

/// What the results of a plan have taken: timing.json of a merged folder, the only file there that depends on who made
/// the results.
class MergedTiming {
 public:
  /// `timing`: a result's timing.json.
  void add(const Shard& shard, const Json& timing);
  [[nodiscard]] Json summary(const Plan& plan) const;

 private:
  struct Sums {
    std::uint64_t shards{0};
    double frames{0};
    double seconds{0};
    std::map<std::string, double> stage_ms;  ///< times frames
  };
  [[nodiscard]] static Json json_of(const Sums& sums);
  static void add(const Json& timing, Sums& sums);

  std::map<std::size_t, Sums> variants_;
  std::map<std::string, Sums> hosts_;
};

}  // namespace stereogrid::app::batch
