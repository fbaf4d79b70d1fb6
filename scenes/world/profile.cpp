// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "world/profile.hpp"

#include <cmath>

namespace stereogrid::scenes {
namespace {

constexpr double far_m{1e6};

}  // namespace

Profile::Profile(const std::vector<Point>& points) {
  if (points.empty()) return;
  std::vector<Point> corners{{points.front().x - far_m, points.front().z}};
  corners.insert(corners.end(), points.begin(), points.end());
  corners.push_back({points.back().x + far_m, points.back().z});
  double along_m{corners.front().x};
  for (std::size_t i{0}; i + 1 < corners.size(); ++i) {
    const Vector3 step{corners[i + 1].x - corners[i].x, 0, corners[i + 1].z - corners[i].z};
    const double length_m{std::sqrt(dot(step, step))};
    pieces_.push_back({corners[i], (1 / length_m) * step, length_m, along_m});
    along_m += length_m;
  }
}

double Profile::height_at(double x) const {
  double height_m{0};
  for (const Piece& piece : pieces_) {
    if (x < piece.from.x) break;
    if (piece.tangent.x > 0) height_m = piece.from.z + (x - piece.from.x) * piece.tangent.z / piece.tangent.x;
  }
  return height_m;
}

bool Profile::crosses(Vector3 origin, Vector3 direction, Crossing& crossing) const {
  bool is_found{false};
  for (std::size_t i{0}; i < pieces_.size(); ++i) {
    const Piece& piece{pieces_[i]};
    const double towards{dot(normal(i), direction)};
    if (towards >= 0) continue;
    const Vector3 from{piece.from.x, 0, piece.from.z};
    const double t{dot(normal(i), from - origin) / towards};
    if (t <= 0 || (is_found && t >= crossing.t)) continue;
    const double along_m{dot(piece.tangent, origin + t * direction - from)};
    if (along_m < 0 || along_m > piece.length_m) continue;
    crossing = {t, i};
    is_found = true;
  }
  return is_found;
}

Vector3 Profile::normal(std::size_t piece) const {
  const Vector3 along{pieces_[piece].tangent};
  return {-along.z, 0, along.x};
}

double Profile::along(std::size_t piece, Vector3 point) const {
  const Piece& on{pieces_[piece]};
  return on.along_m + dot(on.tangent, point - Vector3{on.from.x, 0, on.from.z});
}

}  // namespace stereogrid::scenes
