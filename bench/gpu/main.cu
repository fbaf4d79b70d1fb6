// SPDX-License-Identifier: Apache-2.0
//
// bench_gpu [FRAMES]: times of a frame's work on a GPU, and what the card can do at best, as Markdown tables. Times of
// whole frames, the host's work with them, are bench_chain's. Exit status 77: no GPU.
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include "chain.hpp"
#include "stereogrid/error.hpp"

namespace {

using namespace stereogrid;
using namespace stereogrid::bench;

constexpr Case cases[]{{512, 320, 64}, {1242, 375, 128}, {1920, 1080, 192}};

std::string name_of(const Case& what) {
  return std::to_string(what.width) + " × " + std::to_string(what.height) + " × " + std::to_string(what.disparities);
}

void print_rule(int numbers) {
  std::printf("|---|");
  for (int i{0}; i < numbers; ++i) std::printf("---:|");
  std::printf("\n");
}

void print(const Limits& limits) {
  std::printf("**Limits of the card**\n\n| | measured |\n|---|---:|\n");
  const auto row = [](const char* name, double value) { std::printf("| %s | %.2f |\n", name, value); };
  row("copy on the device, GB/s", limits.copy_gb_per_s);
  row("upload, GB/s", limits.upload_gb_per_s);
  row("download, GB/s", limits.download_gb_per_s);
  row("additions of 32 bits, 10^12/s", limits.add_per_s / 1e12);
  row("bits of a word counted, 10^12/s", limits.popc_per_s / 1e12);
  row("empty kernel in a graph, with the wait, µs", limits.launch_us);
  row("each further kernel of a graph, µs", limits.node_us);
  row("empty kernel between two marks, µs", limits.marked_us);
}

void print_chains(int frames) {
  std::printf("\n**Stages of a frame on the device, median ms**\n\n");
  bool is_first{true};
  for (const Case& what : cases) {
    const ChainResult chain{run_chain(what, frames)};
    if (is_first) {
      std::printf("| image and disparities |");
      for (const StageResult& stage : chain.stages) std::printf(" %s |", stage.name.c_str());
      std::printf(" without transfers | 99 %% of the frames |\n");
      print_rule(static_cast<int>(chain.stages.size()) + 2);
    }
    is_first = false;
    std::printf("| %s |", name_of(what).c_str());
    for (const StageResult& stage : chain.stages) std::printf(" %.3f |", stage.median_ms);
    std::printf(" %.3f | %.3f |\n", chain.device_median_ms, chain.device_p99_ms);
  }
}

void print_kernels(int frames) {
  std::map<std::string, std::vector<double>> times;
  for (std::size_t i{0}; i < std::size(cases); ++i) {
    for (const KernelResult& kernel : run_kernels(cases[i], frames)) {
      std::vector<double>& of_cases{times[kernel.name]};
      of_cases.resize(std::size(cases));
      of_cases[i] += kernel.median_us;
    }
  }
  std::printf("\n**Kernels of a frame, each between two marks, without graphs, median µs**\n\n| kernel |");
  for (const Case& what : cases) std::printf(" %s |", name_of(what).c_str());
  std::printf("\n");
  print_rule(static_cast<int>(std::size(cases)));
  for (const auto& [name, of_cases] : times) {
    std::printf("| `%s` |", name.c_str());
    for (const double us : of_cases) us > 0 ? std::printf(" %.1f |", us) : std::printf(" – |");
    std::printf("\n");
  }
}

void run(int frames) {
  Cuda cuda;
  cudaDeviceProp device{};
  check_cuda(cudaGetDeviceProperties(&device, 0), "ask for the device's properties");
  std::printf("%s, compute capability %d.%d, %d multiprocessors\n\n", device.name, device.major, device.minor,
              device.multiProcessorCount);
  print(measure_limits(cuda));
  print_chains(frames);
  print_kernels(frames);
  const StageResult filter{run_filter(400, frames)};
  std::printf("\n**The filter alone, all blocks moving**\n\n| cells and velocities | median ms |\n|---|---:|\n");
  std::printf("| %s | %.3f |\n", filter.name.c_str(), filter.median_ms);
}

}  // namespace

int main(int count, char** arguments) {
  try {
    run(count > 1 ? std::atoi(arguments[1]) : 100);
  } catch (const DeviceError& error) {
    std::printf("Nothing was measured: %s\n", error.what());
    return 77;
  }
  return 0;
}
