// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "cli/cli_fwd.hpp"

namespace stereogrid::app {

/// For the check of an option: what is wrong with its value, "" where nothing is.
using OptionCheck = std::function<std::string(const std::string& value)>;

/// In decimal digits, both ends included. CLI11's own reading wraps -1 around and takes 010 for eight.
[[nodiscard]] OptionCheck whole_number(std::uint64_t minimum, std::uint64_t maximum);
/// Both ends included; CLI11's own range lets nan through.
[[nodiscard]] OptionCheck number(double minimum, double maximum);

/// Rejects empty values for all options of the tool and its commands. They come from unset variables of a script, and
/// ignoring the option would not be intended.
void refuse_empty_values(CLI::App& tool);

}  // namespace stereogrid::app
