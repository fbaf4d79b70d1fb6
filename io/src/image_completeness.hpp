// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace stereogrid::io {

/// Makes an image file's bytes safe to decode: throws InputError(file, …) where they are no PNG, PNM or JPEG, or are
/// truncated or damaged, as far as the format lets one see that (PNG: every checksum; JPEG: the end marker; PNM: the
/// number of pixels). Decoders fill what is missing with grey and complain on stderr instead. Chunks of a PNG that do
/// not matter for the pixels are dropped, since libpng warns of odd ones.
[[nodiscard]] std::string checked_image_bytes(const std::string& file, std::string bytes);

}  // namespace stereogrid::io
