// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "batch/array_list.hpp"
#include "batch/plan.hpp"
#include "batch/results.hpp"

namespace stereogrid::app::batch {

enum class ShardState { missing, stopped, running, failed, done };

/// What of a plan is done, by the names in its folders: eight bytes for each, whatever the plan's size.
class ShardStates {
 public:
  explicit ShardStates(const std::filesystem::path& plan);

  [[nodiscard]] ShardState of(const std::string& digest) const;
  /// Whether the shard's result may lack frames.
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
  std::uint64_t stopped{0};  ///< begun, and nobody works on it
  std::uint64_t missing{0};  ///< not begun
  std::uint64_t failed{0};
  std::uint64_t poison{0};  ///< of the failed ones: not because of a crash, but of bad input or wrong usage
  std::uint64_t frames{0};
  std::uint64_t frames_done{0};
  std::uint64_t frames_skipped{0};  ///< of shards that are done: frames that could not be used
  double cost_left{0};              ///< of all but what is done and failed
  double frames_per_second{0};      ///< of one runner; of results looked at, at most a few hundred; 0: none
  double seconds_left{0};           ///< with as many runners as now; 0: not known
  ArrayList to_do{};                ///< missing and stopped
  std::vector<Failure> failures{};  ///< the first hundred
};

/// Throws InputError: the plan is damaged.
[[nodiscard]] Status status_of(const PlanReader& plan);

[[nodiscard]] Json to_json(const Status& status);

}  // namespace stereogrid::app::batch
