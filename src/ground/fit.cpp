// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "ground/fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace stereogrid {
namespace {

Vector3 row_of(const RoadPlane& plane, const GroundSample& sample) {
  return {1, (sample.u - plane.cx_px) / 100, (sample.v - plane.cy_px) / 100};
}

NormalEquations equations_of(std::span<const GroundSample> samples, const RoadPlane& plane, double radius_px) {
  NormalEquations equations;
  for (const GroundSample& sample : samples) {
    const double r{residual(plane, sample)};
    const double t{square_of_share(r, radius_px)};
    if (t < 1) equations.add(row_of(plane, sample), (1 - t) * (1 - t), r);
  }
  equations.complete();
  return equations;
}

// Radius beyond which residuals have no weight.
double radius_of(std::span<const GroundSample> samples, const RoadPlane& plane) {
  std::array<int, residual_bins> counts{};
  int total{0};
  for (const GroundSample& sample : samples) {
    const double bin{std::abs(residual(plane, sample)) * residual_bins_per_px};
    if (!(bin < residual_bins)) continue;
    ++counts[static_cast<std::size_t>(bin)];
    ++total;
  }
  return radius_of_bin(median_bin([&](int bin) { return counts[static_cast<std::size_t>(bin)]; }, total));
}

void sum_squares(const std::vector<Vector3>& scores, FitSums& sums) {
  for (const Vector3& score : scores) {
    if (score[0] == 0 && score[1] == 0 && score[2] == 0) continue;
    ++sums.blocks;
    for (int i{0}; i < 3; ++i) {
      for (int j{0}; j < 3; ++j) sums.spread[i][j] += score[i] * score[j];
    }
  }
}

}  // namespace

GroundSpace::GroundSpace(int width, int height)
    : scores(static_cast<std::size_t>((width / block_u_px + 1) * (height / block_v_px + 1))),
      blocks_across{width / block_u_px + 1} {
  samples.reserve(2 * static_cast<std::size_t>(width / lattice_px + 1) *
                  static_cast<std::size_t>(height / lattice_px + 1));
}

void add_samples(View<const float> disparity, double first_row, std::vector<GroundSample>& samples) {
  const int first{lattice_row(first_row, disparity.height)};
  for (int v{first * lattice_px + lattice_px / 2}; v < disparity.height; v += lattice_px) {
    const float* row{disparity.row(v)};
    for (int u{lattice_px / 2}; u < disparity.width; u += lattice_px) {
      if (row[u] > 0) samples.push_back({static_cast<float>(u), static_cast<float>(v), row[u]});
    }
  }
}

double refine(std::span<const GroundSample> samples, const Matrix3& covariance, RoadPlane& plane) {
  const Vector3 start{numbers_of(plane)};
  const Matrix3 tether{tether_of(covariance)};
  double radius_px{0};
  for (int round{0}; round < fit_rounds_max; ++round) {
    radius_px = round < wide_rounds ? wide_radius_px(round) : radius_of(samples, plane);
    const double largest_step{fit_step(equations_of(samples, plane, radius_px), tether, start, plane)};
    if (largest_step < 0) return 0;
    if (has_settled(round, largest_step)) break;
  }
  return radius_px;
}

bool measure(const RoadPlane& plane, double radius_px, GroundSpace& space, PlaneMeasurement& measurement) {
  FitSums sums;
  std::fill(space.scores.begin(), space.scores.end(), Vector3{});
  for (const GroundSample& sample : space.samples) {
    const double r{residual(plane, sample)};
    const double t{square_of_share(r, radius_px)};
    if (t >= 1) continue;
    const Vector3 row{row_of(plane, sample)};
    const double weight{(1 - t) * (1 - t)};
    sums.equations.add(row, weight, r);
    sums.weights += weight;
    sums.slopes += (1 - t) * (1 - 5 * t);  // the derivative of weight·r
    const int block{static_cast<int>(sample.v) / block_v_px * space.blocks_across +
                    static_cast<int>(sample.u) / block_u_px};
    Vector3& score{space.scores[static_cast<std::size_t>(block)]};
    for (int i{0}; i < 3; ++i) score[i] += weight * r * row[i];
  }
  sums.equations.complete();
  sum_squares(space.scores, sums);
  return measured(plane, sums, measurement);
}

}  // namespace stereogrid
