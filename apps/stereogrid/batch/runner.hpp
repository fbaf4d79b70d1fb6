// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "batch/inputs.hpp"
#include "batch/plan.hpp"
#include "run/run.hpp"

namespace stereogrid::app::batch {

/// For Plan::run: the options that decide about results and are the same for all shards.
[[nodiscard]] Json to_json(const RunOptions& options, bool evaluate);
/// Reads Plan::run, for a shard that is processed in a folder.
[[nodiscard]] RunOptions run_options(const Plan& plan, const Shard& shard, const std::filesystem::path& folder);
/// Returns whether results are scored where there is truth.
[[nodiscard]] bool is_evaluated(const Plan& plan);

/// Digest of an input and of all files that the options name. Throws InputError.
[[nodiscard]] std::string digest_of_input(const InputOptions& input, DigestOf what);

/// The input of a shard, compared with the digest that the plan has of it.
class PlannedInput {
 public:
  /// The arguments have to live longer.
  PlannedInput(const PlanReader& plan, const Shard& shard) : plan_{plan}, shard_{shard} {}

  /// The first path that does not exist, or is an empty folder such as an unused mount point; "": none.
  [[nodiscard]] std::string missing() const;
  /// Whether names, sizes and contents are those of the plan. Throws DeviceError: a file cannot be read.
  [[nodiscard]] bool is_as_planned() const;
  /// The same, and false for an input that is missing or cannot be read.
  [[nodiscard]] bool is_there() const;

 private:
  const PlanReader& plan_;
  const Shard& shard_;
};

struct RunnerOptions {
  int threads{1};
  int input_wait_s{300};
  bool retry_poison{false};
  bool report{true};  ///< prints a line for each result
};

/// Processes one shard, independently of other runners. Leaves a whole result, a record of why there can be none, or a
/// checkpoint for the next runner. Returns the exit code: 0, 64 and 65 (recorded as impossible), 70 (a bug), 75 (try
/// again). Throws InputError: the plan is damaged.
[[nodiscard]] int run_shard(const PlanReader& plan, std::uint64_t number, const RunnerOptions& options);

}  // namespace stereogrid::app::batch
