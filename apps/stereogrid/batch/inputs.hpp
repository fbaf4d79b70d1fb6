// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace stereogrid::app::batch {

/// What the user calls INPUT…: lists (@FILE or FILE.txt: a line each, # begins a comment) are read, patterns (drives/*)
/// are expanded, paths are made absolute. Throws InputError: no such list, nothing fits the pattern.
[[nodiscard]] std::vector<std::string> expand_inputs(const std::vector<std::string>& given);

/// What could be a drive within a folder: folders and bags, by name.
[[nodiscard]] std::vector<std::string> drives_within(const std::filesystem::path& folder);

/// Names of drives, each once: the last part of the path, with a number where there was one before.
class DriveNames {
 public:
  [[nodiscard]] std::string name_of(const std::string& input);

 private:
  std::set<std::string> taken_;
};

}  // namespace stereogrid::app::batch
