// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "ground/fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace stereogrid {
namespace {

constexpr int lattice_px{4};
// Errors of pixels within a block are taken as one error, those of different blocks as independent.
constexpr int block_u_px{96};
constexpr int block_v_px{32};
// Standard deviations, in px and px per 100 px, of what all pixels of a frame have in common: kerbs and the feet of
// obstacles taken for road, which is worst far away. From the synthetic sets, whose plane is known.
constexpr Vector3 common_error_px{0.03, 0.004, 0.02};

Vector3 row_of(const RoadPlane& plane, const GroundSample& sample) {
  return {1, (sample.u - plane.centre_u_px) / 100, (sample.v - plane.centre_v_px) / 100};
}

struct NormalEquations {
  Matrix3 matrix{};
  Vector3 vector{};
  std::size_t inliers{0};

  void add(const Vector3& row, double weight, double r) {
    ++inliers;
    for (std::size_t i{0}; i < 3; ++i) {
      vector[i] += weight * r * row[i];
      for (std::size_t j{0}; j <= i; ++j) matrix[i][j] += weight * row[i] * row[j];
    }
  }
  void complete() {
    for (std::size_t i{0}; i < 3; ++i) {
      for (std::size_t j{i + 1}; j < 3; ++j) matrix[i][j] = matrix[j][i];
    }
  }
};

// Tukey's weight is (1 − t)² with t = (r/radius)², below 1.
double square_of_share(double r, double radius_px) {
  return r * r / (radius_px * radius_px);
}

NormalEquations equations_of(const std::vector<GroundSample>& samples, const RoadPlane& plane, double radius_px) {
  NormalEquations equations;
  for (const GroundSample& sample : samples) {
    const double r{residual(plane, sample)};
    const double t{square_of_share(r, radius_px)};
    if (t < 1) equations.add(row_of(plane, sample), (1 - t) * (1 - t), r);
  }
  equations.complete();
  return equations;
}

// The residual beyond which a pixel no longer counts.
double radius_of(const std::vector<GroundSample>& samples, const RoadPlane& plane) {
  constexpr int bins_per_px{25};
  constexpr std::size_t bins{50};
  constexpr double medians{4};
  constexpr double least_px{0.4};
  constexpr double most_px{2.5};
  std::array<std::size_t, bins> counts{};
  std::size_t total{0};
  for (const GroundSample& sample : samples) {
    const double bin{std::abs(residual(plane, sample)) * bins_per_px};
    if (bin >= static_cast<double>(bins)) continue;
    ++counts[static_cast<std::size_t>(bin)];
    ++total;
  }
  std::size_t median{0};
  std::size_t below{counts[0]};
  while (median + 1 < bins && 2 * below < total) below += counts[++median];
  return std::clamp(medians * (static_cast<double>(median) + 0.5) / bins_per_px, least_px, most_px);
}

Matrix3 sum_of_squares(const std::vector<Vector3>& scores, double& blocks) {
  Matrix3 sum{};
  blocks = 0;
  for (const Vector3& score : scores) {
    if (score == Vector3{}) continue;
    ++blocks;
    for (std::size_t i{0}; i < 3; ++i) {
      for (std::size_t j{0}; j < 3; ++j) sum[i][j] += score[i] * score[j];
    }
  }
  return sum;
}

}  // namespace

GroundSpace::GroundSpace(int width, int height)
    : scores(static_cast<std::size_t>((width / block_u_px + 1) * (height / block_v_px + 1))),
      blocks_across{width / block_u_px + 1} {
  samples.reserve(2 * static_cast<std::size_t>(width / lattice_px + 1) *
                  static_cast<std::size_t>(height / lattice_px + 1));
}

void add_samples(View<const float> disparity, double first_row, std::vector<GroundSample>& samples) {
  const int first{static_cast<int>(std::clamp(first_row, 0.0, static_cast<double>(disparity.height)))};
  for (int v{first / lattice_px * lattice_px + lattice_px / 2}; v < disparity.height; v += lattice_px) {
    const float* row{disparity.row(v)};
    for (int u{lattice_px / 2}; u < disparity.width; u += lattice_px) {
      if (row[u] > 0) samples.push_back({static_cast<float>(u), static_cast<float>(v), row[u]});
    }
  }
}

