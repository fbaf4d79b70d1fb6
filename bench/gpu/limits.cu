// SPDX-License-Identifier: Apache-2.0
#include "chain.hpp"

#include <cstdint>

#include "samples.hpp"

namespace stereogrid::bench {
namespace {

constexpr int threads{256};
constexpr int rounds{4096};
constexpr int unrolled{8};
constexpr std::size_t copied_bytes{std::size_t{256} << 20};
constexpr std::size_t transferred_bytes{std::size_t{32} << 20};

__global__ void copy(const uint4* from, std::size_t count, uint4* to) {
  const std::size_t step{static_cast<std::size_t>(gridDim.x) * threads};
  for (std::size_t i{blockIdx.x * std::size_t{threads} + threadIdx.x}; i < count; i += step) to[i] = from[i];
}

// Independent chains, so that none waits for another; the result is kept, so that nothing is left out.
template <bool is_popc>
__global__ void work(unsigned seed, unsigned* out) {
  unsigned chain[unrolled];
  for (int k{0}; k < unrolled; ++k) chain[k] = seed + threadIdx.x + static_cast<unsigned>(k);
  for (int round{0}; round < rounds; ++round) {
    for (int k{0}; k < unrolled; ++k) {
      // the other chain's number keeps the compiler from adding up several rounds at once
      const unsigned other{chain[(k + 1) % unrolled]};
      chain[k] = is_popc ? static_cast<unsigned>(__popc(chain[k])) ^ other : chain[k] + other;
    }
  }
  unsigned sum{0};
  for (const unsigned value : chain) sum ^= value;
  out[blockIdx.x * threads + threadIdx.x] = sum;
}

__global__ void nothing() {}

double operations_per_s(Cuda& cuda, bool is_popc) {
  const unsigned blocks{static_cast<unsigned>(cuda.multiprocessors()) * 16};
  DeviceBuffer<unsigned> out{static_cast<std::size_t>(blocks) * threads};
  const double ms{median_ms(
      cuda, 20, [&] { launch(cuda, is_popc ? work<true> : work<false>, blocks, threads, 0, 3U, out.data()); })};
  return static_cast<double>(blocks) * threads * rounds * unrolled / ms * 1e3;
}

double launch_us(Cuda& cuda) {
  Graph graph;
  graph.capture(cuda, [&] { launch(cuda, nothing, 1, 32, 0); });
  Samples samples;
  for (int i{0}; i < 300; ++i) {
    samples.time([&] {
      graph.launch(cuda);
      cuda.synchronize();
    });
  }
  return samples.percentile(50) * 1e3;
}

double node_us(Cuda& cuda) {
  constexpr int nodes{100};
  Graph graph;
  graph.capture(cuda, [&] {
    for (int i{0}; i < nodes; ++i) launch(cuda, nothing, 1, 32, 0);
  });
  return 1e3 * median_ms(cuda, 100, [&] { graph.launch(cuda); }) / nodes;
}

}  // namespace

Limits measure_limits(Cuda& cuda) {
  Limits limits{};
  {
    DeviceBuffer<uint4> from{copied_bytes / sizeof(uint4)};
    DeviceBuffer<uint4> to{from.size()};
    const unsigned blocks{static_cast<unsigned>(cuda.multiprocessors()) * 16};
    const double ms{
        median_ms(cuda, 20, [&] { launch(cuda, copy, blocks, threads, 0, from.data(), from.size(), to.data()); })};
    limits.copy_gb_per_s = 2.0 * copied_bytes / ms / 1e6;
  }
  PinnedBuffer<std::uint8_t> host{transferred_bytes};
  DeviceBuffer<std::uint8_t> device{transferred_bytes};
  limits.upload_gb_per_s =
      transferred_bytes / 1e6 / median_ms(cuda, 20, [&] { upload(cuda, host.data(), host.size(), device.data()); });
  limits.download_gb_per_s =
      transferred_bytes / 1e6 / median_ms(cuda, 20, [&] { download(cuda, device.data(), host.size(), host.data()); });
  limits.add_per_s = operations_per_s(cuda, false);
  limits.popc_per_s = operations_per_s(cuda, true);
  limits.launch_us = launch_us(cuda);
  limits.node_us = node_us(cuda);
  limits.marked_us = 1e3 * median_ms(cuda, 300, [&] { launch(cuda, nothing, 1, 32, 0); });
  return limits;
}

}  // namespace stereogrid::bench
