// SPDX-License-Identifier: Apache-2.0
//
// Included before every file: functions that libc++ 19 lacks on WebAssembly.
#pragma once

#include <charconv>
#include <cstdlib>
#include <string>
#include <system_error>

namespace std {

inline from_chars_result from_chars(const char* first, const char* last, double& value) {
  const string text(first, last);  // ends with a zero
  char* end{nullptr};
  value = strtod(text.c_str(), &end);
  return {first + (end - text.c_str()), end == text.c_str() ? errc::invalid_argument : errc{}};
}

namespace this_thread {
inline void yield() {}
}  // namespace this_thread

}  // namespace std
