// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "http/range.hpp"

#include <algorithm>
#include <charconv>

namespace stereogrid::server {
namespace {

/// None: empty, not of digits, or too large.
std::optional<std::uint64_t> number(std::string_view digits) {
  std::uint64_t value{0};
  const auto [end, error]{std::from_chars(digits.data(), digits.data() + digits.size(), value)};
  if (digits.empty() || error != std::errc{} || end != digits.data() + digits.size()) return std::nullopt;
  return value;
}

}  // namespace

std::optional<ByteRange> parse_range(std::string_view header, std::uint64_t size) {
  constexpr std::string_view unit{"bytes="};
  if (!header.starts_with(unit)) return std::nullopt;
  header.remove_prefix(unit.size());
  const std::size_t dash{header.find('-')};
  if (dash == std::string_view::npos) return std::nullopt;
  const std::string_view first{header.substr(0, dash)};
  const std::string_view last{header.substr(dash + 1)};
  if (first.empty()) {
    const auto count{number(last)};
    if (!count) return std::nullopt;
    return ByteRange{size - std::min(*count, size), size};
  }
  const auto begin{number(first)};
  const auto end{last.empty() ? std::optional{size} : number(last)};
  if (!begin || !end || (!last.empty() && *end < *begin)) return std::nullopt;
  if (*begin >= size) return ByteRange{size, size};
  return ByteRange{*begin, last.empty() ? size : std::min(*end, size - 1) + 1};
}

bool matches_etag(std::string_view header, std::string_view etag) {
  for (std::size_t start{0}; start < header.size();) {
    const std::size_t end{std::min(header.find(',', start), header.size())};
    std::string_view one{header.substr(start, end - start)};
    one.remove_prefix(std::min(one.find_first_not_of(' '), one.size()));
    if (one.starts_with("W/")) one.remove_prefix(2);
    one = one.substr(0, one.find_last_not_of(' ') + 1);
    if (one == etag || one == "*") return true;
    start = end + 1;
  }
  return false;
}

}  // namespace stereogrid::server
