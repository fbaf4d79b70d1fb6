// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "batch/figures.hpp"
#include "batch/results.hpp"

namespace stereogrid::app::batch {

/// What a finished run leaves beside its files.
struct RunFacts {
  double seconds{0};       ///< of all runners of the shard
  bool keep_state{false};  ///< state.npz is handed on
  Json figures;            ///< figures.json
};

/// Makes a shard's result in the folder `result` from the run in the folder `run`, which stays as it is: its files
/// (linked where that can be done), but what depends on when and where it was made goes from run.json and frames.jsonl
/// into timing.json. What lies in `result` is removed first. Returns frames and skipped of it. Throws DeviceError,
/// InputError.
[[nodiscard]] Done make_result(const std::filesystem::path& run, const std::filesystem::path& result,
                               const RunFacts& facts);

/// A file under another name: linked, or, where that cannot be done, copied. Throws DeviceError.
void link_or_copy(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace stereogrid::app::batch
