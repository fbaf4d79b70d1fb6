// SPDX-License-Identifier: Apache-2.0
#include <cxxabi.h>

#include <cstdint>
#include <cstdlib>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "drive.hpp"
#include "samples.hpp"

namespace stereogrid::bench {
namespace {

/// Marks the time before and after each kernel.
class KernelClock final : public LaunchWatch {
 public:
  KernelClock() = default;
  KernelClock(const KernelClock&) = delete;
  KernelClock& operator=(const KernelClock&) = delete;
  ~KernelClock() {
    for (const Launch& launch : launches_) {
      cudaEventDestroy(launch.start);
      cudaEventDestroy(launch.end);
    }
  }

  void begin(cudaStream_t stream, const void* kernel) override {
    if (used_ == launches_.size()) {
      launches_.emplace_back();
      check_cuda(cudaEventCreate(&launches_.back().start), "create an event");
      check_cuda(cudaEventCreate(&launches_.back().end), "create an event");
    }
    launches_[used_].kernel = kernel;
    check_cuda(cudaEventRecord(launches_[used_].start, stream), "mark a time");
  }
  void end(cudaStream_t stream) override { check_cuda(cudaEventRecord(launches_[used_++].end, stream), "mark a time"); }

  /// Calls work(kernel, microseconds) for each launch since the last call, all of which must be done.
  template <class Work>
  void take(const Work& work) {
    for (std::size_t i{0}; i < used_; ++i) {
      float ms{0};
      check_cuda(cudaEventElapsedTime(&ms, launches_[i].start, launches_[i].end), "measure time");
      work(launches_[i].kernel, 1e3 * ms);
    }
    used_ = 0;
  }

 private:
  struct Launch {
    const void* kernel{nullptr};
    cudaEvent_t start{};
    cudaEvent_t end{};
  };
  std::deque<Launch> launches_;
  std::size_t used_{0};
};

// Name without namespaces and parameters; CUDA provides names from 12.3 on.
std::string name_of(const void* kernel) {
  const char* mangled{nullptr};
#if CUDART_VERSION >= 12030
  if (cudaFuncGetName(&mangled, kernel) != cudaSuccess) mangled = nullptr;
#endif
  if (mangled == nullptr) return "kernel at " + std::to_string(reinterpret_cast<std::uintptr_t>(kernel));
  int status{0};
  const std::unique_ptr<char, decltype(&std::free)> readable{abi::__cxa_demangle(mangled, nullptr, nullptr, &status),
                                                             std::free};
  std::string name{status == 0 ? readable.get() : mangled};
  for (const std::string_view space : {"void ", "stereogrid::", "(anonymous namespace)::"}) {
    for (std::size_t at{name.find(space)}; at != std::string::npos; at = name.find(space)) name.erase(at, space.size());
  }
  return name.substr(0, name.find('('));
}

struct OfKernel {
  double in_frame_us{0};
  Samples frames_us{};
};

}  // namespace

std::vector<KernelResult> run_kernels(const Case& what, int frames) {
  const std::vector<StereoFrame> shown{drawn(what)};
  KernelClock clock;
  Drive drive{what};
  drive.stages().go_without_graphs(clock);
  for (int i{0}; i < warm_up; ++i) drive.step(shown);
  clock.take([](const void*, double) {});
  std::map<const void*, OfKernel> kernels;
  for (int i{0}; i < frames; ++i) {
    drive.step(shown);
    clock.take([&](const void* kernel, double us) { kernels[kernel].in_frame_us += us; });
    for (auto& [kernel, of_kernel] : kernels) of_kernel.frames_us.add(std::exchange(of_kernel.in_frame_us, 0));
  }
  std::vector<KernelResult> results;
  for (const auto& [kernel, of_kernel] : kernels) {
    results.push_back({name_of(kernel), of_kernel.frames_us.percentile(50)});
  }
  return results;
}

}  // namespace stereogrid::bench
