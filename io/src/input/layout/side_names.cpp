// SPDX-License-Identifier: Apache-2.0
#include "input/layout/side_names.hpp"

#include <algorithm>
#include <cctype>
#include <map>

namespace stereogrid::io {
namespace {

std::string lower(std::string_view text) {
  std::string result{text};
  std::ranges::transform(result, result.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return result;
}

bool is_separator(char c) {
  return c == '_' || c == '-' || c == '.' || c == ' ';
}

/// A word of one letter stands between other characters than letters, one with a number is not a part of a longer one.
bool stands_alone(std::string_view name, std::size_t place, std::string_view word) {
  const auto is_letter{[](char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; }};
  const auto is_digit{[](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }};
  const std::size_t end{place + word.size()};
  if (place > 0 && is_letter(name[place - 1])) return false;
  if (end == name.size()) return true;
  return !is_letter(name[end]) && !(is_digit(word.back()) && is_digit(name[end]));
}

}  // namespace

std::optional<std::string> without_word(std::string_view original, std::string_view word) {
  const std::string name{lower(original)};
  const bool may_be_part{word.size() > 3 && !std::isdigit(static_cast<unsigned char>(word.back()))};
  for (std::size_t place{name.rfind(word)}; place != std::string::npos; place = name.rfind(word, place - 1)) {
    if (may_be_part || stands_alone(name, place, word)) {
      std::size_t begin{place};
      std::size_t end{place + word.size()};
      if (begin > 0 && is_separator(name[begin - 1])) {
        --begin;
      } else if (end < name.size() && is_separator(name[end])) {
        ++end;
      }
      return name.substr(0, begin) + name.substr(end);
    }
    if (place == 0) break;
  }
  return std::nullopt;
}

bool are_counted(const std::vector<std::string>& names, const SideWords& words) {
  const auto is_digit{[](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }};
  if (!is_digit(words.left.back()) || words.right.back() - words.left.back() != 1) return false;
  const std::string stem{words.left.substr(0, words.left.size() - 1)};
  return std::ranges::any_of(names, [&](const std::string& name) {
    if (without_word(name, words.left) || without_word(name, words.right)) return false;
    const std::size_t place{lower(name).rfind(stem)};
    return place != std::string::npos && place + stem.size() < name.size() && is_digit(name[place + stem.size()]);
  });
}

namespace {

std::optional<SideFolders> side_folders(const std::vector<std::filesystem::path>& folders, const SideWords& words) {
  std::map<std::string, std::filesystem::path> left;
  for (const auto& folder : folders) {
    if (const auto rest{without_word(folder.filename().string(), words.left)}) left.emplace(*rest, folder);
  }
  for (const auto& folder : folders) {
    const auto rest{without_word(folder.filename().string(), words.right)};
    if (rest && left.contains(*rest)) return SideFolders{left[*rest], folder};
  }
  return std::nullopt;
}

}  // namespace

std::optional<SideFolders> side_folders(const std::vector<std::filesystem::path>& folders) {
  for (const SideWords& words : all_side_words) {
    if (auto found{side_folders(folders, words)}) return found;
  }
  return side_folders(folders, numbered_folders);
}

}  // namespace stereogrid::io
