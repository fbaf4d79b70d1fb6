// SPDX-License-Identifier: Apache-2.0
#include "input/calibration/forms/opencv_names.hpp"

#include <algorithm>
#include <cctype>

namespace stereogrid::io::opencv {
namespace {

constexpr std::string_view group_words[]{"stereo",     "calibration", "calib",        "extrinsics", "extrinsic",
                                         "intrinsic",  "intrinsics",  "stereoparams", "params",     "cameras",
                                         "parameters", "results",     "data"};

std::string lower(std::string_view key) {
  std::string text;
  for (const unsigned char letter : key) {
    if (std::isalnum(letter) != 0) text += static_cast<char>(std::tolower(letter));
  }
  return text;
}

/// "left_camera" → "left"; "cam0" → "0"; "stereo" → "".
std::string side_in(std::string_view group) {
  std::string text{lower(group)};
  if (std::ranges::find(group_words, text) != std::end(group_words)) return {};
  for (const std::string_view word : {"camera", "cam"}) {
    const std::size_t place{text.find(word)};
    if (place == std::string::npos) continue;
    if (text.size() > word.size()) text.erase(place, word.size());
    break;
  }
  return text;
}

std::string plain(std::string_view key) {
  std::string text;
  for (std::size_t dot{key.find('.')}; dot != std::string_view::npos; dot = key.find('.')) {
    text += side_in(key.substr(0, dot));
    key.remove_prefix(dot + 1);
  }
  return text + lower(key);
}

}  // namespace

std::string find(const YamlGroup& flat, Names names, std::string_view side) {
  for (const std::string& key : flat.keys()) {
    const std::string text{plain(key)};
    const auto is_name{[&](std::string_view name) {
      const std::string behind{std::string{name} + std::string{side}};
      return text == behind || text == std::string{side} + std::string{name};
    }};
    if (std::ranges::any_of(names, is_name)) return key;
  }
  return {};
}

const Sides* sides_of(const YamlGroup& flat, Names names) {
  const auto has_both{[&](const Sides& sides) {
    return !find(flat, names, sides.left).empty() && !find(flat, names, sides.right).empty();
  }};
  const auto* const found{std::ranges::find_if(all_sides, has_both)};
  return found == std::end(all_sides) ? nullptr : found;
}

}  // namespace stereogrid::io::opencv
