// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "batch/plan.hpp"
#include "run/run.hpp"

namespace stereogrid::app::batch {

/// What is merged does not tell where it was worked on: neither the folder `work` nor copies of the input.
[[nodiscard]] std::string without_place(std::string text, const std::filesystem::path& work,
                                        const std::map<std::string, std::string>& copies);

/// figures.json of a finished run with these options: scores, or why there are none; null: there is no truth.
[[nodiscard]] Json scores_of(const RunOptions& run, const std::filesystem::path& work);

}  // namespace stereogrid::app::batch
