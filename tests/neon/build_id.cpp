// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// In place of what cmake/build_id.cmake writes.
#include "pipeline/build_id.hpp"

namespace stereogrid {

std::string_view build_id() {
  return "neon";
}

}  // namespace stereogrid
