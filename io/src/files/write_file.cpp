// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <functional>
#include <optional>

#include "files/file_access.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void cannot_write(const fs::path& path, int error_number) {
  const bool full{error_number == ENOSPC || error_number == EDQUOT || error_number == EFBIG};
  throw DeviceError{fmt::format("{}: cannot be written ({}). {}", printable_path(path), reason(error_number),
                                full ? "Free some space and try again." : "Check the folder and its permissions.")};
}

int open_uninterrupted(const fs::path& path, int flags) {
  int descriptor{-1};
  do {
    descriptor = ::open(path.c_str(), flags, 0666);
  } while (descriptor < 0 && errno == EINTR);
  return descriptor;
}

/// errno of the first failure, 0: written and closed.
int write_whole(Descriptor& file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written{::write(file.get(), bytes.data(), bytes.size())};
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return file.close();
}

/// Status of a path, links followed; none: it does not exist.
std::optional<struct stat> status_of(const fs::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0) return status;
  if (errno != ENOENT) cannot_write(path, errno);
  return std::nullopt;
}

/// End of a chain of symbolic links, whether it exists or not.
fs::path behind_links(fs::path path) {
  constexpr int most_links{40};  // as the kernel
  std::error_code error;
  for (int i{0}; i < most_links; ++i) {
    const fs::file_type type{fs::symlink_status(path, error).type()};
    if (type == fs::file_type::none) cannot_write(path, error.value());  // else a link would be replaced
    if (type != fs::file_type::symlink) break;
    path = path.parent_path() / fs::read_symlink(path, error);
    if (error) cannot_write(path, error.value());
  }
  return path;
}

/// Hidden, with a fixed name: never mistaken for a result, and replaced by the next run.
fs::path temporary_beside(const fs::path& path) {
  const fs::path folder{path.has_parent_path() ? path.parent_path() : fs::path{"."}};
  const std::string name{path.filename().string()};
  std::string temporary{fmt::format(".{}.partial", name)};
  const long most{::pathconf(folder.c_str(), _PC_NAME_MAX)};
  if (most > 0 && temporary.size() > static_cast<std::size_t>(most)) {
    temporary = fmt::format(".{:016x}.partial", std::hash<std::string>{}(name));
  }
  return folder / temporary;
}

/// Standard output or standard error where the name stands for it, as /dev/stdout does; -1: for neither.
int standard_stream(const struct stat& status) {
  for (const int standard : {STDOUT_FILENO, STDERR_FILENO}) {
    struct stat open_one {};
    if (::fstat(standard, &open_one) != 0) continue;
    if (open_one.st_dev == status.st_dev && open_one.st_ino == status.st_ino) return standard;
  }
  return -1;
}

void write_directly(const fs::path& path, const struct stat& status, std::string_view bytes) {
  const int standard{standard_stream(status)};
  if (standard >= 0) std::fflush(standard == STDOUT_FILENO ? stdout : stderr);  // earlier output comes first
  Descriptor file{standard >= 0 ? ::fcntl(standard, F_DUPFD_CLOEXEC, 0)
                                : open_uninterrupted(path, O_WRONLY | O_CLOEXEC | O_NOCTTY)};
  if (file.get() < 0) cannot_write(path, errno);
  if (const int error_number{write_whole(file, bytes)}; error_number != 0) cannot_write(path, error_number);
}

/// Keeps the owner of the old file, if permitted.
void take_over_permissions(int descriptor, const struct stat& old) {
  if (::fchown(descriptor, old.st_uid, old.st_gid) != 0) errno = 0;
  ::fchmod(descriptor, old.st_mode & 07777);
}

}  // namespace

void write_file(const fs::path& path, std::string_view bytes) {
  const std::optional<struct stat> old{status_of(path)};
  if (old && S_ISDIR(old->st_mode)) {
    throw DeviceError{printable_path(path) + ": is a folder where a file is to be written. Name a file."};
  }
  if (old && (!S_ISREG(old->st_mode) || standard_stream(*old) >= 0)) return write_directly(path, *old, bytes);
  if (old && ::access(path.c_str(), W_OK) != 0) cannot_write(path, errno);
  const fs::path target{behind_links(path)};
  const fs::path temporary{temporary_beside(target)};
  const auto give_up{[&](int error_number) {
    ::unlink(temporary.c_str());
    cannot_write(path, error_number);
  }};
  ::unlink(temporary.c_str());
  Descriptor file{open_uninterrupted(temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC)};
  if (file.get() < 0) cannot_write(path, errno);
  if (old) take_over_permissions(file.get(), *old);
  if (const int error_number{write_whole(file, bytes)}; error_number != 0) give_up(error_number);
  if (::rename(temporary.c_str(), target.c_str()) != 0) give_up(errno);
}

}  // namespace stereogrid::io
