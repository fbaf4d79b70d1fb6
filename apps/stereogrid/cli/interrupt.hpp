// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace stereogrid::app {

/// From now on Ctrl-C (and SIGTERM) only ask to stop; a second one ends the program at once. So does SIGHUP, unless it
/// was ignored from the start; further ones change nothing.
void catch_interrupts();

/// Signal that requested a stop; 0: none.
[[nodiscard]] int interrupted();

}  // namespace stereogrid::app
