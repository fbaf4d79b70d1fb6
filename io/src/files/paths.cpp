// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/paths.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "files/file_access.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

namespace fs = std::filesystem;

bool is_missing(int error_number) {
  return error_number == ENOENT || error_number == ENOTDIR;
}

/// Type bits of st_mode; 0: there is no such path.
mode_t type_of(const fs::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0) return status.st_mode & S_IFMT;
  if (!is_missing(errno) && errno != ENAMETOOLONG) throw_unreadable(path, errno);
  return 0;
}

}  // namespace

// ELOOP and ENAMETOOLONG: of the path itself.
bool is_temporary(int error_number) {
  return !is_missing(error_number) && error_number != EACCES && error_number != ELOOP && error_number != ENAMETOOLONG;
}

void throw_unreadable(const fs::path& path, int error_number) {
  const std::string file{printable_path(path)};
  const std::string why{fmt::format("cannot be read ({}).", reason(error_number))};
  if (is_temporary(error_number)) throw DeviceError{file + ": " + why + " Check the disk, then try again."};
  const char* const mend{error_number == EACCES ? "Check its permissions and those of the folders above it."
                                                : "Check the path and its permissions."};
  if (error_number == ELOOP || error_number == ENAMETOOLONG) throw InputError{file, why, mend};
  throw UnavailableFile{file, is_missing(error_number) ? "there is no such file." : why, mend};
}

bool is_there(const fs::path& path) {
  return type_of(path) != 0;
}

bool is_folder(const fs::path& path) {
  return type_of(path) == S_IFDIR;
}

bool is_file(const fs::path& path) {
  return type_of(path) == S_IFREG;
}

bool has_entries(const fs::path& folder) {
  return is_folder(folder) && !entries_of(folder).empty();
}

std::vector<fs::path> entries_of(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> entries;
  fs::directory_iterator entry{folder, error};
  for (; !error && entry != fs::directory_iterator{}; entry.increment(error)) entries.push_back(entry->path());
  if (error && is_temporary(error.value())) throw_unreadable(folder, error.value());
  if (error) {
    throw InputError{printable_path(folder), "the folder cannot be read (" + error.message() + ").",
                     "Check its permissions."};
  }
  std::ranges::sort(entries);
  return entries;
}

std::string first_bytes(const fs::path& path, std::size_t most) {
  struct stat status {};
  const auto give_up{[&path] {
    if (is_temporary(errno)) throw_unreadable(path, errno);
    return std::string{};
  }};
  if (::stat(path.c_str(), &status) != 0) return give_up();
  if (!S_ISREG(status.st_mode)) return {};  // before it is opened: opening a FIFO waits
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY)};
  if (file.get() < 0) return give_up();
  std::string bytes(most, '\0');
  ssize_t count{-1};
  do count = ::read(file.get(), bytes.data(), most);
  while (count < 0 && errno == EINTR);
  if (count < 0) return give_up();
  bytes.resize(static_cast<std::size_t>(count));
  return bytes;
}

}  // namespace stereogrid::io
