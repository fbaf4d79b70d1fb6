// SPDX-License-Identifier: Apache-2.0
#include "filter/joint/blocks.cuh"

namespace stereogrid {
namespace {

constexpr int threads{256};

// Slots for the blocks that want one, in their order; by one block of threads.
__device__ void number_wanted(int* slots, int count, int capacity) {
  __shared__ int ranks[threads];
  const int tid{static_cast<int>(threadIdx.x)};
  const int used_before{slots[count]};
  int used{used_before};
  __syncthreads();
  for (int base{0}; base < count; base += threads) {
    const int i{base + tid};
    const bool wants{i < count && slots[i] == slot_wanted};
    ranks[tid] = wants ? 1 : 0;
    __syncthreads();
    for (int apart{1}; apart < threads; apart *= 2) {
      const int before{tid >= apart ? ranks[tid - apart] : 0};
      __syncthreads();
      ranks[tid] += before;
      __syncthreads();
    }
    const int slot{used + ranks[tid] - 1};
    if (wants) slots[i] = slot < capacity ? slot : -1;
    used = Min(used + ranks[threads - 1], capacity);
    __syncthreads();
  }
  if (tid == 0) {
    slots[count] = used;
    slots[count + 1] = used_before;
  }
}

__global__ void allocate_marked(int* slots, int count, int capacity) {
  number_wanted(slots, count, capacity);
}

__global__ void begin_reached(const FilterMotion* motion, const CellBox* moving, int cells, int* slots, int capacity) {
  const BlockLayout layout{cells};
  const int count{layout.count()};
  const int tid{static_cast<int>(threadIdx.x)};
  for (int i{tid}; i < count; i += threads) slots[i] = -1;
  if (tid == 0) slots[count] = 0;
  __syncthreads();
  for (int i{tid}; i < count; i += threads) {
    if (moving[i].is_empty()) continue;
    const CellBox reached{reached_blocks(motion->step, moving[i], motion->moved_x, motion->moved_y, cells)};
    for (int y{reached.y_first}; y <= reached.y_last; ++y) {
      for (int x{reached.x_first}; x <= reached.x_last; ++x) slots[y * layout.across + x] = slot_wanted;
    }
  }
  __syncthreads();
  number_wanted(slots, count, capacity);
}

}  // namespace

void allocate_marked_blocks(Cuda& cuda, const FilterOnDevice& filter, FilterStateOnDevice& state) {
  launch(cuda, allocate_marked, 1, threads, 0, state.slots.data(), static_cast<int>(state.slots.size()) - 2,
         filter.capacity);
}

void begin_reached_blocks(Cuda& cuda, const FilterOnDevice& filter, const FilterMotion* motion,
                          FilterStateOnDevice& state) {
  launch(cuda, begin_reached, 1, threads, 0, motion, filter.moving.data(), state.occupancy.width(), state.slots.data(),
         filter.capacity);
}

}  // namespace stereogrid
