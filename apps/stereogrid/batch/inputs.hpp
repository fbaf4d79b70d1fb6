// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace stereogrid::app::batch {

/// Expands the arguments INPUT: lists (@FILE or FILE.txt: a line each, # begins a comment) are read, patterns
/// (drives/*) are expanded, paths are made absolute. Throws InputError: no such list, or no name matches the pattern.
[[nodiscard]] std::vector<std::string> expand_inputs(const std::vector<std::string>& given);

/// Candidates for drives within a folder: folders and bags, by name.
[[nodiscard]] std::vector<std::string> drives_within(const std::filesystem::path& folder);

/// Names of drives, each once: the last part of the path, with a number where it occurred before.
class DriveNames {
 public:
  [[nodiscard]] std::string name_of(const std::string& input);

 private:
  std::set<std::string> taken_;
};

/// Part of a file that a digest covers. names_and_sizes: only the size of images and sweeps, and the two ends of other
/// large files. content: every byte.
enum class DigestOf { names_and_sizes, content };

/// Digest of the names of all files below the paths, their sizes and (DigestOf) bytes; of "scene:…", its text. It does
/// not depend on the folder of an input or the times of its files. Throws InputError: missing or not readable.
[[nodiscard]] std::string input_digest(const std::vector<std::string>& paths, DigestOf what);

/// Returns every combination of the values of "key=a,b,c" (values with commas: "key=a,b|c,d") as lists of "key=value";
/// the last key's values change first. Without sweeps: one empty list. Throws ConfigError.
[[nodiscard]] std::vector<std::vector<std::string>> combinations(const std::vector<std::string>& sweeps);

}  // namespace stereogrid::app::batch
