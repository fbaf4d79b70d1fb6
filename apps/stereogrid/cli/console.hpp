// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>

namespace stereogrid::app {

// The standard streams. Writing to them never throws, whatever is at their other end: a run does not end because nobody
// listens. Whether stdout has arrived is asked once, at the end.

/// Puts /dev/null where a standard stream is closed, so that no file of ours gets its number and what is said on it.
/// Before anything else is opened. False where that cannot be done.
[[nodiscard]] bool open_standard_streams();

void write_output(std::string_view text);
void write_error(std::string_view text);

/// To stdout.
template <class... Values>
void tell(fmt::format_string<Values...> format, Values&&... values) {
  write_output(fmt::format(format, std::forward<Values>(values)...));
}

/// To stderr.
template <class... Values>
void tell_on_stderr(fmt::format_string<Values...> format, Values&&... values) {
  write_error(fmt::format(format, std::forward<Values>(values)...));
}

/// Hands on what waits for stdout. Why some of all that was written there is lost; "": nothing is.
[[nodiscard]] std::string lost_output();

}  // namespace stereogrid::app
