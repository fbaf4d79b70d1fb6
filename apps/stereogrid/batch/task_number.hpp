// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>

#include "batch/array_list.hpp"

namespace stereogrid::app::batch {

/// The task's number, from 0, as an engine says it in the environment (SLURM_ARRAY_TASK_ID, JOB_COMPLETION_INDEX,
/// AWS_BATCH_JOB_ARRAY_INDEX, or PARALLEL_SEQ, which counts from 1), plus STEREOGRID_FIRST_TASK. `value_of`: of a
/// variable, nullptr: not set. Throws ConfigError: none is set, several are, no number.
[[nodiscard]] std::uint64_t task_number(const std::function<const char*(const char* name)>& value_of);

/// Throws ConfigError: the plan has fewer.
[[nodiscard]] NumberRange shards_of_task(std::uint64_t task, std::uint64_t shards_per_task, std::uint64_t shards);

}  // namespace stereogrid::app::batch
