// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "world/shapes.hpp"

namespace stereogrid::scenes {

/// Height of the ground along x, the same for every y: straight pieces between points, level before the first and after
/// the last one. Two points of equal x are a vertical step. No points: the plane z = 0.
class Profile {
 public:
  struct Point {
    double x{0};
    double z{0};
  };
  /// Where a ray meets the ground: at origin + t · direction.
  struct Crossing {
    double t{0};
    std::size_t piece{0};  ///< 0: the level ground before the first point
  };

  Profile() = default;
  /// `points` by ascending x; the first one has z = 0, as the vehicle stands before it.
  explicit Profile(const std::vector<Point>& points);

  [[nodiscard]] bool is_flat() const { return pieces_.empty(); }
  /// The ground's height; at a vertical step that of its far side.
  [[nodiscard]] double height_at(double x) const;
  /// Finds the first crossing from above with t > 0. A ray that starts below the ground has none.
  [[nodiscard]] bool crosses(Vector3 origin, Vector3 direction, Crossing& crossing) const;

  /// Unit vectors of a piece: along it, away from the first point, and out of the ground.
  [[nodiscard]] Vector3 tangent(std::size_t piece) const { return pieces_[piece].tangent; }
  [[nodiscard]] Vector3 normal(std::size_t piece) const;
  /// Distance along the ground from x = 0.
  [[nodiscard]] double along(std::size_t piece, Vector3 point) const;

 private:
  struct Piece {
    Point from;
    Vector3 tangent;
    double length_m{0};
    double along_m{0};  ///< of `from`
  };
  std::vector<Piece> pieces_;
};

}  // namespace stereogrid::scenes
