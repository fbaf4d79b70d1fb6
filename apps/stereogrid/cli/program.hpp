// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "cli/cli_fwd.hpp"

namespace stereogrid::app {

/// Adds options and commands to a program; running it sets `exit_code` or throws.
using Describe = void (*)(CLI::App& program, int& exit_code);

/// main() of a program called `name`: sets up streams, log and memory, parses the command line, and turns exceptions
/// into messages and exit codes.
[[nodiscard]] int run_program(int argc, char** argv, const char* name, Describe describe);

}  // namespace stereogrid::app
