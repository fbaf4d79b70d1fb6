// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace stereogrid {

/// Selects the plain loops that define what every stage computes. One thread, no tables that are not in the definition.
struct Reference {};

}  // namespace stereogrid
