// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "stereogrid/server/http.hpp"

namespace stereogrid::app {

/// The page of viewer/, which the build has put into the program; its front page is "/".
[[nodiscard]] std::vector<server::Asset> viewer_assets();

}  // namespace stereogrid::app
