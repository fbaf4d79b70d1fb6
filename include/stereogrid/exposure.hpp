// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "stereogrid/export.hpp"

namespace stereogrid {

/// Number of pixels with each grey level.
using GreyCounts = std::array<int, 256>;

/// Lookup table from the grey levels of one image to those of another.
using GreyTransfer = std::array<std::uint8_t, 256>;

/// Maps a grey level to that of the same rank in the other image (histogram matching). Both images show the same scene,
/// so the map is the difference of their exposures, whatever its form.
[[nodiscard]] STEREOGRID_EXPORT GreyTransfer transfer_of(const GreyCounts& from, const GreyCounts& to);

/// Exposure of a pair of images.
struct Exposure {
  double gain{1};             ///< brightness of the right image relative to that of the left one
  double left_saturated{0};   ///< share of its pixels
  double right_saturated{0};  ///< share of its pixels
};
/// Exposure of a pair of images from their grey levels.
[[nodiscard]] STEREOGRID_EXPORT Exposure exposure_of(const GreyCounts& left, const GreyCounts& right);

/// True if the difference of the exposures costs matches (the brighter image is saturated where the other one is not)
/// or tracked features. False if one image is black.
[[nodiscard]] STEREOGRID_EXPORT bool is_unequal(const Exposure& exposure);

/// Message with the brighter image, the difference and the remedy; rounded, so that the frames of a drive have few
/// messages. FrameResult::warnings contains it for frames with unequal exposures, without a status: the remaining
/// matches are reliable.
[[nodiscard]] STEREOGRID_EXPORT std::string text_of(const Exposure& exposure);

/// End of that message.
inline constexpr std::string_view exposure_remedy{"set both cameras to the same exposure"};

}  // namespace stereogrid
