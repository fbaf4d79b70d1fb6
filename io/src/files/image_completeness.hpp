// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace stereogrid::io {

/// Makes an image file's bytes safe to decode: throws InputError(file, …) where they are no PNG, PNM, JPEG, WebP or
/// TIFF, or are truncated or damaged, as far as the format lets one see that (PNG: every checksum; JPEG: the end
/// marker; PNM: the number of pixels), or say that they have more pixels than an image may (JPEG: or more than 32
/// scans, each of which takes the time of an image). Decoders fill what is missing with grey and complain on stderr
/// instead. Chunks of a PNG that do not matter for the pixels are dropped, since libpng warns of odd ones.
[[nodiscard]] std::string checked_image_bytes(const std::string& file, std::string bytes);

/// The same bound on the pixels of a TIFF; its decoder finds the rest. Throws InputError(file, …).
void check_tiff_size(const std::string& file, std::string_view bytes);

}  // namespace stereogrid::io
