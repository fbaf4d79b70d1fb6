// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "cli_fwd.hpp"
#include "stereogrid/server/http.hpp"

namespace stereogrid::app::batch {

/// Adds PLAN, an argument of every sub-command but `plan`.
void add_plan_argument(CLI::App& command, std::string& plan);

// Each adds a sub-command to `stereogrid batch`; running it sets `exit_code` or throws.
void add_plan_command(CLI::App& batch, int& exit_code);
void add_submit_command(CLI::App& batch, int& exit_code);

}  // namespace stereogrid::app::batch

namespace stereogrid::app {

/// Files of packaging/fleet/, which the build embeds into the program.
[[nodiscard]] std::vector<server::Asset> engine_templates();

}  // namespace stereogrid::app
