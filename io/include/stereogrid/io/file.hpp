// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace stereogrid::io {

/// The whole file. Throws InputError: missing, a folder, not readable.
[[nodiscard]] std::string read_file(const std::filesystem::path& path);

/// Writes the file under a temporary name beside it and renames it, so that a file of this name is always whole.
/// Throws DeviceError: disk full, no such folder, not writable.
void write_file(const std::filesystem::path& path, std::string_view bytes);

/// Creates the folder and its parents. Throws DeviceError.
void create_folder(const std::filesystem::path& path);

}  // namespace stereogrid::io
