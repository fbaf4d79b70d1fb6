// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stereogrid/pipeline.hpp"

namespace stereogrid::fuzz {

/// Throws Finding where a number is not what its name promises: no probability, not finite, …
void check_result(const FrameResult& result);

}  // namespace stereogrid::fuzz
