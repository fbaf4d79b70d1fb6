// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

#include "stereogrid/export.hpp"
#include "stereogrid/io/odometry.hpp"

namespace stereogrid::io {

/// What a run that was stopped goes on from: what pipeline and odometry remembered after a frame.
struct Checkpoint {
  std::size_t index{0};  ///< of the frame, in the input
  std::vector<std::byte> pipeline;
  std::optional<OdometryState> odometry;  ///< none: the poses came with the input
};

/// After which frames of a run a checkpoint is written.
struct Checkpoints {
  std::size_t first;  ///< frame of the run
  std::size_t every;  ///< 0: never

  [[nodiscard]] bool is_due_after(std::size_t index) const {
    return every > 0 && index >= first && (index + 1 - first) % every == 0;
  }
};

/// state.npz in a run's folder. Replaces the one before; leaves whole files only. Throws DeviceError.
STEREOGRID_EXPORT void write_checkpoint(const std::filesystem::path& run_folder, const Checkpoint& checkpoint);

/// Removes what a killed run has left of one: nothing else may ever replace it.
STEREOGRID_EXPORT void remove_torn_checkpoint(const std::filesystem::path& run_folder);

/// None: there is none. Throws InputError: it is damaged.
[[nodiscard]] STEREOGRID_EXPORT std::optional<Checkpoint> read_checkpoint(const std::filesystem::path& run_folder);

}  // namespace stereogrid::io
