// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace stereogrid::io {

enum class DeflateForm {
  raw,   ///< RFC 1951
  zlib,  ///< RFC 1950: with a header and a checksum
};

/// Compressed in one piece. Noise grows by 5 bytes per 64 KiB. Throws std::length_error from 4 GiB on.
std::string deflate(std::string_view bytes, DeflateForm form);

/// Fills `bytes`; false if `packed` is no zlib stream, is damaged, or holds less or more.
bool inflate_zlib(std::string_view packed, std::span<std::uint8_t> bytes);

/// CRC-32 of zip and PNG.
std::uint32_t crc32_of(std::string_view bytes);

}  // namespace stereogrid::io
