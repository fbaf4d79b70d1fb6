// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "images/patch.hpp"

namespace stereogrid {

/// The pixels of the left image whose disparities the host reads whatever back end found them; patches are cut around
/// them: (first_u + i·step_u, first_v + j·step_v).
struct MatchLattice {
  static constexpr int step_u{6};
  static constexpr int step_v{6};
  static constexpr int first_u{patch_reach_u + 1};
  static constexpr int first_v{patch_reach_v + 1};

  MatchLattice(int width, int height)
      : across{std::max(width - patch_reach_u - first_u + step_u - 1, 0) / step_u},
        down{std::max(height - patch_reach_v - 1 - first_v + step_v - 1, 0) / step_v} {}

  int across;
  int down;
};

}  // namespace stereogrid
