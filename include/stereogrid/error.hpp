// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>

#include "stereogrid/export.hpp"

namespace stereogrid {

/// A setting that cannot work: unknown key, value out of range, settings that contradict each other.
class STEREOGRID_EXPORT ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Data that cannot be used. The message names the file, says what is wrong with it and what would mend it.
class STEREOGRID_EXPORT InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  InputError(const std::string& file, const std::string& what_is_wrong, const std::string& what_would_mend_it)
      : std::runtime_error{file + ": " + what_is_wrong + " " + what_would_mend_it} {}
};

/// Something outside that may work later: a full disk, a missing or busy device, a file system that is away.
class STEREOGRID_EXPORT DeviceError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace stereogrid
