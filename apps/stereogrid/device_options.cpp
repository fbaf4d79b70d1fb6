// SPDX-License-Identifier: Apache-2.0
#include "device_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <initializer_list>
#include <stdexcept>
#include <system_error>
#include <typeinfo>

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

}  // namespace

std::string device_problem(const std::string& device) {
  const std::initializer_list<std::string_view> names{"auto", "cpu", "cuda", "reference"};
  const bool is_known{std::find(names.begin(), names.end(), device) != names.end() || gpu_of(device) >= 0};
  return is_known ? "" : fmt::format("{}: not one of auto, cpu, cuda, cuda:1 (the second GPU), reference", device);
}

void set_device(PipelineOptions& pipeline, const DeviceOptions& options) {
  pipeline.back_end = back_end_of(options.device);
  pipeline.threads = options.threads;
  pipeline.device = std::max(gpu_of(options.device), 0);
}

std::string_view name_of(BackEnd back_end) {
  if (back_end == BackEnd::cuda) return "cuda";
  return back_end == BackEnd::reference ? "reference" : "cpu";
}

std::string thread_failure(const std::exception& error) {
  const auto* const of_system{dynamic_cast<const std::system_error*>(&error)};
  const bool is_of_standard{of_system != nullptr && of_system->code() == std::errc::resource_unavailable_try_again};
  const bool is_of_tbb{typeid(error) == typeid(std::runtime_error) &&
                       std::string_view{error.what()}.starts_with("pthread_create")};
  if (!is_of_standard && !is_of_tbb) return {};
  return std::string{"a thread cannot be started: "} + error.what() +
         ". Allow more threads or address space (ulimit -u, ulimit -v, the container's limits).";
}

}  // namespace stereogrid::app
