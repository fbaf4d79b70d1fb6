// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "motion/scene_flow.hpp"

namespace stereogrid::test {

inline FlowVector vector_at(Point2 place, Point2 velocity, double sigma_mps = 0.5) {
  const double variance{sigma_mps * sigma_mps};
  return {place, {0.01, 0, 0.01}, velocity, {variance, 0, variance}};
}

}  // namespace stereogrid::test
