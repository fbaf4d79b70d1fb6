// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <sstream>
#include <system_error>

#include "stereogrid/error.hpp"

namespace stereogrid::io {
namespace {

std::string reason(int error_number) {
  return std::generic_category().message(error_number);
}

[[noreturn]] void cannot_write(const std::filesystem::path& path, int error_number) {
  const bool full{error_number == ENOSPC || error_number == EDQUOT || error_number == EFBIG};
  throw DeviceError{fmt::format("{}: cannot be written ({}). {}", path.string(), reason(error_number),
                                full ? "Free some space and try again." : "Check the folder and its permissions.")};
}

/// An open file descriptor.
class Descriptor {
 public:
  explicit Descriptor(int descriptor) : descriptor_{descriptor} {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() { close(); }

  [[nodiscard]] int get() const { return descriptor_; }
  /// The errno of close(), 0: none. Network file systems report a full disk only here.
  int close() {
    const int result{descriptor_ >= 0 ? ::close(descriptor_) : 0};
    descriptor_ = -1;
    return result == 0 || errno == EINTR ? 0 : errno;  // Linux has closed it, interrupted or not
  }

 private:
  int descriptor_;
};

int open_new(const std::filesystem::path& path) {
  int descriptor{-1};
  do {
    descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  } while (descriptor < 0 && errno == EINTR);
  return descriptor;
}

/// errno of the first failure, 0: written.
int write_whole(const std::filesystem::path& path, std::string_view bytes) {
  Descriptor file{open_new(path)};
  if (file.get() < 0) return errno;
  while (!bytes.empty()) {
    const ssize_t written{::write(file.get(), bytes.data(), bytes.size())};
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return file.close();
}

}  // namespace

std::string read_file(const std::filesystem::path& path) {
  std::error_code error;
  const auto status{std::filesystem::status(path, error)};
  if (!std::filesystem::exists(status)) {
    throw InputError{path.string(), error && error.value() != ENOENT ? error.message() + "." : "there is no such file.",
                     "Check the path."};
  }
  if (std::filesystem::is_directory(status)) {
    throw InputError{path.string(), "is a folder where a file is needed.", "Name a file."};
  }
  errno = 0;
  std::ifstream file{path, std::ios::binary};
  if (!file)
    throw InputError{path.string(), fmt::format("cannot be read ({}).", reason(errno)), "Check its permissions."};
  std::ostringstream bytes;
  if (std::filesystem::file_size(path, error) != 0 && !(bytes << file.rdbuf()))
    throw InputError{path.string(), "cannot be read to its end.", "Check the disk."};
  return std::move(bytes).str();
}

void write_file(const std::filesystem::path& path, std::string_view bytes) {
  // Hidden and of a fixed name: nobody takes it for a result, and the next run replaces what a killed one left.
  const auto temporary{path.parent_path() / fmt::format(".{}.partial", path.filename().string())};
  if (const int error_number{write_whole(temporary, bytes)}; error_number != 0) {
    ::unlink(temporary.c_str());
    cannot_write(path, error_number);
  }
  if (::rename(temporary.c_str(), path.c_str()) != 0) {
    const int error_number{errno};
    ::unlink(temporary.c_str());
    cannot_write(path, error_number);
  }
}

void create_folder(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error || !std::filesystem::is_directory(path, error)) {
    throw DeviceError{fmt::format("{}: the folder cannot be made ({}). Choose another, or check the permissions.",
                                  path.string(), error ? error.message() : "a file of that name is in the way")};
  }
}

}  // namespace stereogrid::io
