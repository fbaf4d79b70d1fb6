// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "locks/descriptor.hpp"

namespace stereogrid::app {

/// Lock of a folder, exclusive among processes. The system releases it when a process ends; the file .lock of a killed
/// process has no effect.
class FolderLock {
 public:
  /// Creates the folder if there is none. Warns if the file system does not support locks. Throws DeviceError: another
  /// process has the lock, or the folder cannot be written.
  explicit FolderLock(const std::filesystem::path& folder);
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  ~FolderLock();

  /// False: the file system does not support locks.
  [[nodiscard]] bool keeps_others_out() const { return keeps_others_out_; }

 private:
  std::filesystem::path file_;
  Descriptor descriptor_;
  bool keeps_others_out_{true};
};

/// Returns whether a FolderLock exists for the folder, in any process. False where the file system has no locks.
[[nodiscard]] bool is_locked(const std::filesystem::path& folder);

}  // namespace stereogrid::app
