// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "batch/plan.hpp"

namespace stereogrid::app::batch {

/// Serves a page with the numbers of status_of(), and /status.json, until somebody asks to stop. `listen`: a port, or
/// ADDRESS:PORT. Throws ConfigError, DeviceError; InputError: the plan is damaged when it begins.
void watch(const PlanReader& plan, const std::string& listen);

}  // namespace stereogrid::app::batch
