// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "locks/descriptor.hpp"

namespace stereogrid::app {

/// As long as it lives, no other process has one for the same folder. The system lets go of it when a process ends,
/// however it ends; what a killed one leaves of it (the file .lock) is in nobody's way.
class FolderLock {
 public:
  /// Makes the folder if there is none. Where the file system knows no locks: a warning. Throws DeviceError: another
  /// process has it, or the folder cannot be written.
  explicit FolderLock(const std::filesystem::path& folder);
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  ~FolderLock();

  /// False: the file system knows no locks, and nobody is kept out.
  [[nodiscard]] bool keeps_others_out() const { return keeps_others_out_; }

 private:
  std::filesystem::path file_;
  Descriptor descriptor_;
  bool keeps_others_out_{true};
};

/// Returns whether a FolderLock exists for the folder, in any process. False where the file system has no locks.
[[nodiscard]] bool is_locked(const std::filesystem::path& folder);

}  // namespace stereogrid::app
