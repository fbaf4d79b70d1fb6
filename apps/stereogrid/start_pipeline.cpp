// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "start_pipeline.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>

#include "cli/option_checks.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid::app {

void add_device_options(CLI::App& command, DeviceOptions& options) {
  command.add_option("--device", options.device, "Device that computes; auto: the fastest available.")
      ->type_name("DEVICE")
      ->check(CLI::Validator{device_problem, "{auto,cpu,cuda,cuda:N,reference}"})
      ->capture_default_str();
  command
      .add_option("--threads", options.threads, "Threads of the pipeline; 0: all cores. Results do not depend on it.")
      ->type_name("N")
      ->check(whole_number(0, 1024), "[0 - 1024]")
      ->capture_default_str();
}

Pipeline start_pipeline(const Config& config, const Rig& rig, const DeviceOptions& options, PipelineOptions made) {
  set_device(made, options);
  try {
    Pipeline pipeline{config, rig, made};
    if (pipeline.back_end() == BackEnd::cuda) spdlog::info("on the GPU");
    if (!pipeline.why_not_cuda().empty()) spdlog::info("on the CPU. No GPU: {}", pipeline.why_not_cuda());
    return pipeline;
  } catch (const DeviceError& error) {
    if (made.back_end != BackEnd::cuda) throw;  // such as a thread that cannot be started
    throw DeviceError{fmt::format("--device {}: {} Take --device cpu, or auto.", options.device, error.what())};
  }
}

}  // namespace stereogrid::app
