// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "run/folder_lock.hpp"

namespace stereogrid::app::batch {

/// A folder of this process alone below one that several share, removed with all in it. Those of processes that have
/// died are removed by the next one. Throws DeviceError: it cannot be made.
class ScratchFolder {
 public:
  explicit ScratchFolder(const std::filesystem::path& shared);
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder();

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  std::optional<FolderLock> lock_;
};

/// Of all files in folders of that kind, those of others, too.
[[nodiscard]] std::uint64_t scratch_bytes(const std::filesystem::path& shared);

/// "50G", "800M", "1000000": bytes; K, M, G, T are powers of 1000. Throws ConfigError.
[[nodiscard]] std::uint64_t bytes_of(const std::string& size);

}  // namespace stereogrid::app::batch
