// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "http/target.hpp"

#include <algorithm>

namespace stereogrid::server {
namespace {

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

bool is_control(char c) {
  return static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
}

/// None: '%' without two digits, or a control character, encoded or not.
std::optional<std::string> decoded(std::string_view text) {
  std::string result;
  for (std::size_t i{0}; i < text.size(); ++i) {
    char c{text[i]};
    if (c == '%') {
      if (text.size() - i < 3) return std::nullopt;
      const int high{hex_digit(text[i + 1])};
      const int low{hex_digit(text[i + 2])};
      if (high < 0 || low < 0) return std::nullopt;
      c = static_cast<char>(16 * high + low);
      i += 2;
    }
    if (is_control(c)) return std::nullopt;
    result.push_back(c);
  }
  return result;
}

/// Calls `take` for each part between the separators, until it says no.
template <class Take>
bool split(std::string_view text, char separator, Take&& take) {
  for (std::size_t start{0}; start <= text.size();) {
    const std::size_t end{std::min(text.find(separator, start), text.size())};
    if (!take(text.substr(start, end - start), end == text.size())) return false;
    start = end + 1;
  }
  return true;
}

bool append_segment(std::string_view segment, bool last, std::string& path) {
  const auto name{decoded(segment)};
  if (!name || *name == "." || *name == ".." || name->find('/') != std::string::npos) return false;
  if (name->empty() && !last) return false;
  path += "/" + *name;
  return true;
}

bool append_pair(std::string_view pair, Target& target) {
  if (pair.empty()) return true;
  const std::size_t equals{std::min(pair.find('='), pair.size())};
  const auto name{decoded(pair.substr(0, equals))};
  const auto value{decoded(pair.substr(std::min(equals + 1, pair.size())))};
  if (!name || !value) return false;
  target.query.emplace_back(*name, *value);
  return true;
}

}  // namespace

const std::string* Target::find(std::string_view name) const {
  const auto found{std::ranges::find(query, name, [](const auto& pair) { return std::string_view{pair.first}; })};
  return found == query.end() ? nullptr : &found->second;
}

std::optional<Target> parse_target(std::string_view text) {
  if (!text.starts_with('/') || text.find('#') != std::string_view::npos) return std::nullopt;
  const std::size_t mark{std::min(text.find('?'), text.size())};
  Target target;
  const bool path_fine{split(text.substr(1, mark - 1), '/', [&](std::string_view segment, bool last) {
    return append_segment(segment, last, target.path);
  })};
  const bool query_fine{mark == text.size() || split(text.substr(mark + 1), '&', [&](std::string_view pair, bool) {
                          return append_pair(pair, target);
                        })};
  if (!path_fine || !query_fine) return std::nullopt;
  return target;
}

}  // namespace stereogrid::server
