// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/inputs.hpp"

#include <fmt/format.h>
#include <glob.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <sstream>
#include <system_error>

#include "batch/sha256.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::app::batch {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t whole_file_bytes{1 << 20};
constexpr std::size_t end_bytes{64 << 10};
constexpr std::size_t most_variants{10'000};

bool is_scene(const std::string& path) {
  return path.starts_with("scene:");
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
    throw InputError{file, "is a list of inputs, but names none.", "Write an input into each line."};
  }
  return lines;
}

void add_pattern(const std::string& pattern, std::vector<std::string>& paths) {
  glob_t found{};
  const int result{glob(pattern.c_str(), GLOB_ERR, nullptr, &found)};
  for (std::size_t i{0}; result == 0 && i < found.gl_pathc; ++i) paths.push_back(absolute(found.gl_pathv[i]));
  globfree(&found);
  if (result != 0) {
    throw InputError{pattern, "nothing has a name that fits this pattern.", "Check the path."};
  }
}

void add(const std::string& given, std::vector<std::string>& paths) {
  const bool pattern{!is_scene(given) && !io::is_there(given) && given.find_first_of("*?[") != std::string::npos};
  if (pattern) {
    add_pattern(given, paths);
  } else {
    paths.push_back(absolute(given));
  }
}

bool is_list(const std::string& given) {
  return given.starts_with('@') || (!is_scene(given) && given.ends_with(".txt") && !io::is_folder(given));
}

bool is_one_of_many(const fs::path& file) {
  static const std::set<std::string> endings{".png", ".pgm", ".ppm", ".jpg", ".jpeg", ".tif", ".tiff",
                                             ".bmp", ".pfm", ".npy", ".npz", ".bin",  ".flo"};
  return endings.contains(file.extension().string());
}

[[noreturn]] void unreadable(const fs::path& file, const std::string& why) {
  throw InputError{io::printable_path(file), "cannot be read (" + why + ").", "Check the path and its permissions."};
}

void add_bytes(std::ifstream& file, const fs::path& path, std::uintmax_t count, Sha256& digest) {
  std::array<char, 1 << 16> piece{};
  while (count > 0) {
    const auto wanted{static_cast<std::streamsize>(std::min<std::uintmax_t>(count, piece.size()))};
    if (!file.read(piece.data(), wanted)) unreadable(path, "it ended early");
    digest.add({piece.data(), static_cast<std::size_t>(wanted)});
    count -= static_cast<std::uintmax_t>(wanted);
  }
}

void add_file(const fs::path& path, const std::string& name, DigestOf what, Sha256& digest) {
  const std::uintmax_t size{fs::file_size(path)};
  digest.add(fmt::format("{}\n{}\n", name, size));
  if (what == DigestOf::names_and_sizes && is_one_of_many(path)) return;
  std::ifstream file{path, std::ios::binary};
  if (!file) unreadable(path, "no permission, or gone");
  if (what == DigestOf::content || size <= whole_file_bytes) return add_bytes(file, path, size, digest);
  add_bytes(file, path, end_bytes, digest);
  file.seekg(static_cast<std::streamoff>(size - end_bytes));
  add_bytes(file, path, end_bytes, digest);
}

std::vector<fs::path> files_below(const fs::path& folder) {
  std::vector<fs::path> files;
  const auto options{fs::directory_options::follow_directory_symlink};
  for (fs::recursive_directory_iterator at{folder, options}; at != fs::recursive_directory_iterator{}; ++at) {
    if (at.depth() > 16) unreadable(at->path(), "folders within folders, or a link that goes in a circle");
    if (at->is_regular_file()) files.push_back(at->path().lexically_relative(folder));
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<std::string> swept_settings(const std::string& sweep) {
  const std::size_t equals{sweep.find('=')};
  const std::string key{sweep.substr(0, equals)};
  const std::string values{equals == std::string::npos ? "" : sweep.substr(equals + 1)};
  const char separator{values.find('|') == std::string::npos ? ',' : '|'};
  std::vector<std::string> settings;
  std::set<std::string> seen;
  for (std::size_t at{0}; at <= values.size();) {
    const std::size_t end{std::min(values.find(separator, at), values.size())};
    const std::string value{values.substr(at, end - at)};
    if (key.empty() || value.empty() || !seen.insert(value).second) {
      throw ConfigError{
          fmt::format("--sweep {}: give KEY=A,B,C with different values, such as filter.decay_time_s=1,2,4.",
                      io::printable(sweep))};
    }
    settings.push_back(key + '=' + value);
    at = end + 1;
  }
  return settings;
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
  for (const fs::path& entry : io::entries_of(folder)) {
    const std::string ending{entry.extension().string()};
    const bool bag{ending == ".mcap" || ending == ".db3"};
    if (bag || io::is_folder(entry)) paths.push_back(entry.string());
  }
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

std::string input_digest(const std::vector<std::string>& paths, DigestOf what) {
  Sha256 digest;
  for (const std::string& path : paths) {
    if (path.starts_with("scene:")) {
      digest.add(path + '\n');
    } else if (io::is_folder(path)) {
      for (const fs::path& file : files_below(path)) add_file(fs::path{path} / file, file.string(), what, digest);
    } else if (io::is_there(path)) {
      add_file(path, fs::path{path}.filename().string(), what, digest);
    } else {
      unreadable(path, "not there");
    }
  }
  return digest.hex();
}

std::vector<std::vector<std::string>> combinations(const std::vector<std::string>& sweeps) {
  std::vector<std::vector<std::string>> all{{}};
  for (const std::string& sweep : sweeps) {
    const std::vector<std::string> settings{swept_settings(sweep)};
    if (all.size() * settings.size() > most_variants) {
      throw ConfigError{fmt::format("--sweep: more than {} combinations. Make several plans.", most_variants)};
    }
    std::vector<std::vector<std::string>> longer;
    for (const std::vector<std::string>& before : all) {
      for (const std::string& setting : settings) {
        longer.push_back(before);
        longer.back().push_back(setting);
      }
    }
    all = std::move(longer);
  }
  return all;
}

}  // namespace stereogrid::app::batch
