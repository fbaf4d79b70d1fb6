// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "stereogrid/server/http.hpp"

namespace stereogrid::app {

// Files that the build embeds into the program.

/// The page of viewer/; its front page is "/".
[[nodiscard]] std::vector<server::Asset> viewer_assets();

/// Parts of the report that `evaluate --html` writes; page.html has placeholders.
[[nodiscard]] std::vector<server::Asset> report_assets();

}  // namespace stereogrid::app
