// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace stereogrid::server {

struct ByteRange {
  std::uint64_t begin;
  std::uint64_t end;  ///< one past the last; begin == end: nothing of the file is in the range
};

/// The range of a header Range (RFC 9110, 14.2). None: there is none, several, or one that is not understood, so that
/// all is sent.
[[nodiscard]] std::optional<ByteRange> parse_range(std::string_view header, std::uint64_t size);

/// Whether a header If-None-Match names it.
[[nodiscard]] bool matches_etag(std::string_view header, std::string_view etag);

}  // namespace stereogrid::server
