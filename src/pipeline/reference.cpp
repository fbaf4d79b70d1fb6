// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "backend/reference.hpp"
#include "pipeline/journey.hpp"

namespace stereogrid {

std::unique_ptr<Journey> reference_journey(const Config& config, const Rig& rig) {
  return std::make_unique<JourneyOn<Reference>>(config, rig, vehicle_grid_of(config.grid));
}

}  // namespace stereogrid
