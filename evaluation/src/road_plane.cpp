// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "road_plane.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

namespace stereogrid::evaluation {
namespace {

constexpr double first_gate_m{0.35};
constexpr double gate_m{0.12};
constexpr int rounds{3};

bool may_be_road(const CameraPoint& p) {
  return p.z_m > 4 && p.z_m < 30 && std::abs(p.x_m) < 8;
}

/// Solves A·s = b given as rows [A | b]; none: A is singular.
std::optional<std::array<double, 3>> solve(std::array<std::array<double, 4>, 3> rows) {
  for (std::size_t i{0}; i < 3; ++i) {
    std::size_t pivot{i};
    for (std::size_t k{i + 1}; k < 3; ++k) {
      if (std::abs(rows[k][i]) > std::abs(rows[pivot][i])) pivot = k;
    }
    std::swap(rows[i], rows[pivot]);
    if (std::abs(rows[i][i]) < 1e-9) return std::nullopt;
    for (std::size_t k{0}; k < 3; ++k) {
      if (k == i) continue;
      const double factor{rows[k][i] / rows[i][i]};
      for (std::size_t j{i}; j < 4; ++j) rows[k][j] -= factor * rows[i][j];
    }
  }
  return std::array{rows[0][3] / rows[0][0], rows[1][3] / rows[1][1], rows[2][3] / rows[2][2]};
}

}  // namespace

RoadPlane fit_road(std::span<const CameraPoint> points, const RoadPlane& start) {
  RoadPlane plane{start};
  for (int round{0}; round < rounds; ++round) {
    const double gate{round == 0 ? first_gate_m : gate_m};
    std::array<std::array<double, 4>, 3> normal{};
    for (const CameraPoint& p : points) {
      if (!may_be_road(p) || !(std::abs(plane.height_of(p)) < gate)) continue;
      const std::array<double, 4> row{p.x_m, p.z_m, 1, p.y_m};
      for (std::size_t i{0}; i < 3; ++i) {
        for (std::size_t j{0}; j < 4; ++j) normal[i][j] += row[i] * row[j];
      }
    }
    const auto solution{solve(normal)};
    if (!solution) return plane;
    plane = {(*solution)[0], (*solution)[1], (*solution)[2]};
  }
  return plane;
}

}  // namespace stereogrid::evaluation
