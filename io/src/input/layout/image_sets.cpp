// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "input/layout/input_layout.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "input/layout/side_names.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {

namespace fs = std::filesystem;

// A frame's files are named after it: NAME.npz has to be a name that a file can have.
void check_length(const fs::path& file, const std::string& name) {
  constexpr std::size_t longest{251};
  if (name.size() <= longest) return;
  throw InputError{printable_path(file),
                   fmt::format("the name of the frame has {} bytes, more than {}.", name.size(), longest),
                   "Give the frame's files a shorter name."};
}

Images images_in(const fs::path& folder, const std::set<std::string>& extensions) {
  Images images;
  for (const fs::path& entry : entries_of(folder)) {
    std::string extension{entry.extension().string()};
    std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return std::tolower(c); });
    const std::string stem{entry.stem().string()};
    if (!extensions.contains(extension) || stem.starts_with('.')) continue;
    const std::string name{frame_name(stem)};
    check_length(entry, name);
    if (!images.emplace(name, entry).second) {
      throw InputError{printable_path(entry), "there is another image of the same name in this folder.",
                       "Keep one image for each name."};
    }
  }
  return images;
}

std::optional<NamedSides> split_by_name(const Images& left, const Images& right) {
  std::vector<std::string> names;
  for (const auto& image : left) names.push_back(image.first);
  for (const SideWords& words : all_side_words) {
    if (are_counted(names, words)) continue;
    NamedSides found;
    bool is_pair{false};
    const auto add{[](Images& to, const auto& image, std::string_view word) {
      if (auto rest{without_word(image.first, word)}) to.emplace(rest->empty() ? "000000" : *rest, image.second);
    }};
    for (const auto& image : left) add(found.left, image, words.left);
    for (const auto& image : right) {
      add(found.right, image, words.right);
      const auto rest{without_word(image.first, words.right)};
      is_pair = is_pair || (rest && found.left.contains(rest->empty() ? "000000" : *rest));
    }
    if (is_pair) return found;
  }
  return std::nullopt;
}

}  // namespace stereogrid::io
