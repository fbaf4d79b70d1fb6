// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "../temporary_folder.hpp"
#include "stereogrid/io/npz.hpp"

namespace stereogrid::app::testing {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using Arrays = std::map<std::string, io::NpyArray>;

using tests::TemporaryFolder;

/// Output and exit code of a program.
struct Outcome {
  int exit_code{-1};
  std::string output;
  std::string errors;
};

/// Runs the stereogrid program with words of its command line, each passed on as it is. `environment`: such as
/// "PATH=/x".
Outcome run_tool(const std::vector<std::string>& words, const std::string& environment = "");
/// The same for another program.
Outcome run_program(const std::string& program, const std::vector<std::string>& words,
                    const std::string& environment = "");

[[nodiscard]] bool has_node();
/// Runs the script of a report of `evaluate` in node; false where it does not fill the page.
[[nodiscard]] bool script_fills(const std::filesystem::path& report);

/// The same; the test fails where it does not end with 0.
Outcome run_well(const std::vector<std::string>& words);
/// Messages of the tool, which has to end with this exit code.
std::string errors_of(int exit_code, const std::vector<std::string>& words, const std::string& environment = "");

/// A word of the command line.
std::string quoted(const std::string& word);

[[nodiscard]] std::string text_of(const fs::path& path);
[[nodiscard]] Json json_of(const fs::path& path);
/// frames.jsonl of a run; `with_timing` false: without values that differ between two equal runs.
[[nodiscard]] std::vector<Json> lines_of(const fs::path& run, bool with_timing = true);
/// Waits, for a minute at most, until a run has written `count` frames.
void wait_for_frames(const fs::path& run, std::size_t count);
/// Names of the files in a folder, in order.
[[nodiscard]] std::vector<std::string> files_in(const fs::path& folder);

/// Expects equal frames, byte by byte: lines but for their timing, grids, stages.
void expect_equal_runs(const fs::path& a, const fs::path& b);

/// A scene small enough for tests; `more` such as "&frames=3".
[[nodiscard]] std::string small_scene(const std::string& name, const std::string& more);

}  // namespace stereogrid::app::testing
