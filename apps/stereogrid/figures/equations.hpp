// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "stereogrid/config.hpp"

namespace stereogrid::app::figures {

// The paper's formulas, to draw them; tests compare them with what the pipeline computes.

/// Eq. 13: P(C), r_O = N_O/N_V being the filled share of the visible rays.
[[nodiscard]] inline double obstacle_confidence(double observed_share, double tau_obstacle) {
  return 1 - std::exp(-observed_share / tau_obstacle);
}

/// Eq. 15: P(R), r_R being the share of road among the nine bins around.
[[nodiscard]] inline double road_confidence(double road_share, double observed_share, const UDisparityConfig& config) {
  return std::exp(-(1 - road_share) / config.tau_road) * std::exp(-observed_share / config.tau_obstacle);
}

/// Eq. 4: P(O).
[[nodiscard]] inline double obstacle_probability(double visibility, double confidence, const UDisparityConfig& config) {
  return visibility * confidence * (1 - config.false_positive) + visibility * (1 - confidence) * config.false_negative +
         (1 - visibility) / 2;
}

/// Eq. 14: P(T), kept within what a sensor with errors can know.
[[nodiscard]] inline double occupancy(double obstacle, double road, const UDisparityConfig& config) {
  return std::clamp(obstacle * (1 - road), config.false_negative, 1 - config.false_positive);
}

}  // namespace stereogrid::app::figures
