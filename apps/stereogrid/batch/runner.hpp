// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "batch/plan.hpp"

namespace stereogrid::app::batch {

class Transfer;

struct RunnerOptions {
  int threads{1};
  int input_wait_s{300};
  int attempts{5};  ///< runners in a row that may end without a word and without having finished a frame
  bool retry_poison{false};
  Transfer* transfer{nullptr};  ///< none: inputs are where the plan says, and results stay here
};

/// Works on one shard, whatever others have done or are doing of it. What is left in the plan's folder is a whole
/// result, a record of why there can be none, or what the next runner goes on from. Returns the exit code: 0, 64 and 65
/// (cannot be done: recorded), 70 (a bug), 75 (try again). Throws InputError: the plan is damaged.
[[nodiscard]] int run_shard(const PlanReader& plan, std::uint64_t number, const RunnerOptions& options);

}  // namespace stereogrid::app::batch
