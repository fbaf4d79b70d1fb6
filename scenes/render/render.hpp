// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "render/caster.hpp"
#include "stereogrid/image.hpp"
#include "world/world.hpp"

namespace stereogrid::scenes {

/// Noise and response of the sensor.
struct Sensor {
  double gain{1};
  double noise_grey{0};
  std::uint64_t seed{0};
};

/// Renders the image of the caster's camera. Runs on the threads of the current TBB arena.
[[nodiscard]] Image<std::uint8_t> render(const World& world, const Caster& caster, const Sensor& sensor);

}  // namespace stereogrid::scenes
