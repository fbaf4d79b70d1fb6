// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace stereogrid {

/// Part of a segment's side between two image columns. Errors are those of the disparity: they lie along the ray.
struct SideSample {
  double left_u;
  double right_u;
  double disparity;
  double sigma_px;  ///< standard deviation of the disparity
};

/// Polyline through a side, fitted by least squares of the disparities. A straight line on the ground is one in column
/// and disparity, too. docs/method.md §11.1.
class SideFit {
 public:
  static constexpr std::size_t samples_max{12};
  static constexpr std::size_t points_max{samples_max};

  /// `samples`: at least one, from left to right. Points are added where they reduce the residuals most, until these
  /// are within their standard deviations, up to `most_points` (at least 2), or the next point would reduce the sum of
  /// their squares, in variances, by less than `least_gain`.
  SideFit(std::span<const SideSample> samples, std::size_t most_points, double least_gain);

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] double column(std::size_t point) const { return columns_[point]; }
  [[nodiscard]] double disparity(std::size_t point) const { return disparities_[point]; }
  /// Fits the disparities of another side. The points keep their columns.
  void refit(std::span<const SideSample> samples) { solve(samples); }

 private:
  using Values = std::array<double, points_max>;

  double add_point(std::span<const SideSample> samples);
  double solve(std::span<const SideSample> samples);
  [[nodiscard]] bool is_within_noise(std::span<const SideSample> samples) const;
  [[nodiscard]] std::size_t span_of(const SideSample& sample) const;
  [[nodiscard]] double residual(const SideSample& sample) const;

  std::size_t size_{2};
  Values columns_{};
  Values disparities_{};
};

}  // namespace stereogrid
