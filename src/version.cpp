// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <string_view>

#include "stereogrid/pipeline.hpp"

namespace stereogrid {

std::string_view version() {
  return STEREOGRID_VERSION;
}

}  // namespace stereogrid
