// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "cli_fwd.hpp"

namespace stereogrid::app::batch {

/// PLAN, which every sub-command but `plan` has.
void add_plan_argument(CLI::App& command, std::string& plan);

// Each adds a sub-command to `stereogrid batch`; running it sets `exit_code` or throws.
void add_plan_command(CLI::App& batch, int& exit_code);
void add_run_command(CLI::App& batch, int& exit_code);
void add_status_command(CLI::App& batch, int& exit_code);
void add_merge_command(CLI::App& batch, int& exit_code);
void add_submit_command(CLI::App& batch, int& exit_code);

}  // namespace stereogrid::app::batch
