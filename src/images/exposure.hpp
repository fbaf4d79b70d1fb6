// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace stereogrid {

/// Number of pixels with each grey level.
using GreyCounts = std::array<int, 256>;

/// Grey level of the right image for each grey level of the left one: that of the same rank (histogram matching). Both
/// images show the same scene, so this is the difference of their exposures, whatever its form.
using GreyTransfer = std::array<std::uint8_t, 256>;
GreyTransfer transfer_of(const GreyCounts& left, const GreyCounts& right);

/// Exposure of a pair of images.
struct Exposure {
  double gain{1};             ///< brightness of the right image relative to that of the left one
  double left_saturated{0};   ///< share of its pixels
  double right_saturated{0};  ///< share of its pixels
};
Exposure exposure_of(const GreyCounts& left, const GreyCounts& right);

/// True where the exposures differ by so much that it costs matches (the brighter image is saturated where the other
/// one is not) or tracked features. False where one image is black.
bool is_unequal(const Exposure& exposure);

/// Names the brighter image, the difference and the remedy; rounded, so that the frames of a drive give few texts.
std::string text_of(const Exposure& exposure);

}  // namespace stereogrid
