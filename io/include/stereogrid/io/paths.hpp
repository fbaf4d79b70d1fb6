// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "stereogrid/export.hpp"

// Queries of paths; symbolic links are followed. A missing path is an answer. All functions throw as read_file():
// DeviceError where the failure is_temporary(), so that a file system that is away is not taken for a missing file;
// else InputError. Functions of std::filesystem throw one exception for both, or ignore both.
namespace stereogrid::io {

/// Returns false for the errno of a wrong path or a missing permission. True: a retry may succeed (EIO, ESTALE, EMFILE
/// and all others).
[[nodiscard]] STEREOGRID_EXPORT bool is_temporary(int error_number);

/// Throws after a failed system call on a path: DeviceError where is_temporary(), else InputError.
[[noreturn]] STEREOGRID_EXPORT void throw_unreadable(const std::filesystem::path& path, int error_number);

/// True for files and folders of any kind.
[[nodiscard]] STEREOGRID_EXPORT bool is_there(const std::filesystem::path& path);
/// True for folders.
[[nodiscard]] STEREOGRID_EXPORT bool is_folder(const std::filesystem::path& path);
/// True for regular files.
[[nodiscard]] STEREOGRID_EXPORT bool is_file(const std::filesystem::path& path);
/// Returns false for a missing folder.
[[nodiscard]] STEREOGRID_EXPORT bool has_entries(const std::filesystem::path& folder);

/// Paths in a folder, sorted. Throws if there is no such folder.
[[nodiscard]] STEREOGRID_EXPORT std::vector<std::filesystem::path> entries_of(const std::filesystem::path& folder);

/// First bytes of a regular file, to recognise its format; "" for anything else, and where it may not be read.
[[nodiscard]] STEREOGRID_EXPORT std::string first_bytes(const std::filesystem::path& path, std::size_t most);

/// Calls `work` and throws as above where std::filesystem has failed in it.
template <class Work>
auto with_path_errors(Work work) {
  try {
    return work();
  } catch (const std::filesystem::filesystem_error& error) {
    throw_unreadable(error.path1(), error.code().value());
  }
}

}  // namespace stereogrid::io
