// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "stereogrid/image.hpp"

namespace stereogrid::io {

/// Decodes RVL (Wilson, ISS 2017) as compressed_depth_image_transport writes it: width and height, 32 bits each, then
/// runs of zeros and of differences in words of eight nibbles. Throws InputError: damaged.
[[nodiscard]] Image<std::uint16_t> decode_rvl(std::span<const std::byte> bytes, const std::string& name);

}  // namespace stereogrid::io
