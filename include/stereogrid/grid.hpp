// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string_view>

#include "stereogrid/image.hpp"

namespace stereogrid {

struct Point2 {
  double x{0};
  double y{0};
};

/// Which cell of a grid: column ix, row iy.
struct CellIndex {
  int ix{0};
  int iy{0};

  friend bool operator==(const CellIndex&, const CellIndex&) = default;
};

/// True if a probability of occupancy is observed. Values within 0.05 of 0.5 are unknown, as in the scores
/// (docs/evaluation.md). NaN is unknown.
[[nodiscard]] constexpr bool is_known(float occupancy) {
  return std::max(occupancy - 0.5f, 0.5f - occupancy) > 0.05f;  // no branch: loops become vectors
}

/// Position and size of a grid. Cell (ix, iy) covers [x_min + ix·s, +s) × [y_min + iy·s, +s), in metres. Arrays over a
/// grid are Image<T> of width nx and height ny: [iy, ix], x fastest.
struct GridGeometry {
  double x_min_m{0};
  double y_min_m{0};
  double cell_size_m{0.2};
  int nx{0};
  int ny{0};

  /// Middle of a cell, m.
  [[nodiscard]] Point2 centre(int ix, int iy) const {
    return {x_min_m + (ix + 0.5) * cell_size_m, y_min_m + (iy + 0.5) * cell_size_m};
  }
  /// The cell that holds a point, m; none: the point lies outside, or is none.
  [[nodiscard]] std::optional<CellIndex> cell_at(Point2 point) const {
    const double ix{std::floor((point.x - x_min_m) / cell_size_m)};
    const double iy{std::floor((point.y - y_min_m) / cell_size_m)};
    if (!(ix >= 0 && ix < nx && iy >= 0 && iy < ny)) return std::nullopt;
    return CellIndex{static_cast<int>(ix), static_cast<int>(iy)};
  }

  friend bool operator==(const GridGeometry&, const GridGeometry&) = default;
};

/// Ground of a cell for the vehicle (docs/terrain.md).
enum class TerrainClass : std::uint8_t {
  unknown,   ///< not seen, or not connected with the ground under the vehicle
  drivable,  ///< connected by steps and slopes within the vehicle's limits
  obstacle,  ///< higher than a step
  drop,      ///< edge with lower ground behind it
  hidden,    ///< behind an edge
};
constexpr std::array<std::string_view, 5> names_of(TerrainClass) {
  return {"unknown", "drivable", "obstacle", "drop", "hidden"};
}

/// Evidence that a cell can be driven on (docs/terrain.md). Cells without `ground`, `memory` or `source` are not free.
enum class Witness : std::uint8_t {
  none,      ///< no evidence
  passable,  ///< rays cross the cell, but ground was not seen: tall obstacles are unlikely, drops are not
  ground,    ///< ground seen in this frame, connected with the ground under the vehicle
  memory,    ///< ground seen in an earlier frame, at most VehicleConfig::ground_memory_s ago
  source,    ///< another source's grid
};
constexpr std::array<std::string_view, 5> names_of(Witness) {
  return {"none", "passable", "ground", "memory", "source"};
}

/// The witness of a cell in a byte: its kind in the lower four bits, the class of its age in the upper four. The
/// classes are powers of two: 0 is this frame, k up to 2^k/16 s ago.
struct CellWitness {
  std::uint8_t byte{0};

  [[nodiscard]] static constexpr CellWitness of(Witness kind, float age_s = 0) {
    unsigned age_class{0};
    while (age_class < 15 && age_s > greatest_age_s(age_class)) ++age_class;
    return {static_cast<std::uint8_t>(static_cast<unsigned>(kind) | age_class << 4U)};
  }
  [[nodiscard]] constexpr Witness kind() const { return static_cast<Witness>(byte & 15U); }
  /// Greatest age of the class, s.
  [[nodiscard]] constexpr float age_s() const { return greatest_age_s(byte >> 4U); }
  [[nodiscard]] constexpr bool allows_free() const { return kind() > Witness::passable; }
  friend bool operator==(const CellWitness&, const CellWitness&) = default;

 private:
  static constexpr float greatest_age_s(unsigned age_class) {
    return age_class == 0 ? 0.0f : static_cast<float>(1U << age_class) / 16;
  }
};

/// State of the filter for every cell of a grid. Velocities are relative to the ground, in the grid's axes, given that
/// the cell is occupied.
struct GridLayers {
  GridGeometry geometry;
  Image<float> occupancy;   ///< P(occupied) in [0, 1]; 0.5 = unknown
  Image<float> velocity_x;  ///< m/s, mean
  Image<float> velocity_y;
  Image<float> age_s;          ///< time since the cell was last observed; inf = never
  Image<float> velocity_xx{};  ///< m²/s², covariance of the velocity
  Image<float> velocity_xy{};
  Image<float> velocity_yy{};
  Image<float> moving{};  ///< P(occupied by a dynamic object); P(static) = occupancy − moving
};

}  // namespace stereogrid
