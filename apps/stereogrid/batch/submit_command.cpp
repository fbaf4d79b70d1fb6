// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <filesystem>
#include <map>
#include <memory>
#include <system_error>

#include "batch/engines.hpp"
#include "batch/status.hpp"
#include "batch/subcommands.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "option_checks.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::app::batch {
namespace {

namespace fs = std::filesystem;

const std::map<std::string, Engine> engines{{"local", Engine::local},
                                            {"parallel", Engine::parallel},
                                            {"slurm", Engine::slurm},
                                            {"kubernetes", Engine::kubernetes}};

struct Options {
  std::string plan;
  std::string engine{"local"};
  bool go{false};
  EngineOptions engine_options;
};

/// Tasks that have a shard to do.
std::vector<NumberRange> tasks_of(const PlanReader& plan, std::uint64_t shards_per_task) {
  ArrayList tasks;
  const ShardStates states{plan.folder()};
  plan.for_each([&](const Shard& shard) {
    const ShardState state{states.of(shard.digest)};
    if (state == ShardState::done || state == ShardState::failed) return;
    const std::uint64_t task{shard.number / shards_per_task};
    if (tasks.ranges().empty() || tasks.ranges().back().last != task) tasks.add(task);
  });
  return tasks.ranges();
}

[[noreturn]] void start(const std::vector<std::string>& words) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  execvp(arguments.front(), arguments.data());
  throw DeviceError{fmt::format("{} cannot be started ({}). Is it installed?", words.front(),
                                std::generic_category().message(errno))};
}

int submit(Options options) {
  const PlanReader plan{options.plan};
  EngineOptions& engine{options.engine_options};
  engine.engine = engines.at(options.engine);
  engine.plan = fs::canonical(options.plan).string();
  engine.folder = engine.plan + "/submit-" + options.engine;
  if (engine.tool.empty()) {
    engine.tool = engine.engine == Engine::kubernetes ? "stereogrid" : fs::read_symlink("/proc/self/exe").string();
  }
  const bool on_gpu{plan.plan().run.value("device", "cpu") == "cuda"};
  if (engine.gpu && !on_gpu) {
    throw ConfigError{"--gpu: the plan is for the CPU. Make one with --device cuda: a GPU's results differ a little."};
  }
  engine.gpu = on_gpu;
  if (engine.memory_mb == 0) engine.memory_mb = plan.plan().memory_mb;
  const std::vector<NumberRange> tasks{tasks_of(plan, engine.shards_per_task)};
  const Submission submission{submission_of(engine, plan.plan(), tasks)};
  io::create_folder(engine.folder);
  for (const EngineFile& file : submission.files) {
    const fs::path path{fs::path{engine.folder} / file.name};
    io::write_file(path, file.text);
    if (file.is_program) fs::permissions(path, fs::perms{0755});
  }
  std::string command;
  for (const std::string& word : submission.start) command += (command.empty() ? "" : " ") + shell_quoted(word);
  tell("{}\n", command);
  static_cast<void>(lost_output());  // hands it on
  if (options.go) start(submission.start);
  return exit_done;
}

void add_engine_options(CLI::App& command, EngineOptions& options) {
  command
      .add_option("--shards-per-task", options.shards_per_task, "Several small shards for each start of the program.")
      ->type_name("N")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  command.add_option("--cpus", options.cpus, "Cores, and threads, of a task.")
      ->type_name("N")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  command.add_option("--memory-mb", options.memory_mb, "Memory of a task; left out: as the plan estimates.")
      ->type_name("MB")
      ->check(CLI::Range(1, 100'000'000));
  command.add_option("--jobs", options.jobs, "Tasks at once.")->type_name("N")->check(CLI::Range(1, 1'000'000));
  command.add_option("--retries", options.retries, "How often a task may be tried again.")
      ->type_name("N")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  command.add_flag("--gpu", options.gpu, "A GPU for each task; a plan of --device cuda asks for it by itself.");
  command.add_option("--tool", options.tool, "The program where tasks run; left out: this one.")->type_name("FILE");
  command.add_option("--largest-array", options.largest_array, "Slurm: its MaxArraySize.")
      ->type_name("N")
      ->check(CLI::Range(1, 10'000'000))
      ->capture_default_str();
  command.add_option("--time", options.time_limit, "Slurm: a task's time.")->type_name("HH:MM:SS");
  command.add_option("--partition", options.partition, "Slurm: where.")->type_name("NAME");
  command.add_option("--machines", options.machines, "GNU parallel: its --sshloginfile.")->type_name("FILE");
  command.add_option("--image", options.image, "Kubernetes: a container with stereogrid in it.")->type_name("IMAGE");
  command.add_option("--claim", options.claim, "Kubernetes: the claim of the volume that the plan lies in.")
      ->type_name("NAME");
}

}  // namespace

void add_submit_command(CLI::App& batch, int& exit_code) {
  auto options{std::make_shared<Options>()};
  CLI::App* command{batch.add_subcommand("submit", "Write what an engine needs to work on a plan, and start it.")};
  add_plan_argument(*command, options->plan);
  command->add_option("--engine", options->engine, "Who starts the tasks.")
      ->check(CLI::IsMember({"local", "parallel", "slurm", "kubernetes"}))
      ->capture_default_str();
  command->add_flag("--go", options->go, "Start it, too.");
  add_engine_options(*command, options->engine_options);
  command->callback([options, &exit_code] { exit_code = submit(*options); });
}

}  // namespace stereogrid::app::batch
