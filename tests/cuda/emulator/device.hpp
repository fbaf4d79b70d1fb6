// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <utility>

// CUDA's keywords, vector types and device functions that kernels use.

#define __host__
#define __device__
#define __noinline__  // an attribute of the host compiler has this name
#define __global__
#define __shared__ static
#define __launch_bounds__(...)
#define __align__(n) alignas(n)

struct uint3 {
  unsigned x, y, z;
};
struct dim3 {
  unsigned x{1}, y{1}, z{1};
  constexpr dim3(unsigned vx = 1, unsigned vy = 1, unsigned vz = 1) : x{vx}, y{vy}, z{vz} {}
};

struct alignas(16) float4 {
  float x, y, z, w;
};
inline float4 make_float4(float x, float y, float z, float w) {
  return {x, y, z, w};
}
struct alignas(16) uint4 {
  unsigned x, y, z, w;
};

inline constexpr int warpSize{32};
inline uint3 threadIdx{};
inline uint3 blockIdx{};
inline dim3 blockDim{};
inline dim3 gridDim{};

namespace emulator {

void* dynamic_shared();
void block_barrier();
/// Waits for the lanes of `mask`; `combine` then runs once and fills `results` from all lanes' `values`.
enum class WarpOperation { shuffle, ballot, nothing };
std::uint64_t warp_exchange(unsigned mask, std::uint64_t value, int source_lane, WarpOperation operation);
int lane();

template <class T>
T shuffle(unsigned mask, T value, int source_lane) {
  static_assert(sizeof(T) <= sizeof(std::uint64_t) && std::is_trivially_copyable_v<T>);
  std::uint64_t bits{0};
  std::memcpy(&bits, &value, sizeof(T));
  bits = warp_exchange(mask, bits, source_lane, WarpOperation::shuffle);
  std::memcpy(&value, &bits, sizeof(T));
  return value;
}

}  // namespace emulator

inline void __syncthreads() {
  emulator::block_barrier();
}
/// Whether the predicate holds in any thread of the block.
inline int __syncthreads_or(int predicate) {
  static bool holds_in_any;
  holds_in_any |= predicate != 0;
  __syncthreads();
  const int result{holds_in_any ? 1 : 0};
  __syncthreads();
  holds_in_any = false;
  __syncthreads();
  return result;
}
inline void __syncwarp(unsigned mask = 0xffffffffU) {
  emulator::warp_exchange(mask, 0, 0, emulator::WarpOperation::nothing);
}

inline unsigned __ballot_sync(unsigned mask, int predicate) {
  return static_cast<unsigned>(
      emulator::warp_exchange(mask, predicate != 0 ? 1 : 0, 0, emulator::WarpOperation::ballot));
}

template <class T>
T __shfl_sync(unsigned mask, T value, int source, int width = warpSize) {
  const int first{emulator::lane() / width * width};
  return emulator::shuffle(mask, value, first + (source & (width - 1)));
}
template <class T>
T __shfl_up_sync(unsigned mask, T value, unsigned delta, int width = warpSize) {
  const int lane{emulator::lane()};
  const int source{lane - static_cast<int>(delta)};
  return emulator::shuffle(mask, value, source < lane / width * width ? lane : source);
}
template <class T>
T __shfl_down_sync(unsigned mask, T value, unsigned delta, int width = warpSize) {
  const int lane{emulator::lane()};
  const int source{lane + static_cast<int>(delta)};
  return emulator::shuffle(mask, value, source >= (lane / width + 1) * width ? lane : source);
}
template <class T>
T __shfl_xor_sync(unsigned mask, T value, int lane_mask, int width = warpSize) {
  const int lane{emulator::lane()};
  const int source{lane ^ lane_mask};
  return emulator::shuffle(mask, value, source >= (lane / width + 1) * width ? lane : source);
}

// Threads change at barriers only: plain arithmetic is atomic.
template <class T>
T atomicAdd(T* address, std::type_identity_t<T> value) {
  return std::exchange(*address, static_cast<T>(*address + value));
}
template <class T>
T atomicSub(T* address, std::type_identity_t<T> value) {
  return std::exchange(*address, static_cast<T>(*address - value));
}
template <class T>
T atomicMin(T* address, std::type_identity_t<T> value) {
  return std::exchange(*address, value < *address ? value : *address);
}
template <class T>
T atomicMax(T* address, std::type_identity_t<T> value) {
  return std::exchange(*address, *address < value ? value : *address);
}
template <class T>
T atomicOr(T* address, std::type_identity_t<T> value) {
  return std::exchange(*address, *address | value);
}

inline float __int_as_float(int value) {
  return std::bit_cast<float>(value);
}
inline int __float_as_int(float value) {
  return std::bit_cast<int>(value);
}
inline int __popc(unsigned bits) {
  return std::popcount(bits);
}
inline int __clz(int bits) {
  return std::countl_zero(static_cast<unsigned>(bits));
}
/// 1 + the lowest bit that is set; 0: none.
inline int __ffs(int bits) {
  return bits == 0 ? 0 : std::countr_zero(static_cast<unsigned>(bits)) + 1;
}
inline unsigned __byte_perm(unsigned x, unsigned y, unsigned selector) {
  const std::uint64_t bytes{static_cast<std::uint64_t>(y) << 32 | x};
  unsigned result{0};
  for (int i{0}; i < 4; ++i) {
    const unsigned choice{selector >> (4 * i) & 0xfU};
    unsigned byte{static_cast<unsigned>(bytes >> (8 * (choice & 7U))) & 0xffU};
    if ((choice & 8U) != 0) byte = (byte & 0x80U) != 0 ? 0xffU : 0U;
    result |= byte << (8 * i);
  }
  return result;
}
inline unsigned __funnelshift_r(unsigned low, unsigned high, unsigned shift) {
  return static_cast<unsigned>((static_cast<std::uint64_t>(high) << 32 | low) >> (shift & 31U));
}

// As CUDA has them in the global namespace.
inline int min(int a, int b) {
  return b < a ? b : a;
}
inline int max(int a, int b) {
  return a < b ? b : a;
}
inline unsigned min(unsigned a, unsigned b) {
  return b < a ? b : a;
}
inline unsigned max(unsigned a, unsigned b) {
  return a < b ? b : a;
}
