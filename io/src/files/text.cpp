// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/text.hpp"

#include <cstdint>

#include "stereogrid/io/json_text.hpp"

namespace stereogrid::io {

std::string frame_name(std::string_view text) {
  return printable(text, std::string::npos);
}

std::string printable_path(const std::filesystem::path& path) {
  return printable(path.native(), std::string::npos);
}

bool is_nested_too_deeply(std::string_view json) {
  constexpr int most{64};
  int depth{0};
  bool within_text{false};
  for (std::size_t i{0}; i < json.size(); ++i) {
    const char c{json[i]};
    if (c == '"') {
      within_text = !within_text;
    } else if (within_text) {
      if (c == '\\') ++i;  // skips an escaped character, such as a quotation mark
    } else if (c == '[' || c == '{') {
      if (++depth > most) return true;
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return false;
}

std::string base64(std::string_view bytes) {
  static constexpr std::string_view letters{"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/"};
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i{0}; i < bytes.size(); i += 3) {
    std::uint32_t word{0};
    for (std::size_t j{0}; j < 3; ++j) word = word << 8 | (i + j < bytes.size() ? std::uint8_t(bytes[i + j]) : 0);
    for (int shift{18}; shift >= 0; shift -= 6) text += letters[word >> shift & 63];
  }
  if (bytes.size() % 3 != 0) text.replace(text.size() - (3 - bytes.size() % 3), 2, bytes.size() % 3 == 1 ? "==" : "=");
  return text;
}

}  // namespace stereogrid::io
