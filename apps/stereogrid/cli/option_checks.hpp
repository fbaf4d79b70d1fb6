// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace stereogrid::app {

/// Returns the fault of an option's value; "": none.
using OptionCheck = std::function<std::string(const std::string& value)>;

/// In decimal digits, both ends included. CLI11's own reading wraps -1 around and takes 010 for eight.
[[nodiscard]] OptionCheck whole_number(std::uint64_t minimum, std::uint64_t maximum);
/// Both ends included; CLI11's own range lets nan through.
[[nodiscard]] OptionCheck number(double minimum, double maximum);

}  // namespace stereogrid::app
