// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

#include "stereogrid/export.hpp"
#include "stereogrid/odometry.hpp"

namespace stereogrid::io {

/// State of a stopped run: that of pipeline and odometry after a frame.
struct Checkpoint {
  std::size_t index{0};  ///< index of the frame in the input
  std::vector<std::byte> pipeline;
  std::optional<OdometryState> odometry;  ///< none: the poses came with the input
};

/// After which frames of a run a checkpoint is written.
struct Checkpoints {
  std::size_t first;             ///< frame of the run
  std::size_t every;             ///< 0: never
  std::size_t results_every{1};  ///< as RunDescription::every: a checkpoint belongs to a frame that is written

  [[nodiscard]] bool is_due_after(std::size_t index) const {
    if (every == 0 || index < first || index % results_every != 0) return false;
    const std::size_t frames{index + 1 - first};
    const std::size_t before{frames > results_every ? frames - results_every : 0};  // up to the last written one
    return frames / every > before / every;
  }
};

/// state.npz in a run's folder. Replaces the one before; leaves whole files only. Throws DeviceError.
STEREOGRID_EXPORT void write_checkpoint(const std::filesystem::path& run_folder, const Checkpoint& checkpoint);

/// Removes what a killed run has left of one: nothing else may ever replace it.
STEREOGRID_EXPORT void remove_torn_checkpoint(const std::filesystem::path& run_folder);

/// None: there is none. Throws InputError: it is damaged.
[[nodiscard]] STEREOGRID_EXPORT std::optional<Checkpoint> read_checkpoint(const std::filesystem::path& run_folder);

}  // namespace stereogrid::io
