// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"
#include "pipeline/journey.hpp"

namespace stereogrid {

std::unique_ptr<Journey> cpu_journey(const Config& config, const Rig& rig, int threads) {
  return std::make_unique<JourneyOn<Cpu>>(config, rig, vehicle_grid_of(config.grid), threads);
}

}  // namespace stereogrid
