// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "batch/plan.hpp"

namespace stereogrid::app::batch {

/// A page of HTML that needs nothing else: counts, and each configuration's figures with intervals; of a sweep also
/// which configurations no other one is better than in both of missed and false alarms. `summary`: summary.json of a
/// merged folder.
[[nodiscard]] std::string summary_page(const Json& summary);

}  // namespace stereogrid::app::batch
