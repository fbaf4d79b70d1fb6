// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "input/recording_images.hpp"
#include "stereogrid/io/recording.hpp"

namespace stereogrid::io {

/// The part of an image of this size that a camera has.
[[nodiscard]] Size size_of_part(Size whole, ImageLayout layout);

/// Layout of images of both cameras with this size: as `wanted`, else by the calibration, else by the aspect ratio.
/// `calibration` empty: none. Throws InputError: no layout, or several.
[[nodiscard]] ImageLayout find_layout(Size whole, std::optional<ImageLayout> wanted,
                                      const std::filesystem::path& calibration, const std::filesystem::path& images);

}  // namespace stereogrid::io
