// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>

namespace stereogrid::app::batch {

/// attempts.json in the folder where a shard is worked on: how its runners have ended.
struct Attempts {
  int without_progress{0};  ///< runners in a row that ended without a word and had finished no frame more
  std::uint64_t frames{0};  ///< that were finished when the last one began
  double seconds{0};        ///< of all runners that have said so
};

/// None yet: zeros, as where the file is damaged.
[[nodiscard]] Attempts read_attempts(const std::filesystem::path& work);
/// Throws DeviceError.
void write_attempts(const std::filesystem::path& work, const Attempts& attempts);

/// Counts another runner that begins, where `frames` are finished.
[[nodiscard]] Attempts begin_attempt(Attempts before, std::uint64_t frames);

/// Lines of a run's frames.jsonl.
[[nodiscard]] std::uint64_t finished_frames(const std::filesystem::path& run);

}  // namespace stereogrid::app::batch
