// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>

namespace stereogrid::app {

// Standard streams. Writing to them never throws, so that a run continues without a reader. Errors on stdout are
// reported once, at the end.

/// Opens /dev/null for closed standard streams, so that no other file gets their numbers. Call it before anything else
/// is opened. False: not possible.
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

/// Flushes stdout. Returns the reason if some output is lost, else "".
[[nodiscard]] std::string lost_output();

}  // namespace stereogrid::app
