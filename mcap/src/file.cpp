// SPDX-License-Identifier: Apache-2.0
#include "file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>
#include <utility>

#include "compression.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::mcap {
namespace {

namespace fs = std::filesystem;

std::string reason(int error_number) {
  return std::generic_category().message(error_number);
}

int open_uninterrupted(const fs::path& path, int flags) {
  int descriptor{-1};
  do {
    descriptor = ::open(path.c_str(), flags | O_CLOEXEC | O_NOCTTY, 0666);
  } while (descriptor < 0 && errno == EINTR);
  return descriptor;
}

}  // namespace

Descriptor::Descriptor(Descriptor&& other) noexcept : descriptor_{std::exchange(other.descriptor_, -1)} {}

Descriptor& Descriptor::operator=(Descriptor&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

int Descriptor::close() {
  const int result{descriptor_ >= 0 ? ::close(std::exchange(descriptor_, -1)) : 0};
  return result == 0 || errno == EINTR ? 0 : errno;  // Linux has closed it, interrupted or not
}

FileOutput::FileOutput(const fs::path& path)
    : file_{open_uninterrupted(path, O_WRONLY | O_CREAT | O_TRUNC)}, name_{io::printable_path(path)} {
  if (file_.get() < 0) fail(errno);
}

void FileOutput::fail(int error_number) {
  const bool full{error_number == ENOSPC || error_number == EDQUOT || error_number == EFBIG};
  const char* const mend{full ? "Free some space; the earlier part of the recording can be read."
                              : "Check the folder and its permissions."};
  error_text_ = fmt::format("{}: cannot be written ({}). {}", name_, reason(error_number), mend);
  // a part of a record would only be taken for damage; of a pipe nothing can be taken back
  if (file_.get() >= 0 && ::ftruncate(file_.get(), static_cast<off_t>(size_)) != 0) errno = 0;
  file_.close();
  throw DeviceError{error_text_};
}

void FileOutput::require_writable() const {
  if (!error_text_.empty()) throw DeviceError{error_text_};
}

void FileOutput::write_whole(View head, View body, View tail) {
  require_writable();
  std::array<iovec, 3> parts{};
  std::size_t count{0};
  for (const View part : {head, body, tail}) {
    parts[count++] = {const_cast<std::byte*>(part.data()), part.size()};
  }
  for (std::size_t first{0}; first < parts.size();) {
    const ssize_t result{::writev(file_.get(), &parts[first], static_cast<int>(parts.size() - first))};
    if (result < 0 && errno == EINTR) continue;
    if (result < 0) fail(errno);
    auto written{static_cast<std::size_t>(result)};
    for (; first < parts.size() && written >= parts[first].iov_len; ++first) written -= parts[first].iov_len;
    if (first == parts.size()) break;
    parts[first].iov_base = static_cast<std::byte*>(parts[first].iov_base) + written;
    parts[first].iov_len -= written;
  }
  size_ += head.size() + body.size() + tail.size();
}

void FileOutput::write(View bytes) {
  write_whole(bytes, {}, {});
  crc_ = crc_of(bytes, crc_);
}

void FileOutput::write(View head, View body, std::uint32_t body_crc, View tail) {
  write_whole(head, body, tail);
  crc_ = crc_of(tail, joined_crc(crc_of(head, crc_), body_crc, body.size()));
}

void FileOutput::close() {
  require_writable();
  if (const int error_number{file_.close()}; error_number != 0) fail(error_number);
}

FileInput::FileInput(const fs::path& path) : file_{-1}, name_{io::printable_path(path)} {
  struct stat status {};
  // before open(): opening a FIFO blocks, opening a device may have side effects
  if (::stat(path.c_str(), &status) != 0) fail_to_open(errno);
  if (!S_ISREG(status.st_mode)) throw InputError{name_, "is not a file on a disk.", "Copy the recording into a file."};
  file_ = Descriptor{open_uninterrupted(path, O_RDONLY | O_NONBLOCK)};
  if (file_.get() < 0 || ::fstat(file_.get(), &status) != 0) fail_to_open(errno);
  size_ = static_cast<std::uint64_t>(status.st_size);
}

void FileInput::fail_to_open(int error_number) const {
  const std::string why{fmt::format("cannot be read ({}).", reason(error_number))};
  if (io::is_temporary(error_number)) throw DeviceError{name_ + ": " + why + " Check the disk, then try again."};
  throw InputError{name_, why, "Check the path and its permissions."};
}

void FileInput::read(std::uint64_t at, std::span<std::byte> bytes) const {
  while (!bytes.empty()) {
    const ssize_t count{::pread(file_.get(), bytes.data(), bytes.size(), static_cast<off_t>(at))};
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) {
      throw DeviceError{
          fmt::format("{}: cannot be read at byte {} ({}). Check the disk, then try again.", name_, at, reason(errno))};
    }
    if (count == 0) {
      throw DeviceError{
          fmt::format("{}: was cut off at byte {} while it was read. Try again when it is whole.", name_, at)};
    }
    at += static_cast<std::uint64_t>(count);
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
}

void FileInput::read(std::uint64_t at, std::uint64_t size, Bytes& out) const {
  if (at > size_ || size > size_ - at) throw Malformed{"it reaches beyond the file's end"};
  out.resize(size);
  read(at, out);
}

}  // namespace stereogrid::mcap
