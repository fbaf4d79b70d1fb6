// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "start_pipeline.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <initializer_list>
#include <string_view>
#include <system_error>

#include "cli/option_checks.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid::app {
namespace {

constexpr std::string_view first_gpus{"cuda:"};

BackEnd back_end_of(const std::string& device) {
  if (device == "auto") return BackEnd::automatic;
  if (device.starts_with("cuda")) return BackEnd::cuda;
  return device == "reference" ? BackEnd::reference : BackEnd::cpu;
}

// The number in "cuda:1"; −1: there is none.
int gpu_of(std::string_view device) {
  if (!device.starts_with(first_gpus)) return -1;
  const std::string_view number{device.substr(first_gpus.size())};
  int gpu{-1};
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), gpu);
  return error == std::errc{} && end == number.data() + number.size() && gpu >= 0 ? gpu : -1;
}

std::string problem_of(const std::string& device) {
  const std::initializer_list<std::string_view> names{"auto", "cpu", "cuda", "reference"};
  const bool is_known{std::find(names.begin(), names.end(), device) != names.end() || gpu_of(device) >= 0};
  return is_known ? "" : fmt::format("{}: not one of auto, cpu, cuda, cuda:1 (the second GPU), reference", device);
}

}  // namespace

void add_device_options(CLI::App& command, DeviceOptions& options) {
  command.add_option("--device", options.device, "Where the work is done; auto: the fastest there is.")
      ->type_name("DEVICE")
      ->check(CLI::Validator{problem_of, "{auto,cpu,cuda,cuda:N,reference}"})
      ->capture_default_str();
  command
      .add_option("--threads", options.threads, "Threads of the pipeline; 0: all cores. Results do not depend on it.")
      ->type_name("N")
      ->check(whole_number(0, 1024), "[0 - 1024]")
      ->capture_default_str();
}

Pipeline start_pipeline(const Config& config, const Rig& rig, const DeviceOptions& options, PipelineOptions made) {
  made.back_end = back_end_of(options.device);
  made.threads = options.threads;
  made.device = std::max(gpu_of(options.device), 0);
  try {
    Pipeline pipeline{config, rig, made};
    if (pipeline.back_end() == BackEnd::cuda) spdlog::info("on the GPU");
    if (!pipeline.why_not_cuda().empty()) spdlog::info("on the CPU. No GPU: {}", pipeline.why_not_cuda());
    return pipeline;
  } catch (const DeviceError& error) {
    throw DeviceError{fmt::format("--device {}: {} Take --device cpu, or auto.", options.device, error.what())};
  }
}

std::string_view name_of(BackEnd back_end) {
  if (back_end == BackEnd::cuda) return "cuda";
  return back_end == BackEnd::reference ? "reference" : "cpu";
}

}  // namespace stereogrid::app
