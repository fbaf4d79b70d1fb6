// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <fstream>

#include "batch/plan.hpp"

namespace stereogrid::app::batch {

/// The results of a drive's shards as one run's folder (docs/format.md), which evaluate, export and view read.
class DriveRun {
 public:
  /// Its folder in `runs` has the drive's name, and, of several variants, ".v" and the variant's number.
  DriveRun(const std::filesystem::path& runs, const Shard& first, std::size_t variants);
  /// The next shard's result. Throws InputError, DeviceError.
  void add(const std::filesystem::path& result);
  /// Throws DeviceError.
  void finish();

 private:
  std::filesystem::path folder_;
  std::ofstream lines_;
  Json run_;
};

}  // namespace stereogrid::app::batch
