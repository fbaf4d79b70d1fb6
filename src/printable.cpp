// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/printable.hpp"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

namespace stereogrid {
namespace {

struct Range {
  std::uint8_t first, last;
  [[nodiscard]] bool holds(std::uint8_t byte) const { return byte >= first && byte <= last; }
};

/// First bytes of characters of several bytes (RFC 3629); the others are 80 … BF.
struct Form {
  Range lead, second;
  std::size_t bytes;
};
constexpr Form forms[]{{{0xc2, 0xdf}, {0x80, 0xbf}, 2}, {{0xe0, 0xe0}, {0xa0, 0xbf}, 3},
                       {{0xe1, 0xec}, {0x80, 0xbf}, 3}, {{0xed, 0xed}, {0x80, 0x9f}, 3},
                       {{0xee, 0xef}, {0x80, 0xbf}, 3}, {{0xf0, 0xf0}, {0x90, 0xbf}, 4},
                       {{0xf1, 0xf3}, {0x80, 0xbf}, 4}, {{0xf4, 0xf4}, {0x80, 0x8f}, 4}};

std::uint8_t byte_at(std::string_view text, std::size_t i) {
  return static_cast<std::uint8_t>(text[i]);
}

/// Bytes of the character that the text begins with; 0: none that may be shown.
std::size_t bytes_of_character(std::string_view text) {
  const std::uint8_t lead{byte_at(text, 0)};
  if (lead < 0x80) return lead >= 0x20 && lead != 0x7f ? 1 : 0;
  for (const Form& form : forms) {
    if (!form.lead.holds(lead)) continue;
    if (text.size() < form.bytes || !form.second.holds(byte_at(text, 1))) return 0;
    for (std::size_t i{2}; i < form.bytes; ++i) {
      if (!Range{0x80, 0xbf}.holds(byte_at(text, i))) return 0;
    }
    const bool is_control{lead == 0xc2 && byte_at(text, 1) < 0xa0};  // U+0080 … U+009F: some terminals obey them
    return is_control ? 0 : form.bytes;
  }
  return 0;
}

std::string number_of(std::uint8_t byte) {
  constexpr char digits[]{"0123456789ABCDEF"};
  return {'\\', 'x', digits[byte / 16], digits[byte % 16]};
}

}  // namespace

std::string printable(std::string_view text, std::size_t longest_bytes) {
  std::string shown;
  while (!text.empty()) {
    const std::size_t bytes{bytes_of_character(text)};
    const std::string character{bytes > 0 ? std::string{text.substr(0, bytes)} : number_of(byte_at(text, 0))};
    if (shown.size() + character.size() > longest_bytes) return shown + "…";
    shown += character;
    text.remove_prefix(bytes > 0 ? bytes : 1);
  }
  return shown;
}

std::string printable_lines(std::string_view text, std::size_t longest_bytes) {
  std::string shown;
  for (;;) {
    const std::size_t end{std::min(text.find('\n'), text.size())};
    shown += printable(text.substr(0, end), longest_bytes - shown.size());
    text.remove_prefix(end);
    if (text.empty() || shown.size() >= longest_bytes) return shown;
    shown += '\n';
    text.remove_prefix(1);
  }
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i{0}; i < a.size(); ++i) {
    std::size_t diagonal{row[0]};
    row[0] = i + 1;
    for (std::size_t j{0}; j < b.size(); ++j) {
      const std::size_t replaced{diagonal + (a[i] == b[j] ? 0 : 1)};
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

}  // namespace stereogrid
