// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "stereogrid/export.hpp"

namespace stereogrid {

/// Text from outside as it may stand in a message, a file or on a terminal: valid UTF-8 without control characters
/// stays as it is, every other byte becomes \xNN. Longer than `longest_bytes`: cut off between two characters, with
/// "…".
[[nodiscard]] STEREOGRID_EXPORT std::string printable(std::string_view text, std::size_t longest_bytes = 200);

/// The same for text of several lines: line breaks stay.
[[nodiscard]] STEREOGRID_EXPORT std::string printable_lines(std::string_view text, std::size_t longest_bytes);

/// Least number of bytes to insert, remove or replace between two texts: for suggestions of misspelt names.
[[nodiscard]] STEREOGRID_EXPORT std::size_t edit_distance(std::string_view a, std::string_view b);

}  // namespace stereogrid
