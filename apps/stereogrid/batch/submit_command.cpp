// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cctype>
#include <cerrno>
#include <filesystem>
#include <map>
#include <memory>
#include <regex>
#include <system_error>

#include "batch/sha256.hpp"
#include "batch/status.hpp"
#include "batch/subcommands.hpp"
#include "cli/commands.hpp"
#include "cli/console.hpp"
#include "connect/assets.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/json_text.hpp"

namespace stereogrid::app::batch {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string plan;
  std::string engine{"local"};
  std::uint64_t shards_per_task{1};
  int cpus{1};
  int jobs{0};
  int retries{5};
  std::uint64_t memory_mb{0};
  std::string tool;
  std::string image;
  std::string claim;
  bool go{false};
};

/// The template of an engine, named ENGINE.sh or the like.
struct Template {
  std::string file;
  std::string text;
};

/// Templates by engine.
std::map<std::string, Template> templates() {
  std::map<std::string, Template> found;
  for (const server::Asset& asset : engine_templates()) {
    const fs::path file{fs::path{asset.path}.filename()};
    found[file.stem().string()] = {file.string(), asset.bytes};
  }
  return found;
}

/// A word for sh.
std::string shell_quoted(const std::string& word) {
  std::string quoted{"'"};
  for (const char c : word) quoted += c == '\'' ? "'\\''" : std::string(1, c);
  return quoted + "'";
}

/// A string for the language of a template. Those of JSON are strings of YAML and Python, too.
std::string quoted_for(const std::string& file, const std::string& text) {
  return file.ends_with(".sh") ? shell_quoted(text) : io::json_text(Json(text));
}

/// Replaces @NAME@, and @NAME:DEFAULT@ by DEFAULT where the value is empty. Throws ConfigError: a value is missing.
std::string filled_in(const Template& from, const std::map<std::string, std::string>& values) {
  static const std::regex placeholder{"@([A-Z_]+)(:([^@\n]*))?@"};
  std::string filled;
  auto rest{from.text.cbegin()};
  for (std::sregex_iterator at{from.text.cbegin(), from.text.cend(), placeholder}; at != std::sregex_iterator{}; ++at) {
    filled.append(rest, (*at)[0].first);
    rest = (*at)[0].second;
    const std::string name{(*at)[1]};
    if (const std::string & value{values.at(name)}; !value.empty() || (*at)[2].matched) {
      filled += value.empty() ? (*at)[3].str() : value;
      continue;
    }
    std::string option;
    for (const char c : name) option += c == '_' ? '-' : static_cast<char>(std::tolower(c));
    throw ConfigError{fmt::format("{}: @{}@ has no value. Give --{}.", from.file, name, option)};
  }
  return filled.append(rest, from.text.cend());
}

/// A line per task: numbers of shards that are neither done nor failed.
std::vector<std::string> tasks_of(const PlanReader& plan, std::uint64_t shards_per_task) {
  std::vector<std::string> tasks;
  std::vector<std::uint64_t> task;
  const auto end_task = [&] {
    if (!task.empty()) tasks.push_back(text_of(task));
    task.clear();
  };
  const ShardStates states{plan.folder()};
  plan.for_each([&](const Shard& shard) {
    const ShardState state{states.of(shard.digest)};
    if (state == ShardState::done || state == ShardState::failed) return;
    if (task.size() >= shards_per_task) end_task();
    task.push_back(shard.number);
  });
  end_task();
  if (tasks.empty()) throw ConfigError{"There is nothing to do: every shard is done or cannot be done."};
  return tasks;
}

std::map<std::string, std::string> values_of(const Options& options, const Plan& plan, const std::string& file) {
  const auto given = [](auto number) { return number > 0 ? std::to_string(number) : ""; };
  const auto quoted = [&](const std::string& text) { return text.empty() ? "" : quoted_for(file, text); };
  const bool on_gpu{plan.run.value("device", "cpu") == "cuda"};
  return {{"TOOL", quoted(options.tool)},
          {"CPUS", given(options.cpus)},
          {"MEMORY_MB", given(options.memory_mb > 0 ? options.memory_mb : plan.memory_mb)},
          {"GPUS", on_gpu ? "1" : "0"},
          {"JOBS", given(options.jobs)},
          {"RETRIES", std::to_string(options.retries)},
          {"IMAGE", quoted(options.image)},
          {"CLAIM", quoted(options.claim)}};
}

