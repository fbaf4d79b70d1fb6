// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace stereogrid {

/// The version and a hash of all sources of the core, such as "0.1.0+2f7a…": equal in builds of the same sources, on
/// whatever machine. Written when the library is built (cmake/build_id.cmake). Ends with a zero.
[[nodiscard]] std::string_view build_id();

}  // namespace stereogrid
