// SPDX-License-Identifier: Apache-2.0
#include "obstacles/segmentation/side_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stereogrid {
namespace {

constexpr double within_sigmas{1};     // maximum residual
constexpr double extrapolation{1.02};  // maximum, relative to the samples' disparities
constexpr double stiffness{1e-3};      // weight of equal neighbours: decides where samples do not

double middle(const SideSample& sample) {
  return (sample.left_u + sample.right_u) / 2;
}

}  // namespace

SideFit::SideFit(std::span<const SideSample> samples, std::size_t most_points, double least_gain) {
  columns_[0] = samples.front().left_u;
  columns_[1] = samples.back().right_u;
  const std::size_t most{std::min(most_points, samples.size())};
  double square{solve(samples)};
  while (size_ < most && !is_within_noise(samples)) {
    const SideFit before{*this};
    const double next{add_point(samples)};
    if (square - next < least_gain) {
      *this = before;
      break;
    }
    square = next;
  }
}

// At the left end of a sample.
double SideFit::add_point(std::span<const SideSample> samples) {
  const SideFit before{*this};
  SideFit best{*this};
  double least{std::numeric_limits<double>::max()};
  for (const SideSample& sample : samples.subspan(1)) {
    const auto end = before.columns_.begin() + static_cast<std::ptrdiff_t>(before.size_);
    const auto at = std::lower_bound(before.columns_.begin(), end, sample.left_u);
    if (*at == sample.left_u) continue;
    *this = before;
    std::copy_backward(at - before.columns_.begin() + columns_.begin(), columns_.begin() + before.size_,
                       columns_.begin() + before.size_ + 1);
    columns_[static_cast<std::size_t>(at - before.columns_.begin())] = sample.left_u;
    ++size_;
    const double square{solve(samples)};
    if (square >= least) continue;
    least = square;
    best = *this;
  }
  *this = best;
  return least;
}

std::size_t SideFit::span_of(const SideSample& sample) const {
  std::size_t i{0};
  while (i + 2 < size_ && columns_[i + 1] <= middle(sample)) ++i;
  return i;
}

double SideFit::residual(const SideSample& sample) const {
  const std::size_t i{span_of(sample)};
  const double share{(middle(sample) - columns_[i]) / (columns_[i + 1] - columns_[i])};
  return (sample.disparity - std::lerp(disparities_[i], disparities_[i + 1], share)) / sample.sigma_px;
}

bool SideFit::is_within_noise(std::span<const SideSample> samples) const {
  return std::ranges::all_of(samples, [&](const SideSample& one) { return std::abs(residual(one)) <= within_sigmas; });
}

// Tridiagonal normal equations: a sample depends on the two points beside it. Returns the sum of squared residuals.
double SideFit::solve(std::span<const SideSample> samples) {
  Values diagonal{};
  Values beside{};
  Values right{};
  for (const SideSample& sample : samples) {
    const std::size_t i{span_of(sample)};
    const double share{(middle(sample) - columns_[i]) / (columns_[i + 1] - columns_[i])};
    const double weight{1 / (sample.sigma_px * sample.sigma_px)};
    diagonal[i] += weight * (1 - share) * (1 - share) + stiffness * weight;
    diagonal[i + 1] += weight * share * share + stiffness * weight;
    beside[i] += weight * share * (1 - share) - stiffness * weight;
    right[i] += weight * (1 - share) * sample.disparity;
    right[i + 1] += weight * share * sample.disparity;
  }
  for (std::size_t i{0}; i + 1 < size_; ++i) {
    const double factor{beside[i] / diagonal[i]};
    diagonal[i + 1] -= factor * beside[i];
    right[i + 1] -= factor * right[i];
  }
  disparities_[size_ - 1] = right[size_ - 1] / diagonal[size_ - 1];
  for (std::size_t i{size_ - 1}; i-- > 0;) disparities_[i] = (right[i] - beside[i] * disparities_[i + 1]) / diagonal[i];
  const auto [least, most] = std::ranges::minmax(samples, {}, &SideSample::disparity);
  for (std::size_t i{0}; i < size_; ++i) {
    disparities_[i] = std::clamp(disparities_[i], least.disparity / extrapolation, most.disparity * extrapolation);
  }
  double sum{0};
  for (const SideSample& sample : samples) sum += residual(sample) * residual(sample);
  return sum;
}

}  // namespace stereogrid
