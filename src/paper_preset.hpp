// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stereogrid/config.hpp"

namespace stereogrid {

/// Sets every parameter to its value in preset `paper`, whatever it was: another default changes nothing in the paper's
/// preset. docs/paper.md has the reasons.
void set_paper_values(Config& config);

}  // namespace stereogrid