Vector3 numbers_of(const RoadPlane& plane) {
  return {plane.at_centre, 100 * plane.per_u, 100 * plane.per_v};
}

Matrix3 numbers_by_ground(const Rig& rig, const Ground& ground) {
  return diagonal({1, 100, 100}) * plane_by_ground(rig, ground);
}

void move(RoadPlane& plane, const Vector3& numbers) {
  plane.at_centre += numbers[0];
  plane.per_u += numbers[1] / 100;
  plane.per_v += numbers[2] / 100;
}

double refine(const std::vector<GroundSample>& samples, const Matrix3& covariance, RoadPlane& plane) {
  // px²; what one pixel is worth, so that the tether holds only what the pixels leave open
  constexpr double pixel_variance{9};
  const Vector3 start{numbers_of(plane)};
  const Matrix3 tether{scaled(pixel_variance, inverse(covariance))};
  // Wide at first, and until it settles: a cambered road has planes that each hold a part of it, and where this ends
  // must not depend on where it began.
  constexpr std::array<double, 2> first_radii_px{4, 2.5};
  constexpr std::size_t rounds_max{12};
  constexpr double settled_px{0.002};
  double radius_px{0};
  for (std::size_t round{0}; round < rounds_max; ++round) {
    radius_px = round < first_radii_px.size() ? first_radii_px[round] : radius_of(samples, plane);
    const NormalEquations equations{equations_of(samples, plane, radius_px)};
    if (equations.inliers < ground_samples_min) return 0;
    const Vector3 step{inverse(equations.matrix + tether) * (equations.vector - tether * (numbers_of(plane) - start))};
    move(plane, step);
    if (!(plane.per_v > 0)) return 0;
    const double most{std::max({std::abs(step[0]), std::abs(step[1]), std::abs(step[2])})};
    if (round > first_radii_px.size() && most < settled_px) break;
  }
  return radius_px;
}

bool measure(const RoadPlane& plane, double radius_px, GroundSpace& space, PlaneMeasurement& measurement) {
  NormalEquations equations;
  double weights{0};
  double slopes{0};
  std::fill(space.scores.begin(), space.scores.end(), Vector3{});
  for (const GroundSample& sample : space.samples) {
    const double r{residual(plane, sample)};
    const double t{square_of_share(r, radius_px)};
    if (t >= 1) continue;
    const Vector3 row{row_of(plane, sample)};
    const double weight{(1 - t) * (1 - t)};
    equations.add(row, weight, r);
    weights += weight;
    slopes += (1 - t) * (1 - 5 * t);  // the derivative of weight·r
    const int block{static_cast<int>(sample.v) / block_v_px * space.blocks_across +
                    static_cast<int>(sample.u) / block_u_px};
    Vector3& score{space.scores[static_cast<std::size_t>(block)]};
    for (std::size_t i{0}; i < 3; ++i) score[i] += weight * r * row[i];
  }
  equations.complete();
  double blocks{0};
  const Matrix3 spread{sum_of_squares(space.scores, blocks)};
  if (equations.inliers < ground_samples_min || blocks < 4 || !is_positive_definite(equations.matrix)) return false;
  const Matrix3 step{inverse(equations.matrix)};
  // Residuals spread evenly over the radius, slopes near 0, say little of where the plane is.
  const double sharpness{std::clamp(slopes / weights, 0.3, 1.0)};
  const Vector3& common{common_error_px};
  measurement.numbers = numbers_of(plane) + step * equations.vector;
  measurement.covariance = scaled(blocks / ((blocks - 3) * sharpness * sharpness), carried(step, spread)) +
                           diagonal({common[0] * common[0], common[1] * common[1], common[2] * common[2]});
  return true;
}

}  // namespace stereogrid
