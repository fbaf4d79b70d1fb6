// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "cli/cli_fwd.hpp"

namespace stereogrid::app::batch {

/// Adds PLAN, an argument of every sub-command but `plan`.
void add_plan_argument(CLI::App& command, std::string& plan);

// Each adds a sub-command to `stereogrid batch`; running it sets `exit_code` or throws.
void add_plan_command(CLI::App& batch, int& exit_code);
void add_submit_command(CLI::App& batch, int& exit_code);

}  // namespace stereogrid::app::batch
