// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>

#include "batch/plan.hpp"

namespace stereogrid::app::batch {

struct MergeOptions {
  std::filesystem::path out;
  bool allow_missing{false};
  bool runs{false};  ///< also a run's folder for every drive
};

/// How much of a plan was merged.
struct MergedFrames {
  std::uint64_t planned{0};  ///< that its shards write where none is skipped
  std::uint64_t merged{0};
};

/// Puts the results of a plan together, in the order of its manifest: the same bytes, in all files but timing.json,
/// whoever made the results, when and in which order. Throws InputError: shards are missing (with their numbers) or
/// damaged; ConfigError: the folder is not empty; DeviceError.
MergedFrames merge(const PlanReader& plan, const MergeOptions& options);

}  // namespace stereogrid::app::batch
