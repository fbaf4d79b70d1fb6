// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stereogrid/frame.hpp"

namespace stereogrid {

/// a_from_b · b_from_c, exactly the other pose if one is the identity.
[[nodiscard]] inline Pose2 composed(const Pose2& a_from_b, const Pose2& b_from_c) {
  if (a_from_b == Pose2{}) return b_from_c;
  return b_from_c == Pose2{} ? a_from_b : a_from_b * b_from_c;
}

}  // namespace stereogrid
