// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/words.hpp"

#include <fmt/format.h>

#include "stereogrid/error.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::app::batch {
namespace {

bool is_name(std::string_view text) {
  return !text.empty() && text.find_first_not_of("abcdefghijklmnopqrstuvwxyz_") == std::string_view::npos;
}

std::string filled_in(std::string_view word, const std::map<std::string, std::string>& values) {
  std::string filled;
  while (!word.empty()) {
    const std::size_t open{std::min(word.find('{'), word.size())};
    const std::size_t close{word.find('}', open)};
    filled += word.substr(0, open);
    word.remove_prefix(open);
    if (close == std::string_view::npos || !is_name(word.substr(1, close - open - 1))) {
      filled += word.substr(0, 1);
      word.remove_prefix(std::min<std::size_t>(1, word.size()));
      continue;
    }
    const std::string name{word.substr(1, close - open - 1)};
    const auto value{values.find(name)};
    if (value == values.end()) {
      std::string known;
      for (const auto& [key, unused] : values) known += fmt::format("{}{{{}}}", known.empty() ? "" : ", ", key);
      throw ConfigError{fmt::format("{{{}}}: there is no such thing to fill in. There are: {}.", name, known)};
    }
    filled += value->second;
    word.remove_prefix(close - open + 1);
  }
  return filled;
}

}  // namespace

std::vector<std::string> words_of(std::string_view command) {
  std::vector<std::string> words;
  bool within_word{false};
  char quotation{0};
  for (const char c : command) {
    if (quotation != 0) {
      c == quotation ? static_cast<void>(quotation = 0) : words.back().push_back(c);
    } else if (c == ' ' || c == '\t' || c == '\n') {
      within_word = false;
    } else {
      if (!within_word) words.emplace_back();
      within_word = true;
      c == '\'' || c == '"' ? static_cast<void>(quotation = c) : words.back().push_back(c);
    }
  }
  if (quotation != 0) {
    throw ConfigError{
        fmt::format("{}: a quotation mark ({}) is missing.", io::printable(std::string{command}), quotation)};
  }
  if (words.empty() || words.front().empty()) throw ConfigError{"a command is empty: it needs a program."};
  return words;
}

std::vector<std::string> filled_in(std::vector<std::string> words, const std::map<std::string, std::string>& values) {
  for (std::string& word : words) word = filled_in(std::string_view{word}, values);
  return words;
}

}  // namespace stereogrid::app::batch
