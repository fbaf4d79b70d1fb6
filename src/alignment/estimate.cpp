// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>

#include "alignment/alignment.hpp"

namespace stereogrid {
namespace {

// A row of a patch is a whole number of vectors of bytes.
constexpr int reach_u{AlignmentLattice::reach_u};
constexpr int reach_v{AlignmentLattice::reach_v};
constexpr int columns{2 * reach_u};
constexpr int rows{2 * reach_v + 1};
constexpr std::size_t pixels{columns * rows};

/// Summed squared row gradient, freed of what a move along the row explains, below which a patch is not worth moving,
/// and at which it has half the say of the best, in grey levels² per pixel.
constexpr double information_min{4};
constexpr double information_half{20};

constexpr int steps{3};
constexpr float step_max_px{0.7f};
constexpr double slip_max_px{3};      ///< of a patch along its row
constexpr double offset_max_px{2.5};  ///< believed, anywhere in the image
/// Share of a patch's variance that may be left when it lies where it belongs.
constexpr double misfit_max{0.2};

constexpr double support_min{25};  ///< summed weight
constexpr double scale_px{0.15};   ///< of the errors, for the outlier-resistant fit
/// Weight of the assumption that there is no offset: holds what the patches leave open.
constexpr double prior{0.5};
constexpr double memory{0.9};
constexpr double ignored_px{0.25};

using Patch = std::array<float, pixels>;

/// A patch of the left image, its mean grey level removed, and the normal equations of moving it.
struct Template {
  Patch grey;
  Patch gradient_u;
  Patch gradient_v;  ///< along the columns of the right image
  double uu{0};
  double uv{0};
  double vv{0};
  double variance{0};
};

// Four sums side by side, so that the compiler may use vectors: it must not reorder a single one.
template <class Term>
float sum_of(const Term& term) {
  std::array<float, 4> sums{};
  for (std::size_t k{0}; k < pixels; k += 4) {
    for (std::size_t lane{0}; lane < 4; ++lane) sums[lane] += term(k + lane);
  }
  return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

void remove_mean(Patch& patch) {
  const float mean{sum_of([&](std::size_t k) { return patch[k]; }) / pixels};
  for (float& value : patch) value -= mean;
}

double product(const Patch& a, const Patch& b) {
  return sum_of([&](std::size_t k) { return a[k] * b[k]; });
}

// With `shear`, the disparity's change per row, a column of the patch is slanted in the right image.
void cut(View<const std::uint8_t> left, int u, int v, float shear, Template& patch) {
  float* grey{patch.grey.data()};
  float* gradient_u{patch.gradient_u.data()};
  float* gradient_v{patch.gradient_v.data()};
  for (int j{-reach_v}; j <= reach_v; ++j) {
    const std::uint8_t* above{left.row(v + j - 1) + u - reach_u};
    const std::uint8_t* row{left.row(v + j) + u - reach_u};
    const std::uint8_t* below{left.row(v + j + 1) + u - reach_u};
    for (int i{0}; i < columns; ++i) {
      grey[i] = row[i];
      gradient_u[i] = 0.5f * static_cast<float>(row[i + 1] - row[i - 1]);
      gradient_v[i] = 0.5f * static_cast<float>(below[i] - above[i]) + shear * gradient_u[i];
    }
    grey += columns;
    gradient_u += columns;
    gradient_v += columns;
  }
  for (Patch* part : {&patch.grey, &patch.gradient_u, &patch.gradient_v}) remove_mean(*part);
  patch.uu = product(patch.gradient_u, patch.gradient_u);
  patch.uv = product(patch.gradient_u, patch.gradient_v);
  patch.vv = product(patch.gradient_v, patch.gradient_v);
  patch.variance = product(patch.grey, patch.grey);
}

// What the patch tells about rows when its column is unknown too, per pixel.
double information(const Template& patch) {
  return patch.uu > pixels ? (patch.vv - patch.uv * patch.uv / patch.uu) / pixels : 0.0;
}

// The right image's grey levels under a patch centred at (u, v); false where it is not inside.
bool sample(View<const std::uint8_t> right, float u, float v, float shear, Patch& patch) {
  const float top{std::floor(v)};
  const float fv{v - top};
  if (top - reach_v < 0 || top + reach_v + 1 >= static_cast<float>(right.height)) return false;
  float* out{patch.data()};
  for (int j{-reach_v}; j <= reach_v; ++j) {
    const float column{u - shear * static_cast<float>(j)};
    const float first{std::floor(column)};
    if (first - reach_u < 0 || first + reach_u >= static_cast<float>(right.width)) return false;
    const float fu{column - first};
    const std::uint8_t* upper{right.row(static_cast<int>(top) + j) + static_cast<int>(first) - reach_u};
    const std::uint8_t* lower{upper + right.pitch};
    for (int i{0}; i < columns; ++i) {
      const float above{static_cast<float>(upper[i]) + fu * static_cast<float>(upper[i + 1] - upper[i])};
      const float below{static_cast<float>(lower[i]) + fu * static_cast<float>(lower[i + 1] - lower[i])};
      out[i] = above + fv * (below - above);
    }
    out += columns;
  }
  return true;
}

/// Where a patch of the left image lies in the right one.
struct Place {
  float u;
  float v;
};

// Gauss-Newton; none where the patch wanders off or does not fit in the end.
std::optional<Place> find(View<const std::uint8_t> right, const Template& patch, float shear, Place start) {
  const double determinant{patch.uu * patch.vv - patch.uv * patch.uv};
  Place place{start};
  Patch difference;
  for (int step{0};; ++step) {
    if (!sample(right, place.u, place.v, shear, difference)) return std::nullopt;
    for (std::size_t k{0}; k < pixels; ++k) difference[k] = patch.grey[k] - difference[k];
    remove_mean(difference);
    if (step == steps) break;
    const double along_u{product(patch.gradient_u, difference)};
    const double along_v{product(patch.gradient_v, difference)};
    const auto limited = [](double move) { return std::clamp(static_cast<float>(move), -step_max_px, step_max_px); };
    place.u += limited((patch.vv * along_u - patch.uv * along_v) / determinant);
    place.v += limited((patch.uu * along_v - patch.uv * along_u) / determinant);
  }
  if (product(difference, difference) > misfit_max * patch.variance) return std::nullopt;
  if (std::abs(place.u - start.u) > slip_max_px) return std::nullopt;
  return place;
}

// Gaussian elimination; `prior` makes the matrix positive definite.
RowTerms solution_of(RowEquations equations) {
  auto& [matrix, x] = equations;
  for (std::size_t i{0}; i < row_terms; ++i) matrix[i][i] += prior;
  for (std::size_t pivot{0}; pivot < row_terms; ++pivot) {
    for (std::size_t row{pivot + 1}; row < row_terms; ++row) {
      const double factor{matrix[row][pivot] / matrix[pivot][pivot]};
      for (std::size_t column{pivot}; column < row_terms; ++column)
        matrix[row][column] -= factor * matrix[pivot][column];
      x[row] -= factor * x[pivot];
    }
  }
  for (std::size_t row{row_terms}; row-- > 0;) {
    for (std::size_t column{row + 1}; column < row_terms; ++column) x[row] -= matrix[row][column] * x[column];
    x[row] /= matrix[row][row];
  }
  return x;
}

/// Equations of a frame, and how much weight they were left.
struct FrameFit {
  RowEquations equations;
  double support{0};
};

// Cauchy weights around ever better terms, the scale coming down to the errors'.
FrameFit fit(const std::vector<RowSample>& samples, RowTerms terms) {
  FrameFit result;
  for (const double scale : {4 * scale_px, 2 * scale_px, scale_px, scale_px, scale_px}) {
    result = {};
    for (const RowSample& sample : samples) {
      const double expected{std::inner_product(terms.begin(), terms.end(), sample.basis.begin(), 0.0)};
      const double error{(sample.offset_px - expected) / scale};
      const double weight{sample.weight / (1 + error * error)};
      result.equations.add(sample, weight);
      result.support += weight;
    }
    terms = solution_of(result.equations);
  }
  return result;
}

}  // namespace

void RowEquations::add(const RowSample& sample, double weight) {
  for (std::size_t i{0}; i < row_terms; ++i) {
    for (std::size_t j{0}; j < row_terms; ++j) matrix[i][j] += weight * sample.basis[i] * sample.basis[j];
    right_side[i] += weight * sample.basis[i] * sample.offset_px;
  }
}

RowAlignment::RowAlignment(const Rig& rig)
    : width_px_{rig.width_px}, height_px_{rig.height_px}, offsets_{{}, rig.centre_u_px, rig.centre_v_px} {
  const AlignmentLattice lattice{width_px_, height_px_};
  samples_.reserve(static_cast<std::size_t>(lattice.across) * static_cast<std::size_t>(lattice.down));
}

void RowAlignment::collect(View<const std::uint8_t> left, View<const std::uint8_t> right, const Matches& matches,
                           const RoadPlane& plane) {
  samples_.clear();
  const auto road_shear = static_cast<float>(plane.per_v);
  Template patch;
  const AlignmentLattice lattice{left.width, left.height};
  for (int j{0}; j < lattice.down; ++j) {
    for (int i{0}; i < lattice.across; ++i) {
      const int u{AlignmentLattice::first_u + i * AlignmentLattice::step_u};
      const int v{AlignmentLattice::first_v + j * AlignmentLattice::step_v};
      const float road{matches.road(u, v)};
      const float disparity{road > 0 ? road : matches.obstacle(u, v)};
      if (disparity <= 0) continue;
      const float shear{road > 0 ? road_shear : 0.0f};
      cut(left, u, v, shear, patch);
      const double informed{information(patch)};
      if (informed < information_min) continue;
      const float start_u{static_cast<float>(u) - disparity};
      const Place start{start_u, static_cast<float>(v + offsets_.at(start_u, v))};
      const std::optional<Place> found{find(right, patch, shear, start)};
      if (!found) continue;
      const double offset_px{static_cast<double>(found->v) - v};
      if (std::abs(offset_px) > offset_max_px) continue;
      samples_.push_back({offsets_.basis(found->u, v), offset_px, informed / (informed + information_half)});
    }
  }
}

double RowAlignment::largest(const RowTerms& terms) const {
  const RowOffsets offsets{terms, offsets_.centre_u_px, offsets_.centre_v_px};
  double most{0};
  for (const int u : {0, width_px_ / 4, width_px_ / 2, width_px_ - width_px_ / 4, width_px_}) {
    for (const int v : {0, height_px_}) most = std::max(most, std::abs(offsets.at(u, v)));
  }
  return most;
}

bool RowAlignment::update(View<const std::uint8_t> left, View<const std::uint8_t> right, const Matches& matches,
                          const RoadPlane& plane) {
  collect(left, right, matches, plane);
  const FrameFit frame{fit(samples_, offsets_.terms)};
  if (frame.support < support_min || largest(solution_of(frame.equations)) > offset_max_px) return false;
  RowEquations joined{frame.equations};
  for (std::size_t i{0}; i < row_terms; ++i) {
    for (std::size_t j{0}; j < row_terms; ++j) joined.matrix[i][j] += memory * remembered_.matrix[i][j];
    joined.right_side[i] += memory * remembered_.right_side[i];
  }
  remembered_ = joined;
  offsets_.terms = solution_of(joined);
  is_identity_ = largest(offsets_.terms) < ignored_px;
  return true;
}

}  // namespace stereogrid
