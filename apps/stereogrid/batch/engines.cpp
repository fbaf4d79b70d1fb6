// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/engines.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <thread>

#include "batch/sha256.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid::app::batch {
namespace {

constexpr const char* spdx{
    "# Made by stereogrid batch submit.\n"
    "# Exit codes: 0 done, 64 and 65 cannot be done (recorded, not tried again), 70 a bug, 75 try again.\n"};

std::string run_words(const EngineOptions& options, const std::string& what) {
  return fmt::format("{} -q batch run {} {} --threads {}", shell_quoted(options.tool), shell_quoted(options.plan), what,
                     options.cpus);
}

std::string per_task(const EngineOptions& options) {
  return fmt::format("--shards-per-task {}", options.shards_per_task);
}

std::uint64_t count(const std::vector<NumberRange>& tasks) {
  std::uint64_t number{0};
  for (const NumberRange& range : tasks) number += range.last - range.first + 1;
  return number;
}

/// A line per task, its number.
EngineFile task_file(const std::vector<NumberRange>& tasks) {
  EngineFile file{"tasks.txt", ""};
  for (const NumberRange& range : tasks) {
    for (std::uint64_t task{range.first}; task <= range.last; ++task) file.text += fmt::format("{}\n", task);
  }
  return file;
}

/// One task by its number, tried again while it says 75 (or dies), but not for ever.
EngineFile task_program(const EngineOptions& options) {
  return {"task.sh",
          fmt::format("#!/bin/sh\n{}"
                      "# task.sh TASK\n"
                      "unset SLURM_ARRAY_TASK_ID JOB_COMPLETION_INDEX AWS_BATCH_JOB_ARRAY_INDEX\n"
                      "PARALLEL_SEQ=$(($1 + 1)) exec {}\n",
                      spdx, run_words(options, per_task(options))),
          true};
}

Submission local(const EngineOptions& options, const std::vector<NumberRange>& tasks) {
  const unsigned cores{std::max(1U, std::thread::hardware_concurrency())};
  const int jobs{options.jobs > 0 ? options.jobs : std::max(1, static_cast<int>(cores) / options.cpus)};
  const std::string script{
      fmt::format("#!/bin/sh\n{}"
                  "# {} tasks at once; what says 75 is tried again, {} times.\n"
                  "cd {} || exit 75\n"
                  "xargs -P {} -I TASK sh -c '\n"
                  "  tries=0\n"
                  "  while :; do\n"
                  "    ./task.sh TASK; code=$?\n"
                  "    tries=$((tries + 1))\n"
                  "    case $code in 0) exit 0 ;; 64|65) exit 1 ;; esac\n"
                  "    [ $tries -le {} ] || exit 1\n"
                  "    sleep 1\n"
                  "  done' < tasks.txt\n"
                  "code=$?\n"
                  "[ $code -ne 123 ] || code=65  # some cannot be done: stereogrid batch status tells which\n"
                  "exit $code\n",
                  spdx, jobs, options.retries, shell_quoted(options.folder), jobs, options.retries)};
  return {{task_file(tasks), task_program(options), {"local.sh", script, true}}, {"sh", options.folder + "/local.sh"}};
}

Submission parallel(const EngineOptions& options, const std::vector<NumberRange>& tasks) {
  // it knows tasks by their lines: those of another submission are not these
  const EngineFile lines{task_file(tasks)};
  const std::string log{fmt::format("joblog-{}.txt", sha256_of(lines.text).substr(0, 8))};
  std::string words{fmt::format("parallel --joblog {} --resume-failed --retries {} --memfree {}M", log, options.retries,
                                options.memory_mb)};
  if (options.jobs > 0) words += fmt::format(" --jobs {}", options.jobs);
  if (options.jobs == 0) words += fmt::format(" --jobs {}%", std::max(1, 100 / options.cpus));
  if (!options.machines.empty()) words += " --sshloginfile " + shell_quoted(options.machines);
  const std::string script{
      fmt::format("#!/bin/sh\n{}"
                  "# Run it again to go on: its job log knows what is done. Tasks that cannot be done return at once.\n"
                  "cd {} || exit 75\n"
                  "exec {} {} '{{}}' :::: tasks.txt\n",
                  spdx, shell_quoted(options.folder), words, shell_quoted(options.folder + "/task.sh"))};
  return {{lines, task_program(options), {"parallel.sh", script, true}}, {"sh", options.folder + "/parallel.sh"}};
}

std::string slurm_script(const EngineOptions& options) {
  std::string script{"#!/bin/bash\n"};
  script += spdx;
  const auto option = [&](const std::string& text) { script += "#SBATCH " + text + "\n"; };
  option("--job-name=stereogrid");
  option("--requeue");
  option("--open-mode=append");
  option("--signal=B:TERM@60");
  option(fmt::format("--cpus-per-task={}", options.cpus));
  option(fmt::format("--mem={}M", options.memory_mb));
  option("--output=logs/%A_%a.txt");
  if (options.gpu) option("--gres=gpu:1");
  if (!options.time_limit.empty()) option("--time=" + options.time_limit);
  if (!options.partition.empty()) option("--partition=" + options.partition);
  script += fmt::format(
      "# The shell hands the signal on, and waits for the state to be saved. A task that says 75, or that the kernel\n"
      "# has killed for its memory, is queued again, {} times.\n"
      "{} &\n"
      "child=$!\n"
      "trap 'kill -TERM $child' TERM\n"
      "wait $child; code=$?\n"
      "while kill -0 $child 2>/dev/null; do wait $child; code=$?; done\n"
      "case $code in 70|75|13[4-9]) retry=1 ;; *) retry=0 ;; esac\n"
      "if [ $retry = 1 ] && [ \"${{SLURM_RESTART_COUNT:-0}}\" -lt {} ]; then\n"
      "  scontrol requeue \"${{SLURM_ARRAY_JOB_ID}}_${{SLURM_ARRAY_TASK_ID}}\" && sleep 60\n"
      "fi\n"
      "exit $code\n",
      options.retries, run_words(options, per_task(options)), options.retries);
  return script;
}

/// Tasks as arrays whose numbers are below the largest that Slurm is set up for, each with its offset.
Submission slurm(const EngineOptions& options, const std::vector<NumberRange>& tasks) {
  const std::uint64_t most{options.largest_array};
  std::string arrays;
  const auto submit = [&](std::uint64_t block, const ArrayList& list) {
    if (list.ranges().empty()) return;
    const std::string at_once{options.jobs > 0 ? fmt::format("%{}", options.jobs) : ""};
    arrays += fmt::format("STEREOGRID_FIRST_TASK={} sbatch --export=ALL --array={}{} slurm.sh || exit 75\n",
                          block * most, list.text(), at_once);
  };
  ArrayList list;
  std::uint64_t block{0};
  for (const NumberRange& range : tasks) {
    for (std::uint64_t task{range.first}; task <= range.last; ++task) {
      if (task / most != block) {
        submit(block, list);
        list = {};
        block = task / most;
      }
      list.add(task % most);
    }
  }
  submit(block, list);
  const std::string script{
      fmt::format("#!/bin/sh\n{}cd {} || exit 75\nmkdir -p logs\n{}", spdx, shell_quoted(options.folder), arrays)};
  return {{{"slurm.sh", slurm_script(options), true}, {"submit.sh", script, true}},
          {"sh", options.folder + "/submit.sh"}};
}

/// Text between quotes in YAML; JSON's form is one of YAML's.
std::string yaml(const std::string& text) {
  return Json(text).dump();
}

std::string pod_template(const EngineOptions& options) {
  return fmt::format(
      "  template:\n"
      "    spec:\n"
      "      restartPolicy: Never\n"
      "      terminationGracePeriodSeconds: 60\n"
      "      containers:\n"
      "      - name: stereogrid\n"
      "        image: {}\n"
      "        command: [{}, -q, batch, run, {}, --shards-per-task, \"{}\", --threads, \"{}\"]\n"
      "        resources:\n"
      "          requests: {{cpu: \"{}\", memory: {}M}}\n"
      "          limits: {{memory: {}M{}}}\n"
      "        volumeMounts:\n"
      "        - {{name: plan, mountPath: {}}}\n"
      "      volumes:\n"
      "      - name: plan\n"
      "        persistentVolumeClaim: {{claimName: {}}}\n",
      yaml(options.image), yaml(options.tool), yaml(options.plan), options.shards_per_task, options.cpus, options.cpus,
      options.memory_mb, options.memory_mb, options.gpu ? ", nvidia.com/gpu: 1" : "", yaml(options.plan),
      yaml(options.claim));
}

Submission kubernetes(const EngineOptions& options, const Plan& plan, const std::vector<NumberRange>& tasks) {
  if (options.image.empty() || options.claim.empty()) {
    throw ConfigError{"Kubernetes needs --image, with stereogrid in it, and --claim, the volume that holds the plan."};
  }
  // an Indexed Job counts from 0 to the end; tasks that are done return at once
  const std::uint64_t end{tasks.back().last + 1};
  const int jobs{options.jobs > 0 ? options.jobs : 10};
  std::string text{spdx};
  text += fmt::format(
      "apiVersion: batch/v1\n"
      "kind: Job\n"
      "metadata:\n"
      "  name: stereogrid-{}\n"
      "spec:\n"
      "  completionMode: Indexed\n"
      "  completions: {}\n"
      "  parallelism: {}\n"
      "  backoffLimitPerIndex: {}\n"
      "  maxFailedIndexes: {}\n"
      "  podFailurePolicy:\n"
      "    rules:\n"
      "    - action: FailIndex  # cannot be done\n"
      "      onExitCodes: {{containerName: stereogrid, operator: In, values: [64, 65]}}\n"
      "    - action: Ignore  # stopped, its state saved\n"
      "      onPodConditions: [{{type: DisruptionTarget}}]\n"
      "    - action: Count  # try again\n"
      "      onExitCodes: {{containerName: stereogrid, operator: In, values: [70, 75, 137, 139, 143]}}\n",
      plan.digest.substr(0, 10), end, std::min<std::uint64_t>(static_cast<std::uint64_t>(jobs), end), options.retries,
      end);
  text += pod_template(options);
  return {{{"job.yaml", text}}, {"kubectl", "apply", "-f", options.folder + "/job.yaml"}};
}

}  // namespace

std::string shell_quoted(const std::string& word) {
  std::string quoted{"'"};
  for (const char c : word) quoted += c == '\'' ? "'\\''" : std::string(1, c);
  return quoted + "'";
}

Submission submission_of(const EngineOptions& options, const Plan& plan, const std::vector<NumberRange>& tasks) {
  if (count(tasks) == 0) throw ConfigError{"There is nothing to do: every shard is done or cannot be done."};
  switch (options.engine) {
    case Engine::parallel:
      return parallel(options, tasks);
    case Engine::slurm:
      return slurm(options, tasks);
    case Engine::kubernetes:
      return kubernetes(options, plan, tasks);
    case Engine::local:
      break;
  }
  return local(options, tasks);
}

}  // namespace stereogrid::app::batch
