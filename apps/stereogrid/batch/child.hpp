// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace stereogrid::app::batch {

/// Runs a program without a shell and waits for it; what it says goes to the standard error output. `trouble` is asked
/// ten times a second: when it says something, or after `limit_s`, the program and its children are ended (SIGTERM,
/// after 5 s SIGKILL), as they are where this process dies. Returns what went wrong; "": exit code 0.
[[nodiscard]] std::string run_child(const std::vector<std::string>& words, int limit_s,
                                    const std::function<std::string()>& trouble);

}  // namespace stereogrid::app::batch
