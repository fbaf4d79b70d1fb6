// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/inputs.hpp"

#include <fmt/format.h>
#include <glob.h>

#include <algorithm>
#include <sstream>
#include <system_error>

#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::app::batch {
namespace {

namespace fs = std::filesystem;

bool is_scene(const std::string& path) {
  return path.starts_with("scene:");
}

bool exists(const std::string& path) {
  std::error_code error;
  return fs::exists(path, error);
}

std::string absolute(const std::string& path) {
  return is_scene(path) ? path : fs::weakly_canonical(fs::absolute(path)).string();
}

std::vector<std::string> lines_of(const std::string& file) {
  std::istringstream text{io::read_text(file, io::largest_bytes::lines)};
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) {
    line.erase(line.find_last_not_of(" \t\r") + 1);
    line.erase(0, std::min(line.find_first_not_of(" \t"), line.size()));
    if (!line.empty() && line.front() != '#') lines.push_back(line);
  }
  if (lines.empty()) {
    throw InputError{io::printable(file), "is a list of inputs, but names none.", "Write an input into each line."};
  }
  return lines;
}

void add_pattern(const std::string& pattern, std::vector<std::string>& paths) {
  glob_t found{};
  const int result{glob(pattern.c_str(), GLOB_ERR, nullptr, &found)};
  for (std::size_t i{0}; result == 0 && i < found.gl_pathc; ++i) paths.push_back(absolute(found.gl_pathv[i]));
  globfree(&found);
  if (result != 0) {
    throw InputError{io::printable(pattern), "nothing has a name that fits this pattern.", "Check the path."};
  }
}

void add(const std::string& given, std::vector<std::string>& paths) {
  const bool pattern{!is_scene(given) && !exists(given) && given.find_first_of("*?[") != std::string::npos};
  if (pattern) {
    add_pattern(given, paths);
  } else {
    paths.push_back(absolute(given));
  }
}

bool is_list(const std::string& given) {
  return given.starts_with('@') || (!is_scene(given) && given.ends_with(".txt") && !fs::is_directory(given));
}

}  // namespace

std::vector<std::string> expand_inputs(const std::vector<std::string>& given) {
  std::vector<std::string> paths;
  for (const std::string& input : given) {
    if (!is_list(input)) {
      add(input, paths);
      continue;
    }
    for (const std::string& line : lines_of(input.starts_with('@') ? input.substr(1) : input)) add(line, paths);
  }
  return paths;
}

std::vector<std::string> drives_within(const fs::path& folder) {
  std::vector<std::string> paths;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator{folder, error}) {
    const std::string ending{entry.path().extension().string()};
    const bool bag{ending == ".mcap" || ending == ".db3"};
    if (entry.is_directory(error) || bag) paths.push_back(entry.path().string());
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

std::string DriveNames::name_of(const std::string& input) {
  std::string name{is_scene(input) ? input.substr(6) : fs::path{input}.filename().string()};
  name = io::printable(name, std::string::npos);
  std::ranges::replace(name, '/', '_');
  if (name.empty() || name.front() == '.') name.insert(0, "drive");
  std::string once{name};
  for (int number{2}; !taken_.insert(once).second; ++number) once = fmt::format("{}-{}", name, number);
  return once;
}

}  // namespace stereogrid::app::batch
