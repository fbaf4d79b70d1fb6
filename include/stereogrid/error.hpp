// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>

#include "stereogrid/export.hpp"

// Messages may quote bytes of files, names and settings. All are printable (stereogrid/printable.hpp) and of bounded
// length.
namespace stereogrid {

/// Invalid setting: unknown key, value out of range, contradicting settings.
class STEREOGRID_EXPORT ConfigError : public std::runtime_error {
 public:
  explicit ConfigError(const std::string& message);
};

/// Unusable data. The message names the file, the fault and the remedy.
class STEREOGRID_EXPORT InputError : public std::runtime_error {
 public:
  explicit InputError(const std::string& message);
  InputError(const std::string& file, const std::string& what_is_wrong, const std::string& what_would_mend_it);
};

/// External failure that may be temporary: a full disk, a missing or busy device, an unavailable file system.
class STEREOGRID_EXPORT DeviceError : public std::runtime_error {
 public:
  explicit DeviceError(const std::string& message);
};

}  // namespace stereogrid
