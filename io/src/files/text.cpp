// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/text.hpp"

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

}  // namespace stereogrid::io
