// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "filter/cuda.hpp"

namespace stereogrid {

/// Index of a cell in [slot][k][cell of the block].
STEREOGRID_HD inline std::size_t mass_index(int slot, int velocities, int k, int x, int y) {
  return (static_cast<std::size_t>(slot) * velocities + k) * block_cells + y % block_rows * block_columns +
         x % block_columns;
}

/// Pointers of kernels to a state of FilterModel::joint.
struct JointPointers {
  float* mass;
  int* slots;
  float* scale;
  float* birth_static;
  float* birth_moving;
  float* occupancy;
  float* standing;
  float* age_s;
};

inline JointPointers joint_pointers(const FilterStateOnDevice& state) {
  const auto of = [](const auto& buffer) { return const_cast<float*>(buffer.data()); };
  return {of(state.mass),         const_cast<int*>(state.slots.data()),
          of(state.scale),        of(state.birth_static),
          of(state.birth_moving), of(state.occupancy),
          of(state.standing),     of(state.age_s)};
}

/// MovingBlocks::allocate_marked.
void allocate_marked_blocks(Cuda& cuda, const FilterOnDevice& filter, FilterStateOnDevice& state);
/// MovingBlocks::begin, from `filter.moving`.
void begin_reached_blocks(Cuda& cuda, const FilterOnDevice& filter, const FilterMotion* motion,
                          FilterStateOnDevice& state);

/// A step of FilterModel::joint.
void filter_joint(Cuda& cuda, FilterOnDevice& filter, const FilterMotion* motion, View<const float, Device> observed,
                  const FilterStateOnDevice& before, FilterStateOnDevice& after, LayersOnDevice& layers);

}  // namespace stereogrid
