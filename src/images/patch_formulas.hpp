// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "images/patch.hpp"

namespace stereogrid {

/// Position of the rows of a patch, with a border of `border` pixels, between the pixels of an image. With `shear`,
/// each row begins farther left than the one above by that amount.
template <int border>
class PatchRows {
 public:
  static constexpr int reach_u{patch_reach_u + border};
  static constexpr int reach_v{patch_reach_v + border};

  PatchRows(View<const std::uint8_t> image, Place place, float shear)
      : image_{image}, u_{place.u}, shear_{shear}, top_{std::floor(place.v)}, share_below_{place.v - top_} {}

  /// True for all rows.
  [[nodiscard]] bool are_inside() const {
    const float last{top_ + reach_v + (share_below_ > 0 ? 1 : 0)};
    return top_ - reach_v >= 0 && last < static_cast<float>(image_.height);
  }
  /// Share of the row below.
  [[nodiscard]] float share_below() const { return share_below_; }
  /// From a pixel to the one below that counts, too; 0: none does.
  [[nodiscard]] std::ptrdiff_t next_row() const { return share_below_ > 0 ? image_.pitch : 0; }

  struct Row {
    const std::uint8_t* first;  ///< null: not all of it is inside
    float share_next;           ///< share of the pixel on the right
    [[nodiscard]] int next() const { return share_next > 0 ? 1 : 0; }
  };
  /// −reach_v ≤ j ≤ reach_v, where are_inside().
  [[nodiscard]] Row row(int j) const {
    const float column{u_ - shear_ * static_cast<float>(j)};
    const float first{std::floor(column)};
    const Row row{nullptr, column - first};
    const float last{first + reach_u - 1 + static_cast<float>(row.next())};
    if (!(first - reach_u >= 0 && last < static_cast<float>(image_.width))) return row;
    return {image_.row(static_cast<int>(top_) + j) + static_cast<int>(first) - reach_u, row.share_next};
  }

 private:
  View<const std::uint8_t> image_;
  float u_;
  float shear_;
  float top_;
  float share_below_;
};

constexpr float longest_step_px{0.7f};

/// Step of find(): motion of the patch, px. `along_u`, `along_v`: its gradients times the residual.
inline Place step_of(const Template& patch, double along_u, double along_v) {
  const double determinant{patch.uu * patch.vv - patch.uv * patch.uv};
  const auto limited = [](double move) {
    return std::clamp(static_cast<float>(move), -longest_step_px, longest_step_px);
  };
  return {limited((patch.vv * along_u - patch.uv * along_v) / determinant),
          limited((patch.uu * along_v - patch.uv * along_u) / determinant)};
}

/// Far below what it errs by.
inline bool is_short(const Place& step) {
  constexpr float short_px{0.01f};
  return std::abs(step.u) < short_px && std::abs(step.v) < short_px;
}

/// `left`: the sum of squares that is left of the patch.
inline bool fits(const Template& patch, double left, const FindLimits& limits) {
  return left <= limits.misfit * patch.variance;
}

}  // namespace stereogrid
