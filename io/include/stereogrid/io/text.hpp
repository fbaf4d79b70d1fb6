// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "stereogrid/export.hpp"
#include "stereogrid/printable.hpp"

namespace stereogrid::io {

using stereogrid::printable;

/// The name of a frame from that of its file, or from a list of names: printable and whole.
[[nodiscard]] STEREOGRID_EXPORT std::string frame_name(std::string_view text);

/// Printable path, never shortened.
[[nodiscard]] STEREOGRID_EXPORT std::string printable_path(const std::filesystem::path& path);

/// Base64 of RFC 4648, with padding.
[[nodiscard]] STEREOGRID_EXPORT std::string base64(std::string_view bytes);

}  // namespace stereogrid::io
