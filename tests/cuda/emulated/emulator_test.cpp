// SPDX-License-Identifier: Apache-2.0
//
// Faults of kernels that the emulator shows.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>

#include "backend/cuda.hpp"

namespace stereogrid {
namespace {

void add_one(float* numbers) {
  numbers[threadIdx.x] += 1;
}

void wait_alone() {
  if (threadIdx.x == 0) __syncthreads();
  if (threadIdx.x == 1) __syncwarp(2);
  if (threadIdx.x == 2) __syncwarp(7);
}

float one_more(std::size_t written, std::size_t read) {
  Cuda cuda;
  DeviceImage<float> numbers{8, 1};
  clear(cuda, numbers.data(), written);
  launch(cuda, add_one, 1, 8, 0, numbers.data());
  float number{0};
  download(cuda, numbers.data() + read, 1, &number);
  return number;
}

TEST(Emulator, WhatNobodyHasWrittenIsNaN) {
  EXPECT_EQ(one_more(7, 6), 1);
  EXPECT_TRUE(std::isnan(one_more(7, 7)));
  EXPECT_NE(std::bit_cast<std::uint32_t>(one_more(7, 7)), std::bit_cast<std::uint32_t>(one_more(7, 7)));
}

TEST(EmulatorDeathTest, ThreadsThatWaitForEver) {
  Cuda cuda;
  EXPECT_DEATH(launch(cuda, wait_alone, 1, 3, 0), "waits for lanes that never come");
}

}  // namespace
}  // namespace stereogrid
