// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "files/file_access.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void cannot_read(const fs::path& path, const std::string& what, const char* mend) {
  throw InputError{printable_path(path), what, mend};
}

void check_may_be_read(const fs::path& path, const struct stat& status) {
  if (S_ISDIR(status.st_mode)) cannot_read(path, "is a folder where a file is needed.", "Name a file.");
  if (S_ISREG(status.st_mode)) return;
  cannot_read(path, "is a device, FIFO or socket, not a file on a disk.", "Copy what it gives into a file.");
}

[[noreturn]] void too_large(const fs::path& path, std::size_t most_bytes) {
  cannot_read(path, fmt::format("has more than {} MB, the most that such a file can have.", most_bytes >> 20),
              "Check that it is the right file.");
}

/// To the end or until there are more than `most` bytes.
std::string read_up_to(const fs::path& path, int descriptor, std::size_t expected, std::size_t most) {
  std::string bytes;
  std::size_t size{0};
  for (;;) {
    if (size == bytes.size()) bytes.resize(size == 0 ? expected + 1 : size + size / 2 + 4096);
    const ssize_t count{::read(descriptor, bytes.data() + size, bytes.size() - size)};
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throw_unreadable(path, errno);
    if (count == 0) break;
    size += static_cast<std::size_t>(count);
    if (size > most) too_large(path, most);
  }
  bytes.resize(size);
  return bytes;
}

}  // namespace

std::string read_file(const fs::path& path, std::size_t most_bytes) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) throw_unreadable(path, errno);
  check_may_be_read(path, status);  // before it is opened: opening a FIFO waits, opening a device may do something
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY)};
  if (file.get() < 0 || ::fstat(file.get(), &status) != 0) throw_unreadable(path, errno);
  check_may_be_read(path, status);  // it may have become another one
  const auto size{static_cast<std::size_t>(status.st_size)};
  if (size > most_bytes) too_large(path, most_bytes);
  std::string bytes{read_up_to(path, file.get(), size, most_bytes)};
  if (bytes.size() < size) {
    throw UnavailableFile{
        printable_path(path),
        fmt::format("ends after {} of its {} bytes: it was cut off while it was read.", bytes.size(), size),
        "Wait until it is whole."};
  }
  return bytes;
}

std::string read_text(const fs::path& path, std::size_t most_bytes) {
  std::string text{read_file(path, most_bytes)};
  if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);
  return text;
}

void create_folder(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  const std::string why{error ? error.message() : "a file of that name is in the way"};
  if (!error && is_folder(path)) return;
  throw DeviceError{fmt::format("{}: the folder cannot be made ({}). Choose another, or check the permissions.",
                                printable_path(path), why)};
}

}  // namespace stereogrid::io
