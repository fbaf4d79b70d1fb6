// SPDX-License-Identifier: Apache-2.0
#include "images/patch.hpp"

#include <algorithm>

#include "images/patch_formulas.hpp"

namespace stereogrid {
namespace {

// The sums of the columns first, then of their halves: as vectors of any length do.
template <class Term>
float sum_of(const Term& term) {
  std::array<float, patch_columns> sums{};
  for (std::size_t k{0}; k < patch_pixels; k += sums.size()) {
    for (std::size_t lane{0}; lane < sums.size(); ++lane) sums[lane] += term(k + lane);
  }
  for (std::size_t half{sums.size() / 2}; half > 0; half /= 2) {
    for (std::size_t lane{0}; lane < half; ++lane) sums[lane] += sums[lane + half];
  }
  return sums[0];
}

void remove_mean(Patch& patch) {
  const float mean{sum_of([&](std::size_t k) { return patch[k]; }) / patch_pixels};
  for (float& value : patch) value -= mean;
}

double product(const Patch& a, const Patch& b) {
  return sum_of([&](std::size_t k) { return a[k] * b[k]; });
}

// Grey levels under a patch with `border` more pixels around it, between the pixels; false where it is not inside.
template <int border>
bool sample(View<const std::uint8_t> image, Place place, float shear, float* out) {
  using Rows = PatchRows<border>;
  const Rows rows{image, place, shear};
  if (!rows.are_inside()) return false;
  for (int j{-Rows::reach_v}; j <= Rows::reach_v; ++j) {
    const auto row = rows.row(j);
    if (row.first == nullptr) return false;
    const auto between = [&](const std::uint8_t* grey) {
      return static_cast<float>(grey[0]) + row.share_next * static_cast<float>(grey[row.next()] - grey[0]);
    };
    for (int i{0}; i < 2 * Rows::reach_u; ++i) {
      const float above{between(row.first + i)};
      const float below{between(row.first + i + rows.next_row())};
      *out++ = above + rows.share_below() * (below - above);
    }
  }
  return true;
}

double explained(double variance, double covariance, double other) {
  return other > patch_pixels ? (variance - covariance * covariance / other) / patch_pixels : 0.0;
}

}  // namespace

double information_u(const Template& patch) {
  return explained(patch.uu, patch.uv, patch.vv);
}

double information_v(const Template& patch) {
  return explained(patch.vv, patch.uv, patch.uu);
}

namespace plain {

bool cut(View<const std::uint8_t> image, Place place, float shear, Template& patch) {
  constexpr std::ptrdiff_t wide{patch_columns + 2};
  float grey[wide * (patch_rows + 2)];
  if (!sample<1>(image, place, 0, grey)) return false;
  std::size_t k{0};
  for (std::ptrdiff_t j{1}; j <= patch_rows; ++j) {
    const float* row{grey + j * wide + 1};
    for (std::ptrdiff_t i{0}; i < patch_columns; ++i, ++k) {
      patch.grey[k] = row[i];
      patch.gradient_u[k] = 0.5f * (row[i + 1] - row[i - 1]);
      patch.gradient_v[k] = 0.5f * (row[i + wide] - row[i - wide]) + shear * patch.gradient_u[k];
    }
  }
  for (Patch* part : {&patch.grey, &patch.gradient_u, &patch.gradient_v}) remove_mean(*part);
  patch.uu = product(patch.gradient_u, patch.gradient_u);
  patch.uv = product(patch.gradient_u, patch.gradient_v);
  patch.vv = product(patch.gradient_v, patch.gradient_v);
  patch.variance = product(patch.grey, patch.grey);
  return true;
}

std::optional<Place> find(View<const std::uint8_t> image, const Template& patch, float shear, Place start,
                          FindLimits limits) {
  Place place{start};
  Patch difference;
  for (int step{0};; ++step) {
    if (!sample<0>(image, place, shear, difference.data())) return std::nullopt;
    for (std::size_t k{0}; k < patch_pixels; ++k) difference[k] = patch.grey[k] - difference[k];
    remove_mean(difference);
    if (step == limits.steps) break;
    const Place move{step_of(patch, product(patch.gradient_u, difference), product(patch.gradient_v, difference))};
    place = {place.u + move.u, place.v + move.v};
    if (is_short(move)) break;
  }
  if (!fits(patch, product(difference, difference), limits)) return std::nullopt;
  return place;
}

}  // namespace plain

}  // namespace stereogrid
