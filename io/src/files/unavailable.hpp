// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "stereogrid/error.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {

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
