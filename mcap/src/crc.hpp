// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <zlib.h>

#include <cstdint>

#include "format.hpp"

namespace stereogrid::mcap {

/// CRC-32 of bytes that follow others whose CRC-32 is `before`.
inline std::uint32_t crc_of(View bytes, std::uint32_t before = 0) {
  if (bytes.empty()) return before;  // zlib takes no bytes at no address for a new beginning
  return static_cast<std::uint32_t>(::crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

/// CRC-32 of two parts one after the other, from their own.
inline std::uint32_t joined_crc(std::uint32_t first, std::uint32_t second, std::uint64_t second_bytes) {
  return static_cast<std::uint32_t>(::crc32_combine(first, second, static_cast<z_off_t>(second_bytes)));
}

}  // namespace stereogrid::mcap
