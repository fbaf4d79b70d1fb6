// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace stereogrid::io {

/// Returns bytes that are safe to decode: decoders fill missing parts with grey and print to stderr. Throws
/// InputError(file, …): no PNG, PNM, JPEG, WebP or TIFF; truncated or damaged (PNG: checksums, JPEG: end marker, PNM:
/// number of pixels); too many pixels; a JPEG of more than 32 scans, each of which costs the time of an image. Chunks
/// of a PNG without influence on the pixels are removed, since libpng prints warnings about some.
[[nodiscard]] std::string checked_image_bytes(const std::string& file, std::string bytes);

/// The same bound on the pixels of a TIFF; its decoder finds the rest. Throws InputError(file, …).
void check_tiff_size(const std::string& file, std::string_view bytes);

}  // namespace stereogrid::io
