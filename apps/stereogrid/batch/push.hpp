// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "batch/plan.hpp"
#include "batch/transfer.hpp"

namespace stereogrid::app::batch {

/// Pushes a shard's result, if results are to be; with the same command only once, which a file in PLAN/pushed/ tells.
/// Throws DeviceError.
void push_result(const std::filesystem::path& plan, const Shard& shard, Transfer& transfer);

}  // namespace stereogrid::app::batch
