// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include "stereogrid/export.hpp"

namespace stereogrid::io {

/// Maximum size of a file of each kind, and of the data that a compressed one declares, in bytes. Far above the sizes
/// of valid files.
namespace largest_bytes {
constexpr std::size_t mebi{std::size_t{1} << 20};
constexpr std::size_t settings{mebi};       ///< YAML: parsing more takes seconds
constexpr std::size_t calibration{mebi};    ///< KITTI's too; and records of GPS/IMU
constexpr std::size_t lines{1024 * mebi};   ///< frames.txt, times and poses: a line per frame
constexpr std::size_t image{512 * mebi};    ///< disparities too; and its pixels at 8 bytes each
constexpr std::size_t sweep{512 * mebi};    ///< sweep of a lidar
constexpr std::size_t array{512 * mebi};    ///< .npy, and each array of an .npz
constexpr std::size_t arrays{1024 * mebi};  ///< an .npz, and all of its arrays
constexpr std::size_t json{16384 * mebi};   ///< run.json, frames.jsonl, truth
}  // namespace largest_bytes

/// Reads a whole file. Throws InputError: missing, a folder, a device, FIFO or socket, not readable, larger than
/// `most_bytes`, truncated during the read. Throws DeviceError if the failure is_temporary() (paths.hpp).
[[nodiscard]] STEREOGRID_EXPORT std::string read_file(const std::filesystem::path& path,
                                                      std::size_t most_bytes = largest_bytes::array);

/// Reads a text file without the byte-order mark of UTF-8. Throws as read_file().
[[nodiscard]] STEREOGRID_EXPORT std::string read_text(const std::filesystem::path& path, std::size_t most_bytes);

/// Writes the file under a temporary name beside it and renames it, so that a file of this name is always complete.
/// A symbolic link remains, and its target is written. A replaced file keeps its permissions. Devices, FIFOs and
/// sockets are written directly. Throws DeviceError: disk full, no such folder, not writable, a folder of this name.
STEREOGRID_EXPORT void write_file(const std::filesystem::path& path, std::string_view bytes);

enum class DeflateForm {
  raw,   ///< RFC 1951
  zlib,  ///< RFC 1950: with a header and a checksum
};

/// Compressed in one piece. Noise grows by 5 bytes per 64 KiB. Throws std::length_error from 4 GiB on.
[[nodiscard]] STEREOGRID_EXPORT std::string deflate(std::string_view bytes, DeflateForm form);

/// Creates the folder and its parents. Throws DeviceError.
STEREOGRID_EXPORT void create_folder(const std::filesystem::path& path);

}  // namespace stereogrid::io
