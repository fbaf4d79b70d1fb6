// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

namespace stereogrid::app {

/// An open file descriptor, or none (-1).
class Descriptor {
 public:
  explicit Descriptor(int descriptor = -1) : descriptor_{descriptor} {}
  Descriptor(Descriptor&& other) noexcept : descriptor_{std::exchange(other.descriptor_, -1)} {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  ~Descriptor() { static_cast<void>(close()); }

  [[nodiscard]] int get() const { return descriptor_; }
  /// False with errno if data may be lost: network file systems report a full disk only here.
  [[nodiscard]] bool close();

 private:
  int descriptor_;
};

/// open(2), which signals do not interrupt.
[[nodiscard]] Descriptor open_file(const char* path, int flags);

/// All of it, in as many pieces as it takes. False with errno where it cannot be.
[[nodiscard]] bool write_all(int descriptor, std::string_view bytes);

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
