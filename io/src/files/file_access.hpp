// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>

#include "stereogrid/error.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {

inline std::string reason(int error_number) {
  return std::generic_category().message(error_number);
}

/// An open file descriptor; below 0: opening it has failed.
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

/// A file that is missing, not accessible, or shorter than its size says. throw_unreadable() throws it, too.
class UnavailableFile : public InputError {
 public:
  using InputError::InputError;
};

/// Calls `read`, which reads files that a folder's listing has named. Throws DeviceError where one of them is
/// unavailable: frames that a file system has lost for a moment are not damaged.
template <class Read>
auto read_listed(Read read) {
  try {
    return read();
  } catch (const UnavailableFile& error) {
    throw DeviceError{std::string{error.what()} + " If its file system was away, try again."};
  }
}

}  // namespace stereogrid::io
