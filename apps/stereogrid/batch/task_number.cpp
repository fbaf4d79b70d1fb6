// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/task_number.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <string>
#include <string_view>

#include "stereogrid/error.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::app::batch {
namespace {

struct Variable {
  const char* name;
  std::uint64_t first;
};
constexpr Variable variables[]{
    {"SLURM_ARRAY_TASK_ID", 0}, {"JOB_COMPLETION_INDEX", 0}, {"AWS_BATCH_JOB_ARRAY_INDEX", 0}, {"PARALLEL_SEQ", 1}};

std::uint64_t number_in(const char* name, std::string_view text) {
  std::uint64_t number{0};
  const auto [end, error]{std::from_chars(text.data(), text.data() + text.size(), number)};
  if (error == std::errc{} && end == text.data() + text.size() && number < 1'000'000'000'000) return number;
  throw ConfigError{fmt::format("{}={}: this is no number of a task. Give --shard.", name, io::printable(text))};
}

}  // namespace

std::uint64_t task_number(const std::function<const char*(const char*)>& value_of) {
  const Variable* found{nullptr};
  for (const Variable& variable : variables) {
    if (value_of(variable.name) == nullptr) continue;
    if (found != nullptr) {
      throw ConfigError{fmt::format("{} and {} are both set. Which shard? Give --shard.", found->name, variable.name)};
    }
    found = &variable;
  }
  if (found == nullptr) {
    throw ConfigError{
        "Which shard? Give --shard K, or run it by an engine that sets SLURM_ARRAY_TASK_ID, JOB_COMPLETION_INDEX, "
        "AWS_BATCH_JOB_ARRAY_INDEX or PARALLEL_SEQ."};
  }
  const std::uint64_t number{number_in(found->name, value_of(found->name))};
  if (number < found->first) throw ConfigError{fmt::format("{}=0: it counts from 1.", found->name)};
  const char* const more{value_of("STEREOGRID_FIRST_TASK")};
  return number - found->first + (more == nullptr ? 0 : number_in("STEREOGRID_FIRST_TASK", more));
}

NumberRange shards_of_task(std::uint64_t task, std::uint64_t shards_per_task, std::uint64_t shards) {
  if (task >= (shards + shards_per_task - 1) / shards_per_task) {
    throw ConfigError{
        fmt::format("task {}: the plan has {} shards, of which a task takes {}.", task, shards, shards_per_task)};
  }
  return {task * shards_per_task, std::min((task + 1) * shards_per_task, shards) - 1};
}

}  // namespace stereogrid::app::batch
