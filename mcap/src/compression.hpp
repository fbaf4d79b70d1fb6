// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <zlib.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

#include "format.hpp"
#include "stereogrid/mcap/writer.hpp"

namespace stereogrid::mcap {

/// As a chunk names it.
[[nodiscard]] std::string_view name_of(Compression compression);
/// none: an unknown name.
[[nodiscard]] std::optional<Compression> compression_of(std::string_view name);

class Compressor {
 public:
  explicit Compressor(Compression compression);
  ~Compressor();

  /// The bytes compressed, valid until the next call; the same ones without compression.
  View compress(View bytes);

 private:
  struct Zstd;
  Compression compression_;
  std::unique_ptr<Zstd> zstd_;
  Bytes buffer_;
};

/// Unpacks lz4 or zstd into `out`, of which it makes no more than `most` bytes, and no more than really come. Throws
/// Malformed.
void decompress(Compression compression, View packed, std::uint64_t most, Bytes& out);

/// Unpacked size in the header of a zstd frame; none: not stated.
[[nodiscard]] std::optional<std::uint64_t> zstd_content_size(View packed);

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
