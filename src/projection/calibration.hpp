// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "projection/model.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

/// A monotone map from P(T_X) of the model to how often such cells were occupied. Fitted on two drives with lidar
/// (docs/method.md §6); 0.5, nothing known, stays 0.5.
///
/// Eq. 8 draws everything towards 0.5 that few rays reach, though an obstacle that two rays have met is as real as one
/// that twenty have: above 0.5 the map climbs at once.
class Calibration {
 public:
  Calibration();
  [[nodiscard]] float operator()(float probability) const;
  void apply(View<float> cells) const;

  /// As `calibrated` reads it.
  using Table = std::array<float, calibration_steps + 2>;
  [[nodiscard]] const Table& table() const { return table_; }

 private:
  Table table_{};
};

}  // namespace stereogrid
