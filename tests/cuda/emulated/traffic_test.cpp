// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// What launches read and write of device memory, as the emulator counts it.
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "backend/cuda.hpp"

namespace stereogrid::test {
namespace {

constexpr std::size_t page_bytes{4096};
constexpr std::size_t page{page_bytes / sizeof(int)};
constexpr std::size_t last{page / 2};  // elements of a page that is there in part
constexpr int block_threads{64};

// Of pages 0 to 5: not touched, read, written, read and written by one instruction, by two, and the last one written.
__global__ void use_pages(int* values) {
  const std::size_t i{threadIdx.x + std::size_t{blockIdx.x} * blockDim.x};
  values[2 * page + i] = values[page + i];
  values[3 * page + i] += 3;
  values[4 * page + i] = 2 * values[4 * page + i] + values[page + i];
  if (i < last) values[5 * page + i] = static_cast<int>(i);
}

__global__ void add_shared(const int* values, int* sum) {
  __shared__ int own[block_threads];
  own[threadIdx.x] = values[threadIdx.x];
  __syncthreads();
  if (threadIdx.x == 0) {
    for (const int value : own) *sum += value;
  }
}

struct Line {
  unsigned blocks, threads;
  std::size_t read, written;
  bool operator==(const Line&) const = default;
};
void PrintTo(const Line& line, std::ostream* out) {
  *out << line.blocks << " x " << line.threads << ": " << line.read << ", " << line.written;
}

std::vector<Line> lines_of(const std::filesystem::path& file) {
  std::ifstream in{file};
  std::vector<Line> lines;
  for (Line line{}; in >> line.blocks >> line.threads >> line.read >> line.written;) lines.push_back(line);
  return lines;
}

TEST(Traffic, PagesThatALaunchReadsAndWrites) {
#if !defined(__x86_64__)
  GTEST_SKIP() << "counted on x86-64 only";
#endif
  const std::filesystem::path file{std::filesystem::temp_directory_path() /
                                   ("stereogrid_traffic_" + std::to_string(getpid()))};
  setenv("STEREOGRID_EMULATOR_TRAFFIC", file.c_str(), 1);
  Cuda cuda;
  std::vector<int> values(5 * page + last, 7);
  DeviceBuffer<int> device{values.size()};
  DeviceBuffer<int> sum{1};
  upload(cuda, values.data(), values.size(), device.data());
  launch(cuda, use_pages, page / block_threads, block_threads, 0, device.data());
  launch(cuda, add_shared, 1, block_threads, 0, device.data() + 2 * page, sum.data());
  download(cuda, device.data(), values.size(), values.data());
  int total{0};
  download(cuda, sum.data(), 1, &total);
  cuda.synchronize();
  const std::vector<Line> lines{lines_of(file)};
  std::filesystem::remove(file);

  constexpr std::size_t last_bytes{last * sizeof(int)};
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines[0], (Line{page / block_threads, block_threads, 3 * page_bytes, 3 * page_bytes + last_bytes}));
  EXPECT_EQ(lines[1], (Line{1, block_threads, page_bytes + sizeof(int), sizeof(int)}));
  const std::array<int, 6> expected{7, 7, 7, 10, 21, 5};
  for (std::size_t i{0}; i < expected.size(); ++i) EXPECT_EQ(values[i * page + 5], expected[i]) << i;
  EXPECT_EQ(total, 7 * block_threads);
}

}  // namespace
}  // namespace stereogrid::test
