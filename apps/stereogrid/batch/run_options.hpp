// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "batch/input_digest.hpp"
#include "batch/plan.hpp"
#include "run/run.hpp"

namespace stereogrid::app::batch {

/// For Plan::run: what of the options decides about results and is the same for all shards.
[[nodiscard]] Json to_json(const RunOptions& options, bool evaluate);

/// And back again, for a shard that is worked on in a folder. `copies`: where copies of inputs lie that are read.
[[nodiscard]] RunOptions run_options(const Plan& plan, const Shard& shard, const std::filesystem::path& folder,
                                     const std::map<std::string, std::string>& copies = {});

/// All that is read of an input: its paths and the files that options name.
[[nodiscard]] std::vector<std::string> files_of(const InputOptions& input);

/// Of the input and all files that the options name. Throws InputError.
[[nodiscard]] std::string digest_of_input(const InputOptions& input, DigestOf what);

/// Are results to be scored where there is truth?
[[nodiscard]] bool is_evaluated(const Plan& plan);

}  // namespace stereogrid::app::batch
