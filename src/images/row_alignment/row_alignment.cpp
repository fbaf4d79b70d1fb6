// SPDX-License-Identifier: Apache-2.0
#include "images/row_alignment/row_alignment.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>

#include "backend/reference.hpp"
#include "images/patch.hpp"

namespace stereogrid {
namespace {

/// Summed squared row gradient, freed of what a move along the row explains, below which a patch is not worth moving,
/// and at which it has half the say of the best, in grey levels² per pixel.
constexpr double information_min{4};
constexpr double information_half{20};

constexpr double offset_max_px{2.5};  ///< maximum offset anywhere in the image
constexpr double support_min{25};     ///< summed weight
constexpr double scale_px{0.15};      ///< scale of the errors, for the robust fit
/// Weight of the assumption that there is no offset: holds what the patches leave open.
constexpr double prior{0.5};
constexpr double memory{0.9};
constexpr double ignored_px{0.25};

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
    : width_px_{rig.width_px}, height_px_{rig.height_px}, offsets_{{}, rig.cx_px, rig.cy_px} {
  const MatchLattice lattice{width_px_, height_px_};
  rows_.resize(static_cast<std::size_t>((lattice.down + alignment_rows - 1) / alignment_rows));
  for (std::vector<RowSample>& row : rows_) row.reserve(static_cast<std::size_t>(lattice.across));
  samples_.reserve(rows_.size() * static_cast<std::size_t>(lattice.across));
}

void RowAlignment::collect(int row, View<const std::uint8_t> left, View<const std::uint8_t> right,
                           const Matches& matches, const RoadPlane& plane) {
  std::vector<RowSample>& samples{rows_[static_cast<std::size_t>(row)]};
  samples.clear();
  const auto road_shear = static_cast<float>(plane.per_v);
  Template patch;
  const MatchLattice lattice{left.width, left.height};
  const int v{MatchLattice::first_v + row * alignment_rows * MatchLattice::step_v};
  for (int i{0}; i < lattice.across; i += alignment_columns) {
    const int u{MatchLattice::first_u + i * MatchLattice::step_u};
    const float road{matches.road(u, v)};
    const float disparity{road > 0 ? road : matches.obstacle(u, v)};
    if (disparity <= 0) continue;
    const float shear{road > 0 ? road_shear : 0.0f};
    if (!cut(left, {static_cast<float>(u), static_cast<float>(v)}, shear, patch)) continue;
    const double informed{information_v(patch)};
    if (informed < information_min) continue;
    const float start_u{static_cast<float>(u) - disparity};
    const Place start{start_u, static_cast<float>(v + offsets_.at(start_u, v))};
    const std::optional<Place> found{find(right, patch, shear, start)};
    if (!found) continue;
    const double offset_px{static_cast<double>(found->v) - v};
    if (std::abs(offset_px) > offset_max_px) continue;
    samples.push_back({offsets_.basis(found->u, v), offset_px, informed / (informed + information_half)});
  }
}

double RowAlignment::largest(const RowTerms& terms) const {
  const RowOffsets offsets{terms, offsets_.cx_px, offsets_.cy_px};
  double most{0};
  for (const int u : {0, width_px_ / 4, width_px_ / 2, width_px_ - width_px_ / 4, width_px_}) {
    for (const int v : {0, height_px_}) most = std::max(most, std::abs(offsets.at(u, v)));
  }
  return most;
}

bool RowAlignment::join_frame() {
  samples_.clear();
  for (const std::vector<RowSample>& row : rows_) samples_.insert(samples_.end(), row.begin(), row.end());
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

void align_rows(Reference&, View<const std::uint8_t> right, const RowOffsets& offsets, View<std::uint8_t> aligned) {
  const auto row = [&](int v) { return right.row(std::clamp(v, 0, right.height - 1)); };
  for (int v{0}; v < right.height; ++v) {
    for (int u{0}; u < right.width; ++u) {
      const int place{place_256(offsets, u, v)};
      aligned(u, v) = between_rows(row(place >> 8)[u], row((place >> 8) + 1)[u], place & 255);
    }
  }
}

}  // namespace stereogrid
