// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <unordered_map>

#include "baselines/baselines.hpp"
#include "stereogrid/evaluation/ray_fan.hpp"

namespace stereogrid::research {

/// Point-cloud ray casting: obstacle points are hits, road points free ends, cells on the way are cleared by a grid
/// traversal; a hit outweighs what passes above it.
[[nodiscard]] Image<float> ray_casting_grid(const DisparityFrame& frame, const GridGeometry& grid,
                                            const evaluation::LogOddsParameters& parameters = {});

/// The same over time: the log-odds of all frames summed in the world, which is taken to stand still.
class LogOddsMap {
 public:
  explicit LogOddsMap(double weight_of_frame = 0.8, const evaluation::LogOddsParameters& parameters = {
                                                        .hit = 0.6, .any_pass = 0.5, .lowest = -3, .highest = 4});

  /// Adds a frame and gives the map as it lies under a grid in the vehicle frame.
  [[nodiscard]] Image<float> update(const DisparityFrame& frame, const Pose2& world_from_vehicle,
                                    const GridGeometry& grid);

 private:
  double weight_;
  evaluation::LogOddsParameters parameters_;
  std::unordered_map<std::int64_t, float> cells_;
};

}  // namespace stereogrid::research
