// SPDX-License-Identifier: Apache-2.0
#include "locks/folder_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>

#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"

namespace stereogrid::app {
namespace {

namespace fs = std::filesystem;

std::string reason(int error_number) {
  return std::generic_category().message(error_number);
}

[[noreturn]] void cannot_write(const fs::path& file, int error_number) {
  throw DeviceError{fmt::format("{}: cannot be written ({}). Check the folder, its permissions and the space there.",
                                file.string(), reason(error_number))};
}

[[noreturn]] void report_other(const fs::path& folder, int descriptor) {
  std::array<char, 24> text{};
  const ssize_t count{pread(descriptor, text.data(), text.size(), 0)};
  const std::string number(text.data(), static_cast<std::size_t>(count > 0 ? count : 0));
  throw DeviceError{
      fmt::format("another stereogrid is writing to {} (process {}). Wait until it has ended, or give another folder.",
                  folder.string(), number.empty() ? "unknown" : number.substr(0, number.find('\n')))};
}

/// errno, 0: locked.
int lock(int descriptor) {
  int result{-1};
  do {
    result = flock(descriptor, LOCK_EX | LOCK_NB);
  } while (result != 0 && errno == EINTR);
  return result == 0 ? 0 : errno;
}

/// Tests whether the opened file still has its name: a process that ended in the meantime has removed it, and its lock
/// has no effect.
bool has_name(int descriptor, const fs::path& file) {
  struct stat opened {};
  struct stat named {};
  return fstat(descriptor, &opened) == 0 && stat(file.c_str(), &named) == 0 && opened.st_dev == named.st_dev &&
         opened.st_ino == named.st_ino;
}

}  // namespace

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

FolderLock::FolderLock(const fs::path& folder) : file_{folder / ".lock"} {
  io::create_folder(folder);
  for (;;) {
    descriptor_ = open_file(file_.c_str(), O_RDWR | O_CREAT);
    if (descriptor_.get() < 0) cannot_write(file_, errno);
    const int error_number{lock(descriptor_.get())};
    if (error_number == EWOULDBLOCK) report_other(folder, descriptor_.get());
    if (error_number == ENOLCK || error_number == ENOSYS || error_number == EOPNOTSUPP) {
      warning_ = fmt::format("{}: this file system cannot lock ({}): take care that no other stereogrid writes there.",
                             folder.string(), reason(error_number));
      return;
    }
    if (error_number != 0) cannot_write(file_, error_number);
    if (has_name(descriptor_.get(), file_)) break;
  }
  // whose it is: for the other one's problem
  if (ftruncate(descriptor_.get(), 0) != 0 || !write_all(descriptor_.get(), fmt::format("{}\n", getpid()))) {
    cannot_write(file_, errno);
  }
}

FolderLock::~FolderLock() {
  static_cast<void>(unlink(file_.c_str()));  // first, so that the next owner of the lock does not find it
}

}  // namespace stereogrid::app
