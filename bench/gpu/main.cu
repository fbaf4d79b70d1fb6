// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// bench_gpu [FILE.json] [FRAMES]: times of a frame on a GPU, and what the card can do at best. Prints a table, and
// writes the same as JSON. Exit status 77: no GPU.
#include <cstdio>
#include <cstdlib>
#include <sstream>

#include "chain.hpp"
#include "limits.hpp"
#include "stereogrid/error.hpp"

namespace {

using namespace stereogrid;
using namespace stereogrid::bench;

constexpr Case cases[]{{512, 320, 64, MatchingMethod::correlation},    {512, 320, 64, MatchingMethod::semi_global},
                       {1242, 375, 128, MatchingMethod::correlation},  {1242, 375, 128, MatchingMethod::semi_global},
                       {1920, 1080, 192, MatchingMethod::correlation}, {1920, 1080, 192, MatchingMethod::semi_global}};
constexpr int cameras[]{1, 2, 4, 8};

const char* name_of(MatchingMethod method) {
  return method == MatchingMethod::correlation ? "correlation" : "semi_global";
}

void write(const StageResult& stage, std::ostream& json) {
  std::printf("  %-24s %8.4f %8.4f ms\n", stage.name.c_str(), stage.median_ms, stage.p99_ms);
  json << "{\"name\": \"" << stage.name << "\", \"median_ms\": " << stage.median_ms << ", \"p99_ms\": " << stage.p99_ms
       << "}";
}

void write(const Limits& limits, std::ostream& json) {
  std::printf(
      "copy %.0f GB/s, upload %.1f GB/s, download %.1f GB/s, %.2f T additions/s, %.2f T popc/s, an empty kernel %.1f "
      "us, "
      "in a graph behind others %.2f us, between marks %.2f us\n",
      limits.copy_gb_per_s, limits.upload_gb_per_s, limits.download_gb_per_s, limits.add_per_s / 1e12,
      limits.popc_per_s / 1e12, limits.launch_us, limits.node_us, limits.marked_us);
  json << "\"limits\": {\"copy_gb_per_s\": " << limits.copy_gb_per_s
       << ", \"upload_gb_per_s\": " << limits.upload_gb_per_s << ", \"download_gb_per_s\": " << limits.download_gb_per_s
       << ", \"add_per_s\": " << limits.add_per_s << ", \"popc_per_s\": " << limits.popc_per_s
       << ", \"launch_us\": " << limits.launch_us << ", \"node_us\": " << limits.node_us
       << ", \"marked_us\": " << limits.marked_us << "}";
}

void write(const ChainResult& chain, std::ostream& json) {
  std::printf("\n%d x %d, %d disparities, %s: median and 99th percentile\n", chain.what.width, chain.what.height,
              chain.what.disparities, name_of(chain.what.method));
  json << "{\"width\": " << chain.what.width << ", \"height\": " << chain.what.height
       << ", \"disparities\": " << chain.what.disparities << ", \"method\": \"" << name_of(chain.what.method)
       << "\", \"total_median_ms\": " << chain.total_median_ms << ", \"total_p99_ms\": " << chain.total_p99_ms
       << ", \"device_median_ms\": " << chain.device_median_ms << ", \"stages\": [";
  const char* separator{""};
  for (const StageResult& stage : chain.stages) {
    json << std::exchange(separator, ", ");
    write(stage, json);
  }
  json << "]}";
  std::printf("  %-24s %8.4f %8.4f ms\n  %-24s %8.4f\n", "total, on the host", chain.total_median_ms,
              chain.total_p99_ms, "device without transfers", chain.device_median_ms);
}

void write_kernels(const Case& what, int frames, std::ostream& json) {
  std::printf("\n%d x %d, %d disparities, %s: kernels of a frame, without graphs\n", what.width, what.height,
              what.disparities, name_of(what.method));
  json << "{\"width\": " << what.width << ", \"height\": " << what.height << ", \"disparities\": " << what.disparities
       << ", \"method\": \"" << name_of(what.method) << "\", \"kernels\": [";
  const char* separator{""};
  for (const KernelResult& kernel : run_kernels(what, frames)) {
    std::printf("  %-36s %6.1f launches %9.2f us\n", kernel.name.c_str(), kernel.launches, kernel.median_us);
    json << std::exchange(separator, ", ") << "{\"name\": \"" << kernel.name << "\", \"launches\": " << kernel.launches
         << ", \"median_us\": " << kernel.median_us << "}";
  }
  json << "]}";
}

void write_batches(int frames, std::ostream& json) {
  const char* separator{""};
  for (const int count : cameras) {
    const double per_s{run_batch(cases[2], count, frames)};
    std::printf("%d cameras 1242 x 375, correlation: %.0f frames/s together\n", count, per_s);
    json << std::exchange(separator, ", ") << "{\"cameras\": " << count << ", \"frames_per_s\": " << per_s << "}";
  }
}

void run(int frames, std::ostream& json) {
  Cuda cuda;
  cudaDeviceProp device{};
  check_cuda(cudaGetDeviceProperties(&device, 0), "ask for the device's properties");
  std::printf("%s, compute capability %d.%d, %d multiprocessors\n", device.name, device.major, device.minor,
              device.multiProcessorCount);
  json << "{\"device\": \"" << device.name << "\", \"compute_capability\": \"" << device.major << "." << device.minor
       << "\", \"multiprocessors\": " << device.multiProcessorCount << ", \"frames\": " << frames << ",\n";
  write(measure_limits(cuda), json);
  json << ",\n\"chains\": [";
  const char* separator{"\n"};
  for (const Case& what : cases) {
    json << std::exchange(separator, ",\n");
    write(run_chain(what, frames), json);
  }
  json << "],\n\"kernels\": [";
  separator = "\n";
  for (const Case& what : cases) {
    json << std::exchange(separator, ",\n");
    write_kernels(what, frames, json);
  }
  std::printf("\n");
  json << "],\n\"filter\": ";
  write(run_filter(400, frames), json);
  json << ",\n\"batches\": [";
  write_batches(frames, json);
  json << "]}\n";
}

}  // namespace

int main(int count, char** arguments) {
  std::ostringstream json;
  try {
    run(count > 2 ? std::atoi(arguments[2]) : 500, json);
  } catch (const DeviceError& error) {
    std::printf("Nothing was measured: %s\n", error.what());
    return 77;
  }
  if (count < 2) return 0;
  std::FILE* const file{std::fopen(arguments[1], "w")};
  if (file == nullptr) {
    std::printf("%s cannot be written.\n", arguments[1]);
    return 1;
  }
  std::fputs(json.str().c_str(), file);
  return std::fclose(file) == 0 ? 0 : 1;
}
