// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "terrain/trenches.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "held_bytes.hpp"

namespace stereogrid {
namespace {

// Chosen on random layouts (seeds 401 to 480) and on recorded drives, where few matches may look like a trench.
constexpr int sectors_beside{3};
constexpr std::array wall_rows_tried{6, 7, 8, 10, 12, 14, 17, 20, 24};
constexpr float fall_share_min{0.7f};  ///< measured fall of the disparity, relative to that of an upright wall
constexpr float fall_share_max{1.6f};
constexpr float ground_growth_min{0.5f};  ///< growth of the disparity per row around it, relative to level ground
constexpr float rows_seen_min{0.8f};
constexpr float rest_max_px{0.1f};     ///< root mean square difference from the best shape
constexpr float rest_floor_px{0.08f};  ///< noise of the mean of sectors
constexpr float gain_min{130};         ///< decrease of the squared differences by the wall, in squared noises

/// Line with a wall, d = at_edge + growth·k − fall·shape(k), through a sector's rows k around an edge.
struct Fit {
  float at_edge{0};
  float growth{0};
  float fall{0};
  float rest_px{0};
  float gain{0};  ///< over the line without a wall
};

/// Sums of a least-squares fit; row 0 of `x`: constant, 1: row, 2: shape.
struct Sums {
  std::array<std::array<float, 3>, 3> xx{};
  std::array<float, 3> xy{};
  float yy{0};

