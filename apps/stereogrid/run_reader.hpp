// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "stereogrid/grid.hpp"
#include "stereogrid/obstacle.hpp"

namespace stereogrid::app {

/// A frame of a finished run, without its grids.
struct RunFrame {
  std::string name;
  std::int64_t stamp_ns{0};
  std::vector<Obstacle> obstacles;
};

/// The grids of a frame, vehicle frame.
struct RunGrids {
  Image<float> observed;
  Image<float> occupancy;
  Image<float> speed_mps;
};

/// Reads the folder that `stereogrid run` leaves.
class RunReader {
 public:
  /// Throws InputError.
  explicit RunReader(std::filesystem::path folder);

  [[nodiscard]] const GridGeometry& grid() const { return grid_; }
  [[nodiscard]] const std::vector<RunFrame>& frames() const { return frames_; }
  /// Throws InputError.
  [[nodiscard]] RunGrids grids(const std::string& name) const;

 private:
  std::filesystem::path folder_;
  GridGeometry grid_;
  std::vector<RunFrame> frames_;
};

}  // namespace stereogrid::app
