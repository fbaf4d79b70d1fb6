// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace stereogrid::app {

class Command;

/// Exit codes of the program.
enum ExitCode : int {
  exit_done = 0,
  exit_usage = 64,         ///< wrong arguments or settings
  exit_input = 65,         ///< input that cannot be used
  exit_bug = 70,           ///< our fault
  exit_try_again = 75,     ///< disk full, device missing, input away
  exit_signal_base = 128,  ///< plus the number of the signal that stopped us
};

// Each adds a sub-command to the tool; running it sets `exit_code` or throws.
void add_run_command(Command tool, int& exit_code);
void add_simulate_command(Command tool, int& exit_code);
void add_evaluate_command(Command tool, int& exit_code);
void add_export_command(Command tool, int& exit_code);
void add_info_command(Command tool, int& exit_code);
void add_live_command(Command tool, int& exit_code);
void add_view_command(Command tool, int& exit_code);
void add_config_command(Command tool);

}  // namespace stereogrid::app
