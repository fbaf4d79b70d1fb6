// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "images/patch.hpp"

namespace stereogrid {

constexpr float longest_step_px{0.7f};

/// A step of find(): how far the patch moves, px. `along_u`, `along_v`: its gradients times what is left of it.
inline Place step_of(const Template& patch, double along_u, double along_v) {
  const double determinant{patch.uu * patch.vv - patch.uv * patch.uv};
  const auto limited = [](double move) {
    return std::clamp(static_cast<float>(move), -longest_step_px, longest_step_px);
  };
  return {limited((patch.vv * along_u - patch.uv * along_v) / determinant),
          limited((patch.uu * along_v - patch.uv * along_u) / determinant)};
}

/// Far below what it errs by.
inline bool is_short(const Place& step) {
  constexpr float short_px{0.01f};
  return std::abs(step.u) < short_px && std::abs(step.v) < short_px;
}

/// `left`: the sum of squares that is left of the patch.
inline bool fits(const Template& patch, double left) {
  constexpr double misfit_max{0.2};
  return left <= misfit_max * patch.variance;
}

}  // namespace stereogrid
