// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "batch/array_list.hpp"
#include "batch/plan.hpp"

namespace stereogrid::app::batch {

enum class Engine { local, parallel, slurm, kubernetes };

/// How a plan is handed to an engine.
struct EngineOptions {
  Engine engine{Engine::local};
  std::string plan;    ///< absolute
  std::string tool;    ///< the program, as the engine's machines know it
  std::string folder;  ///< absolute, where the files go
  std::uint64_t shards_per_task{1};
  int cpus{1};     ///< of a task, and threads of its pipeline
  int jobs{0};     ///< tasks at once; 0: as the engine likes
  int retries{5};  ///< of a task
  bool gpu{false};
  std::uint64_t memory_mb{0};
  std::uint64_t largest_array{1000};  ///< of Slurm: MaxArraySize
  std::string time_limit{};           ///< of Slurm; "": as the partition has it
  std::string partition{};
  std::string machines{};  ///< of GNU parallel: file for --sshloginfile; "": this machine
  std::string image{};     ///< of Kubernetes
  std::string claim{};     ///< of Kubernetes: name of the volume that holds the plan
};

struct EngineFile {
  std::string name;
  std::string text;
  bool is_program{false};
};

/// What an engine needs: files, and the command that starts it.
struct Submission {
  std::vector<EngineFile> files;
  std::vector<std::string> start;
};

/// `tasks`: those with something to do. Throws ConfigError: options that the engine lacks.
[[nodiscard]] Submission submission_of(const EngineOptions& options, const Plan& plan,
                                       const std::vector<NumberRange>& tasks);

/// A word for sh.
[[nodiscard]] std::string shell_quoted(const std::string& word);

}  // namespace stereogrid::app::batch
