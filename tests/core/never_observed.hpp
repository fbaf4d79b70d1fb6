// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "stereogrid/result.hpp"

namespace stereogrid::test {

/// Counts cells of the filtered grids that are known although no frame has observed them.
class NeverObservedCells {
 public:
  void add(const FrameResult& result) {
    // motion takes several frames; an obstacle beside the vehicle's grid is not confirmed
    has_moved_ = has_moved_ || std::ranges::any_of(result.obstacles, &Obstacle::moving);
    count(result.vehicle);
    count(result.world);
  }

  /// Cells that no moving obstacle explains: half of the mass must move.
  [[nodiscard]] int unfounded() const { return unfounded_; }

 private:
  void count(const GridLayers& layers) {
    for (std::size_t i{0}; i < layers.age_s.size(); ++i) {
      const float occupancy{layers.occupancy.data()[i]};
      const bool moves{occupancy > 0.5f && layers.moving.data()[i] > 0.5f};
      unfounded_ += std::isinf(layers.age_s.data()[i]) && is_known(occupancy) && !(moves && has_moved_) ? 1 : 0;
    }
  }

  bool has_moved_{false};
  int unfounded_{0};
};

}  // namespace stereogrid::test
