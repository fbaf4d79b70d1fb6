// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <vector>

#include "backend/cuda.hpp"

namespace stereogrid::bench {

/// Milliseconds, measured again and again.
class Samples {
 public:
  void add(double milliseconds) { values_.push_back(milliseconds); }
  template <class Work>
  void time(const Work& work) {
    const auto start{std::chrono::steady_clock::now()};
    work();
    add(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
  }

  /// Smallest value that at least `percent` of all do not exceed.
  [[nodiscard]] double percentile(double percent) const {
    if (values_.empty()) return 0;
    std::vector<double> sorted{values_};
    std::sort(sorted.begin(), sorted.end());
    const auto rank{static_cast<std::size_t>(percent / 100 * static_cast<double>(sorted.size() - 1) + 0.5)};
    return sorted[rank];
  }

 private:
  std::vector<double> values_;
};

/// Times of the device work that `work` enqueues, by the device's clock.
template <class Work>
double median_ms(Cuda& cuda, int repetitions, const Work& work) {
  cudaEvent_t start{};
  cudaEvent_t end{};
  check_cuda(cudaEventCreate(&start), "create an event");
  check_cuda(cudaEventCreate(&end), "create an event");
  Samples samples;
  for (int i{-3}; i < repetitions; ++i) {
    check_cuda(cudaEventRecord(start, cuda.stream()), "mark a time");
    work();
    check_cuda(cudaEventRecord(end, cuda.stream()), "mark a time");
    cuda.synchronize();
    float ms{0};
    check_cuda(cudaEventElapsedTime(&ms, start, end), "measure time");
    if (i >= 0) samples.add(ms);
  }
  cudaEventDestroy(start);
  cudaEventDestroy(end);
  return samples.percentile(50);
}

}  // namespace stereogrid::bench
