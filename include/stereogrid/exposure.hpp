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

/// Grey level of one image for each grey level of another one.
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

/// True where the exposures differ by so much that it costs matches (the brighter image is saturated where the other
/// one is not) or tracked features. False where one image is black.
[[nodiscard]] STEREOGRID_EXPORT bool is_unequal(const Exposure& exposure);

/// Names the brighter image, the difference and the remedy; rounded, so that the frames of a drive give few texts.
/// FrameResult::warnings has it of frames with unequal exposures. FrameStatus has no flag for them: what matches is
/// reliable all the same.
[[nodiscard]] STEREOGRID_EXPORT std::string text_of(const Exposure& exposure);

/// Ends that text.
inline constexpr std::string_view exposure_remedy{"set both cameras to the same exposure"};

}  // namespace stereogrid
