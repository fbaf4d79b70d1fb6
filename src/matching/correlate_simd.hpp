// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "matching/matching.hpp"

namespace stereogrid {

/// One band of rows of `correlate`.
struct Band {
  View<const std::uint32_t> left;
  View<const std::uint32_t> right;
  Shifts shifts;
  int half_window{0};
  int left_right_px{0};
  int first_row{0};
  int end_row{0};
  std::uint8_t* memory{nullptr};  ///< correlate_memory() bytes, 64-byte aligned
  View<Candidate> candidates;
};

/// Bytes that a band works in.
std::size_t correlate_memory(int width, Shifts shifts, int half_window);

/// Fills the band's rows of `candidates`, bit-equal to the reference on every instruction set.
void correlate_band(const Band& band);

/// Name of the instruction set that correlate_band uses on this machine.
std::string_view correlate_target();

}  // namespace stereogrid
