// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/input_digest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <set>
#include <string_view>
#include <system_error>

#include "batch/sha256.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::app::batch {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t whole_file_bytes{1 << 20};
constexpr std::size_t end_bytes{64 << 10};

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
  std::error_code error;
  const std::uintmax_t size{fs::file_size(path, error)};
  if (error) unreadable(path, error.message());
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
  std::error_code error;
  const auto options{fs::directory_options::follow_directory_symlink};
  for (fs::recursive_directory_iterator at{folder, options, error}; !error && at != fs::recursive_directory_iterator{};
       at.increment(error)) {
    if (at.depth() > 16) unreadable(at->path(), "folders within folders, or a link that goes in a circle");
    if (at->is_regular_file(error)) files.push_back(at->path().lexically_relative(folder));
  }
  if (error) unreadable(folder, error.message());
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

std::string input_digest(const std::vector<std::string>& paths, DigestOf what) {
  Sha256 digest;
  for (const std::string& path : paths) {
    std::error_code error;
    if (path.starts_with("scene:")) {
      digest.add(path + '\n');
    } else if (fs::is_directory(path, error)) {
      for (const fs::path& file : files_below(path)) add_file(fs::path{path} / file, file.string(), what, digest);
    } else if (fs::exists(path, error)) {
      add_file(path, fs::path{path}.filename().string(), what, digest);
    } else {
      unreadable(path, "not there");
    }
  }
  return digest.hex();
}

}  // namespace stereogrid::app::batch