  void add(const std::array<float, 3>& x, float y) {
    for (std::size_t i{0}; i < 3; ++i) {
      for (std::size_t j{0}; j <= i; ++j) xx[i][j] += x[i] * x[j];
      xy[i] += x[i] * y;
    }
    yy += y * y;
  }
};

// By Cholesky's decomposition; the squared rest falls by beta² with each unknown.
Fit fitted(const Sums& sums) {
  std::array<std::array<float, 3>, 3> l{};
  std::array<float, 3> beta{};
  for (std::size_t i{0}; i < 3; ++i) {
    for (std::size_t j{0}; j <= i; ++j) {
      float rest{sums.xx[i][j]};
      for (std::size_t k{0}; k < j; ++k) rest -= l[i][k] * l[j][k];
      l[i][j] = i == j ? std::sqrt(std::max(rest, 1e-6f)) : rest / l[j][j];
    }
    float rest{sums.xy[i]};
    for (std::size_t k{0}; k < i; ++k) rest -= l[i][k] * beta[k];
    beta[i] = rest / l[i][i];
  }
  const float fall{beta[2] / l[2][2]};
  const float growth{(beta[1] - l[2][1] * fall) / l[1][1]};
  const float rows{sums.xx[0][0]};
  const float squares{std::max(sums.yy - beta[0] * beta[0] - beta[1] * beta[1] - beta[2] * beta[2], 0.0f)};
  return {(beta[0] - l[1][0] * growth - l[2][0] * fall) / l[0][0], growth, -fall, std::sqrt(squares / rows),
          beta[2] * beta[2] / (squares / rows + rest_floor_px * rest_floor_px)};
}

// Mean disparity of a sector and its neighbours by row, from at least half of them; 0: none.
void write_means(const TerrainSamples& samples, int sector, float* mean) {
  std::array<const float*, 2 * sectors_beside + 1> disparities{};
  for (int i{0}; i <= 2 * sectors_beside; ++i) {
    const int beside{std::clamp(sector - sectors_beside + i, 0, samples.sectors() - 1)};
    disparities[static_cast<std::size_t>(i)] = samples.rows(beside).disparity;
  }
  const SectorRows rows{samples.rows(sector)};
  for (int v{rows.first_row}; v < rows.end_row; ++v) {
    float sum{0};
    float count{0};
    for (const float* const disparity : disparities) {
      sum += disparity[v];
      count += disparity[v] > 0 ? 1.0f : 0.0f;
    }
    mean[v] = count > sectors_beside ? sum / count : 0.0f;
  }
}

// The disparities are below the line through the first and the last one by most of a wall's fall: at the edge, before
// it and in the middle of the wall.
bool falls(const float* d, const std::vector<float>& fall, int wall_rows, float growth) {
  constexpr float share{0.8f * fall_share_min};
  const std::size_t last{fall.size() - 1};
  const std::size_t edge{(last + static_cast<std::size_t>(wall_rows)) / 2};
  const float per_row{(d[last] - d[0]) / static_cast<float>(last)};
  if (!(d[0] > 0) || per_row < ground_growth_min * growth) return false;
  for (const std::size_t i : {edge, edge + 2, edge - static_cast<std::size_t>(wall_rows) / 2}) {
    const float below{d[0] + per_row * static_cast<float>(i) - d[i]};
    if (!(d[i] > 0) || below < share * growth * fall[i]) return false;
  }
  return true;
}

}  // namespace

TrenchFilter::TrenchFilter(int height_px, int sectors, int window_rows)
    : disparity_{height_px, sectors}, margin_{window_rows + 1} {
  for (const int wall_rows : wall_rows_tried) {
    Shape shape{wall_rows, std::vector<float>(static_cast<std::size_t>(wall_rows + 2 * margin_ + 1), 0.0f)};
    for (std::size_t i{0}; i < shape.fall.size(); ++i) {
      const int above{wall_rows + margin_ - static_cast<int>(i)};  // rows above the edge
      float sum{0};
      for (int row{above - window_rows / 2}; row <= above + window_rows / 2; ++row) {
        if (row >= 0 && row <= wall_rows) sum += static_cast<float>(wall_rows - row);
      }
      shape.fall[i] = sum / static_cast<float>(window_rows);
    }
    shapes_.push_back(std::move(shape));
  }
}

std::optional<Trench> TrenchFilter::find(const TerrainCamera& camera, const TerrainLimits& limits,
                                         const TerrainSamples& samples, int sector) {
  const SectorRows rows{samples.rows(sector)};
  float* const disparity{disparity_.row(sector)};
  write_means(samples, sector, disparity);
  const float growth{camera.level_growth(camera.height_m)};
  std::optional<Trench> found;
  float best_gain{gain_min};
  for (int edge{rows.end_row - 1 - margin_}; edge > rows.first_row; --edge) {
    if (rows.tangent(static_cast<float>(edge)) < limits.drop_slope) break;
    const float at_edge{disparity[edge]};
    if (!(at_edge > 0)) continue;
    for (const Shape& shape : shapes_) {
      const int first{edge - shape.wall_rows - margin_};
      if (first < rows.first_row) break;
      const float* const d{disparity + first};
      const auto at = static_cast<std::size_t>(shape.wall_rows + margin_);
      if (!falls(d, shape.fall, shape.wall_rows, growth)) continue;  // saves most of the work
      Sums sums;
      for (std::size_t i{0}; i < shape.fall.size(); ++i) {
        if (d[i] > 0) sums.add({1, static_cast<float>(i) - static_cast<float>(at), shape.fall[i]}, d[i] - at_edge);
      }
      if (sums.xx[0][0] < rows_seen_min * static_cast<float>(shape.fall.size())) continue;
      const Fit fit{fitted(sums)};
      const bool is_trench{fit.gain > best_gain && fit.rest_px < rest_max_px && fit.fall > fall_share_min * growth &&
                           fit.fall < fall_share_max * growth && fit.growth > ground_growth_min * growth};
      if (!is_trench) continue;
      best_gain = fit.gain;
      const float edge_x{camera.range(at_edge + fit.at_edge)};
      const float wall_x{
          camera.range(std::max(at_edge + fit.at_edge - fit.growth * static_cast<float>(shape.wall_rows), 1.0f))};
      found = Trench{edge_x, wall_x, static_cast<float>(shape.wall_rows) * camera.tangent_per_v * wall_x};
    }
  }
  return found;
}

std::size_t TrenchFilter::held_bytes() const {
  std::size_t bytes{held_bytes_of(disparity_)};
  for (const Shape& shape : shapes_) bytes += sizeof(Shape) + held_bytes_of(shape.fall);
  return bytes;
}

}  // namespace stereogrid
