// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "locks/descriptor.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>

namespace stereogrid::app {

bool Descriptor::close() {
  if (descriptor_ < 0) return true;
  // interrupted: Linux has closed it all the same
  return ::close(std::exchange(descriptor_, -1)) == 0 || errno == EINTR;
}

Descriptor open_file(const char* path, int flags) {
  constexpr mode_t minus_umask{0666};
  int descriptor{-1};
  do {
    descriptor = ::open(path, flags | O_CLOEXEC, minus_umask);
  } while (descriptor < 0 && errno == EINTR);
  return Descriptor{descriptor};
}

bool write_all(int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written{::write(descriptor, bytes.data(), bytes.size())};
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

}  // namespace stereogrid::app
