// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "batch/plan.hpp"
#include "batch/results.hpp"

namespace stereogrid::app::batch {

enum class ShardState { missing, stopped, running, failed, done };

/// States of shards, from the names in the plan's folders: eight bytes for each. `running`: a runner holds the lock of
/// its work folder; on file systems without locks such a shard counts as `stopped`.
class ShardStates {
 public:
  explicit ShardStates(const std::filesystem::path& plan);

  [[nodiscard]] ShardState of(const std::string& digest) const;
  /// Returns whether the shard's result may lack frames.
  [[nodiscard]] bool has_skipped(const std::string& digest) const;

 private:
  std::vector<std::uint64_t> done_;
  std::vector<std::uint64_t> failed_;
  std::vector<std::uint64_t> running_;
  std::vector<std::uint64_t> stopped_;
  std::vector<std::uint64_t> skipped_;
};

/// Counts for `stereogrid batch status`.
struct Status {
  std::uint64_t shards{0};
  std::uint64_t done{0};
  std::uint64_t running{0};
  std::uint64_t stopped{0};  ///< begun, without a runner now
  std::uint64_t missing{0};  ///< not begun
  std::uint64_t failed{0};   ///< recorded as impossible: bad input or wrong usage
  std::uint64_t frames{0};
  std::uint64_t frames_done{0};
  std::uint64_t frames_skipped{0};     ///< unusable frames of completed shards
  double cost_left{0};                 ///< cost of all shards but those done and failed
  double frames_per_second{0};         ///< mean of one runner, from a few hundred results; 0: none
  double seconds_left{0};              ///< with as many runners as now; 0: unknown
  std::vector<std::uint64_t> to_do{};  ///< missing and stopped
  std::vector<Failure> failures{};     ///< the first hundred
};

/// Throws InputError: the plan is damaged.
[[nodiscard]] Status status_of(const PlanReader& plan);

[[nodiscard]] Json to_json(const Status& status);

}  // namespace stereogrid::app::batch
