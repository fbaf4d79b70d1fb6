// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cli/help.hpp"

namespace stereogrid::app {

/// First argument with which the scripts of packaging/completion call the program; the words of the command line
/// follow.
constexpr std::string_view completion_request{"__complete"};

/// Candidates for the last of `words`, the part of the command line after the program's name: "WORD\tDESCRIPTION", or
/// ":files" or ":folders" where the shell completes paths.
[[nodiscard]] std::vector<std::string> completions(const CommandText& program, const std::vector<std::string>& words);

}  // namespace stereogrid::app