/// The command after "# Start: " in a file.
std::string start_of(const std::string& text) {
  constexpr std::string_view mark{"# Start: "};
  const std::size_t begin{text.find(mark) + mark.size()};
  return text.substr(begin, text.find('\n', begin) - begin);
}

[[noreturn]] void start(const std::string& command) {
  execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
  throw DeviceError{fmt::format("/bin/sh: not started ({}).", std::generic_category().message(errno))};
}

int submit(Options options) {
  const PlanReader plan{options.plan};
  const Template from{templates().at(options.engine)};
  const std::string folder{fs::canonical(options.plan).string()};
  const std::string out{folder + "/submit-" + options.engine};
  if (options.tool.empty()) {
    // a container has its own
    options.tool = options.image.empty() ? fs::read_symlink("/proc/self/exe").string() : "stereogrid";
  }
  const std::vector<std::string> tasks{tasks_of(plan, options.shards_per_task)};
  const std::string lines{fmt::format("{}\n", fmt::join(tasks, "\n"))};
  std::map<std::string, std::string> values{values_of(options, plan.plan(), from.file)};
  // tasks that an engine still has queued keep their file
  values["ID"] = sha256_of(lines).substr(0, 10);
  values["COUNT"] = std::to_string(tasks.size());
  values["PLAN"] = quoted_for(from.file, folder);
  values["FOLDER"] = quoted_for(from.file, out);
  values["FILE"] = shell_quoted(out + "/" + from.file);
  const std::string text{filled_in(from, values)};
  io::create_folder(out);
  io::write_file(out + "/tasks-" + values["ID"] + ".txt", lines);
  io::write_file(out + "/" + from.file, text);
  tell("{}\n", start_of(text));
  flush_output();
  if (options.go) start(start_of(text));
  return exit_done;
}

void add_task_options(CLI::App& command, Options& options) {
  command
      .add_option("--shards-per-task", options.shards_per_task, "Several small shards for each start of the program.")
      ->type_name("N")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  command.add_option("--cpus", options.cpus, "Cores, and threads, of a task.")
      ->type_name("N")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  command.add_option("--memory-mb", options.memory_mb, "Memory of a task. Default: the plan's estimate.")
      ->type_name("MB")
      ->check(CLI::Range(1, 100'000'000));
  command.add_option("--jobs", options.jobs, "Tasks at once.")->type_name("N")->check(CLI::Range(1, 1'000'000));
  command.add_option("--retries", options.retries, "Number of retries of a task.")
      ->type_name("N")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  command.add_option("--tool", options.tool, "Path of the program on the machines of the tasks. Default: this one.")
      ->type_name("FILE");
  command.add_option("--image", options.image, "Kubernetes: a container image with stereogrid.")->type_name("IMAGE");
  command.add_option("--claim", options.claim, "Kubernetes: the claim of the volume that holds the plan.")
      ->type_name("NAME");
}

}  // namespace

void add_submit_command(CLI::App& batch, int& exit_code) {
  auto options{std::make_shared<Options>()};
  std::vector<std::string> engines;
  for (const auto& [engine, unused] : templates()) engines.push_back(engine);
  CLI::App* command{batch.add_subcommand("submit", "Fill in the template of an engine for a plan, and start it.")};
  add_plan_argument(*command, options->plan);
  command->add_option("--engine", options->engine, "Scheduler of the tasks.")
      ->check(CLI::IsMember(engines))
      ->capture_default_str();
  command->add_flag("--go", options->go, "Start the engine, too.");
  add_task_options(*command, *options);
  command->callback([options, &exit_code] { exit_code = submit(*options); });
}

}  // namespace stereogrid::app::batch
