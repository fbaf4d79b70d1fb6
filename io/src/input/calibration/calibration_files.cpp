// SPDX-License-Identifier: Apache-2.0
#include "input/calibration/calibration_forms.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stereogrid/error.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

namespace fs = std::filesystem;

struct Words {
  const char* first;
  const char* second;
};

constexpr Words sides[]{{"left", "right"}, {"Left", "Right"}, {"LEFT", "RIGHT"}, {"cam0", "cam1"}};
constexpr Words parts[]{{"intrinsic", "extrinsic"}};

/// The last place counts: "left" may be a part of a longer name.
std::optional<std::string> exchanged(const std::string& text, const char* from, const char* to) {
  const std::size_t place{text.rfind(from)};
  if (place == std::string::npos) return std::nullopt;
  return text.substr(0, place) + to + text.substr(place + std::string_view{from}.size());
}

std::optional<fs::path> exchanged(const fs::path& path, const char* from, const char* to) {
  const fs::path folder{path.parent_path()};
  if (const auto name{exchanged(path.filename().string(), from, to)}) return folder / *name;
  if (const auto name{exchanged(folder.filename().string(), from, to)}) {
    return folder.parent_path() / *name / path.filename();
  }
  return std::nullopt;
}

/// Names of two halves.
bool are_halves(const fs::path& one, const fs::path& other) {
  const auto is_pair{[&](const Words& words) {
    return exchanged(one, words.first, words.second) == other || exchanged(one, words.second, words.first) == other;
  }};
  return std::ranges::any_of(sides, is_pair) || std::ranges::any_of(parts, is_pair);
}

FilePair pair_of(const fs::path& either, std::span<const Words> all) {
  const auto with{[&](const fs::path& other) {
    if (is_there(other)) return other;
    throw InputError{printable_path(either),
                     "is one half of a calibration, and " + printable_path(other) + " is not there.",
                     "Put it there: both are needed."};
  }};
  for (const Words& words : all) {
    if (const auto second{exchanged(either, words.first, words.second)}) return {either, with(*second)};
    if (const auto first{exchanged(either, words.second, words.first)}) return {with(*first), either};
  }
  throw InputError{
      printable_path(either), "is one half of a calibration, and its name does not say which is the other.",
      fmt::format(
          "Name them with '{0}' and '{1}', or write 'from: [{0}, {1}]' with their names into a calibration.yaml.",
          all[0].first, all[0].second)};
}

bool is_yaml(const fs::path& path) {
  return path.extension() == ".yaml" || path.extension() == ".yml";
}

/// Adds the files of the folder whose name holds one of the words.
void add_named(const fs::path& folder, std::span<const char* const> words, std::vector<fs::path>& found) {
  if (!is_folder(folder)) return;
  for (const fs::path& entry : entries_of(folder)) {
    const std::string name{entry.filename().string()};
    const auto is_in_name{[&](const char* word) { return name.find(word) != std::string::npos; }};
    if (is_yaml(entry) && std::ranges::any_of(words, is_in_name)) found.push_back(entry);
  }
}

/// Among several single cameras the one of the images, by ScanNet's names.
void leave_colour(std::vector<fs::path>& found) {
  const auto is_other{[](const fs::path& path) {
    const std::string name{path.filename().string()};
    return name.find("intrinsic") == std::string::npos || name.find("depth") != std::string::npos;
  }};
  if (found.size() > 1 && !std::ranges::all_of(found, is_other)) std::erase_if(found, is_other);
}

constexpr std::string_view text_extensions[]{".yaml", ".yml", ".xml", ".json", ".txt", ".conf", ".npz"};

/// Files of any name in which a reader finds a calibration. Of two that belong together, the first. Those of one camera
/// where there are no others: the reader has the remedy.
std::vector<fs::path> recognised_in(const fs::path& folder, bool has_depth) {
  std::vector<fs::path> found;
  std::vector<fs::path> singles;
  std::string others;
  for (const fs::path& path : entries_of(folder)) {
    if (std::ranges::find(text_extensions, path.extension().string()) == std::end(text_extensions)) continue;
    if (is_calibration_of_other_tool(path, has_depth)) {
      found.push_back(path);
    } else if (is_calibration_of_other_tool(path, true)) {
      singles.push_back(path);
    } else if (path.extension() != ".txt") {
      others += (others.empty() ? "" : ", ") + printable_path(path.filename());
    }
  }
  if (found.empty()) found = std::move(singles);
  if (has_depth) leave_colour(found);
  if (found.size() == 2 && are_halves(found[0], found[1])) found.pop_back();
  if (!found.empty() || others.empty()) return found;
  throw InputError{
      printable_path(folder),
      fmt::format("there is no calibration that is known; {} is there, without the keys of two cameras.", others),
      "Put a calibration.yaml there, or name a file with --calibration. docs/input.md has all formats."};
}

}  // namespace

FilePair left_and_right(const fs::path& either) {
  return pair_of(either, sides);
}

FilePair intrinsics_and_extrinsics(const fs::path& either) {
  return pair_of(either, parts);
}

fs::path find_calibration_in(const fs::path& folder, bool has_depth) {
  constexpr const char* in_root[]{"left", "Left", "LEFT", "extrinsic", "camchain"};
  constexpr const char* beside_images[]{"camera_info", "ost"};
  std::vector<fs::path> found;
  add_named(folder, in_root, found);
  add_named(folder / "camera_info", std::span{in_root}.first(3), found);
  for (const char* const camera : {"left", "cam0"}) add_named(folder / camera, beside_images, found);
  if (found.empty()) found = recognised_in(folder, has_depth);
  for (const char* const inside : {"calibration", "calib", "intrinsic", "intrinsics", "dso"}) {
    if (found.empty() && is_folder(folder / inside)) found = recognised_in(folder / inside, has_depth);
  }
  if (found.empty()) return {};
  if (found.size() == 1) return found.front();
  std::ranges::sort(found);
  throw InputError{
      printable_path(folder),
      fmt::format("holds several calibrations: {} and {}.", printable_path(found[0].lexically_relative(folder)),
                  printable_path(found[1].lexically_relative(folder))),
      "Name the one to take with --calibration."};
}

}  // namespace stereogrid::io
