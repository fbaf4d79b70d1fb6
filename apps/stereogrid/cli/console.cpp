// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "cli/console.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <system_error>

namespace stereogrid::app {

namespace {

// errno of the first write that failed. NOLINTNEXTLINE(cppcoreguidelines-avoid-non-const-global-variables)
int output_error{0};

}  // namespace

bool open_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(stream, F_GETFD) >= 0 || errno != EBADF) continue;
    if (open("/dev/null", O_RDWR) != stream) return false;  // the lowest number that is free
  }
  return true;
}

void write_output(std::string_view text) {
  errno = 0;
  if (std::fwrite(text.data(), 1, text.size(), stdout) < text.size() && output_error == 0) output_error = errno;
}

void write_error(std::string_view text) {
  static_cast<void>(std::fwrite(text.data(), 1, text.size(), stderr));
}

std::string lost_output() {
  if (std::fflush(stdout) != 0 && output_error == 0) output_error = errno;
  // network file systems report a full disk only when a file is closed; the original has to stay open for other writers
  const int copy{dup(STDOUT_FILENO)};
  if (copy >= 0 && close(copy) != 0 && errno != EINTR && output_error == 0) output_error = errno;
  return output_error == 0 ? "" : std::generic_category().message(output_error);
}

}  // namespace stereogrid::app
