// SPDX-License-Identifier: Apache-2.0
//
// Barriers, shuffles, atomics, shared memory and graphs: of the device, or of the emulator.
#include <cstdint>
#include <numeric>
#include <vector>

#include "backend/cuda.hpp"
#include "check.hpp"

namespace stereogrid::test {
namespace {

constexpr int block_threads{96};

// Every thread writes, then reads what another one wrote, again and again.
__global__ void rotate(int rounds, int* out) {
  __shared__ int values[block_threads];
  const int i{static_cast<int>(threadIdx.x)};
  values[i] = i;
  for (int round{0}; round < rounds; ++round) {
    __syncthreads();
    const int next{values[(i + 1) % block_threads]};
    __syncthreads();
    values[i] = next;
  }
  out[static_cast<int>(blockIdx.x) * block_threads + i] = values[i];
}

// Inclusive prefix sums of a warp.
__global__ void scan(const int* in, int* out) {
  const int i{static_cast<int>(threadIdx.x)};
  int sum{in[i]};
  for (unsigned delta{1}; delta < 32; delta *= 2) {
    const int other{__shfl_up_sync(0xffffffffU, sum, delta)};
    if (i % 32 >= static_cast<int>(delta)) sum += other;
  }
  out[i] = sum;
}

__global__ void vote(unsigned* ballots, int* neighbours) {
  const int i{static_cast<int>(threadIdx.x)};
  ballots[i] = __ballot_sync(0xffffffffU, i % 3 == 0 ? 1 : 0);
  neighbours[i] = __shfl_xor_sync(0xffffffffU, i, 1) + 100 * __shfl_sync(0xffffffffU, i, 5, 8);
  if (i < 16) neighbours[i] += 10000 * __shfl_down_sync(0x0000ffffU, i, 3, 16);
}

// Threads that end early must not hold up the others.
__global__ void histogram(const std::uint8_t* values, int count, unsigned* bins) {
  unsigned* const own{dynamic_shared<unsigned>()};
  for (unsigned k{threadIdx.x}; k < 256; k += blockDim.x) own[k] = 0;
  __syncthreads();
  const int i{static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x)};
  if (i < count) atomicAdd(&own[values[i]], 1U);
  __syncthreads();
  for (unsigned k{threadIdx.x}; k < 256; k += blockDim.x) {
    if (own[k] > 0) atomicAdd(&bins[k], own[k]);
  }
}

__global__ void add_to(int* value, const int* summand) {
  *value += *summand;
}

template <class T>
std::vector<T> fetched(Cuda& cuda, const DeviceBuffer<T>& buffer) {
  std::vector<T> values(buffer.size());
  download(cuda, buffer.data(), buffer.size(), values.data());
  cuda.synchronize();
  return values;
}

TEST(barriers_let_all_threads_wait) {
  Cuda cuda;
  DeviceBuffer<int> out{std::size_t{2} * block_threads};
  launch(cuda, rotate, 2, block_threads, 0, 37, out.data());
  const std::vector<int> values{fetched(cuda, out)};
  for (int i{0}; i < 2 * block_threads; ++i) {
    CHECK_EQUAL(values[static_cast<std::size_t>(i)], (i % block_threads + 37) % block_threads);
  }
}

TEST(shuffles_hand_values_through_a_warp) {
  Cuda cuda;
  std::vector<int> in(64);
  std::iota(in.begin(), in.end(), 3);
  DeviceBuffer<int> device_in{in.size()};
  DeviceBuffer<int> out{in.size()};
  upload(cuda, in.data(), in.size(), device_in.data());
  launch(cuda, scan, 1, 64, 0, device_in.data(), out.data());
  const std::vector<int> sums{fetched(cuda, out)};
  for (int i{0}; i < 64; ++i) {
    int sum{0};
    for (int k{i / 32 * 32}; k <= i; ++k) sum += k + 3;
    CHECK_EQUAL(sums[static_cast<std::size_t>(i)], sum);
  }
}

TEST(ballots_and_parts_of_a_warp) {
  Cuda cuda;
  DeviceBuffer<unsigned> ballots{32};
  DeviceBuffer<int> neighbours{32};
  launch(cuda, vote, 1, 32, 0, ballots.data(), neighbours.data());
  for (const unsigned ballot : fetched(cuda, ballots)) CHECK_EQUAL(ballot, 0x49249249U);
  const std::vector<int> values{fetched(cuda, neighbours)};
  for (int i{0}; i < 32; ++i) {
    const int below{i < 16 ? 10000 * (i + 3 < 16 ? i + 3 : i) : 0};
    CHECK_EQUAL(values[static_cast<std::size_t>(i)], (i ^ 1) + 100 * (i / 8 * 8 + 5) + below);
  }
}

TEST(atomics_in_shared_and_device_memory) {
  Cuda cuda;
  std::vector<std::uint8_t> in(1000);
  for (std::size_t i{0}; i < in.size(); ++i) in[i] = static_cast<std::uint8_t>(i * i % 251);
  std::vector<unsigned> expected(256);
  for (const std::uint8_t value : in) ++expected[value];
  DeviceBuffer<std::uint8_t> device_in{in.size()};
  DeviceBuffer<unsigned> bins{256};
  upload(cuda, in.data(), in.size(), device_in.data());
  launch(cuda, histogram, blocks_for(1000, 128), 128, 256 * sizeof(unsigned), device_in.data(), 1000, bins.data());
  CHECK(fetched(cuda, bins) == expected);
}

TEST(a_graph_repeats_what_was_captured) {
  Cuda cuda;
  PinnedBuffer<int> summand{1};
  DeviceBuffer<int> device_summand{1};
  DeviceBuffer<int> value{1};
  Graph graph;
  graph.capture(cuda, [&] {
    upload(cuda, summand.data(), 1, device_summand.data());
    launch(cuda, add_to, 1, 1, 0, value.data(), device_summand.data());
  });
  CHECK_EQUAL(fetched(cuda, value)[0], 0);
  for (int frame{1}; frame <= 3; ++frame) {
    *summand.data() = frame * frame;
    graph.launch(cuda);
    cuda.synchronize();
  }
  CHECK_EQUAL(fetched(cuda, value)[0], 1 + 4 + 9);
}

TEST(waiting_sleeps_where_cores_are_few) {
  CHECK_EQUAL(wait_flags(2, false), cudaEventBlockingSync);
  CHECK_EQUAL(wait_flags(64, false), cudaEventDefault);
  CHECK_EQUAL(wait_flags(64, true), cudaEventBlockingSync);
}

TEST(what_the_device_refuses_is_said) {
  Cuda cuda;
  DeviceBuffer<int> value{2};
  const std::string error_text{
      error_text_of([&] { launch(cuda, add_to, 1, 5000, 0, value.data(), value.data() + 1); })};
  CHECK(error_text.find("could not start a kernel: invalid") != std::string::npos);
  CHECK_EQUAL(error_text_of([] { allocate_on_device(std::size_t{1} << 50); }).find("The GPU's memory is too small"),
              0U);
}

}  // namespace
}  // namespace stereogrid::test
