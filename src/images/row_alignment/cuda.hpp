// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "backend/cuda.hpp"
#include "images/row_alignment/row_alignment.hpp"

namespace stereogrid {

/// Vertical misalignment of the right image by `offsets`, unless negligible.
struct RowShift {
  RowOffsets offsets;
  int is_identity{1};
};

/// `align_rows` of alignment.hpp, equal to the CPU to the bit; a copy where the shift is the identity. `shift` is on
/// the device.
void align_rows(Cuda& cuda, View<const std::uint8_t, Device> right, const RowShift* shift,
                View<std::uint8_t, Device> aligned);

/// Disparities at the pixels of a MatchLattice: of the obstacle, or minus that of the road, or 0.
void gather_lattice(Cuda& cuda, View<const float, Device> obstacle, View<const float, Device> road,
                    View<float, Device> lattice);

}  // namespace stereogrid
