// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace stereogrid::app::batch {

/// The words of a command that no shell sees: between spaces, or between quotation marks ('…', "…"), within which
/// everything is as it stands. Throws ConfigError: none there, or a quotation mark is missing.
[[nodiscard]] std::vector<std::string> words_of(std::string_view command);

/// The words with each {name} of `values` replaced. Throws ConfigError: a {name} that is not among them.
[[nodiscard]] std::vector<std::string> filled_in(std::vector<std::string> words,
                                                 const std::map<std::string, std::string>& values);

}  // namespace stereogrid::app::batch
