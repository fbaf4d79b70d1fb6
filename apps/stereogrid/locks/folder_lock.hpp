// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "locks/descriptor.hpp"

namespace stereogrid::app {

/// Lock of a folder, exclusive among processes. The system releases it when a process ends; the file .lock of a killed
/// process has no effect.
class FolderLock {
 public:
  /// Creates the folder if there is none. Throws DeviceError: another process has the lock, or the folder cannot be
  /// written.
  explicit FolderLock(const std::filesystem::path& folder);
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  ~FolderLock();

  /// The file system does not support locks. Empty: other processes are kept out.
  [[nodiscard]] const std::string& warning() const { return warning_; }

 private:
  std::filesystem::path file_;
  Descriptor descriptor_;
  std::string warning_;
};

}  // namespace stereogrid::app
