// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <optional>

#include "clamped_to_int.hpp"
#include "images/patch.hpp"

namespace stereogrid {

/// A patch of an image at another scale: that of the next image, where the thing is nearer or farther away.
class ScaledPatch {
 public:
  static constexpr int centre_u{patch_reach_u + 1};
  static constexpr int centre_v{patch_reach_v + 1};

  /// Takes the pixels around `place`, `scale` times as large, and one more to each side, for the gradients. False where
  /// the surroundings of `place` are not inside the image.
  [[nodiscard]] bool take(const View<const std::uint8_t>& image, Place place, float scale) {
    const float step{1 / scale};
    const auto first = [step](float at, int centre) { return at - step * static_cast<float>(centre); };
    const auto is_inside = [&](float at, int centre, int size) {
      return first(at, centre) >= 0 && at + step * static_cast<float>(centre) < static_cast<float>(size - 1);
    };
    if (!is_inside(place.u, centre_u, image.width) || !is_inside(place.v, centre_v, image.height)) return false;
    std::array<Between, columns> across;
    for (int i{0}; i < columns; ++i) {
      across[static_cast<std::size_t>(i)] = Between{first(place.u, centre_u) + step * static_cast<float>(i)};
    }
    std::uint8_t* out{grey_.data()};
    for (int j{0}; j < rows; ++j) {
      const Between down{first(place.v, centre_v) + step * static_cast<float>(j)};
      const std::uint8_t* const row{image.row(down.pixel)};
      const std::uint8_t* const next{row + image.pitch};
      for (const Between& u : across) {
        *out++ = static_cast<std::uint8_t>(down.of(u.of(row), u.of(next)) + 0.5f);
      }
    }
    return cut(grey(), {centre_u, centre_v}, 0, pixels_);
  }
  [[nodiscard]] const Template& pixels() const { return pixels_; }
  [[nodiscard]] View<const std::uint8_t> grey() const { return {grey_.data(), columns, rows, columns}; }

 private:
  static constexpr int columns{2 * centre_u};
  static constexpr int rows{2 * centre_v + 1};

  /// A position between two pixels of a row or of a column.
  struct Between {
    Between() = default;
    explicit Between(float at) : pixel{static_cast<int>(at)}, share_next{at - static_cast<float>(pixel)} {}

    [[nodiscard]] float of(float grey, float next) const { return grey + share_next * (next - grey); }
    [[nodiscard]] float of(const std::uint8_t* row) const { return of(row[pixel], row[pixel + 1]); }

    int pixel{0};
    float share_next{0};
  };

  std::array<std::uint8_t, static_cast<std::size_t>(columns) * rows> grey_;
  Template pixels_;
};

inline int rounded(float value) {
  return clamped_to_int(std::round(value));
}

inline bool holds_patch(const View<const std::uint8_t>& image, int u, int v) {
  return u >= patch_reach_u && u + patch_reach_u <= image.width && v >= patch_reach_v &&
         v + patch_reach_v < image.height;
}

// Sum of absolute differences of two patches.
inline int difference(const View<const std::uint8_t>& first, int u1, int v1, const View<const std::uint8_t>& second,
                      int u2, int v2) {
  int sum{0};
  for (int j{-patch_reach_v}; j <= patch_reach_v; ++j) {
    const std::uint8_t* a{first.row(v1 + j) + u1 - patch_reach_u};
    const std::uint8_t* b{second.row(v2 + j) + u2 - patch_reach_u};
    for (int i{0}; i < patch_columns; ++i) sum += std::abs(a[i] - b[i]);
  }
  return sum;
}

constexpr int searched_columns_max{80};

// Place around `expected` at which the patch fits best and clearly better than elsewhere, to two pixels. `columns`: at
// most searched_columns_max.
inline std::optional<Place> searched(const ScaledPatch& patch, const View<const std::uint8_t>& image, Place expected,
                                     int columns, int rows) {
  // A place counts as found if no other one, further away than this, fits nearly as well.
  constexpr int same_place_px{4};
  constexpr double clearly_best{0.8};
  std::array<int, searched_columns_max + 1> least;  // difference at the best row of every second column
  least.fill(std::numeric_limits<int>::max());
  const int first_u{rounded(expected.u) - columns};
  int best{least[0]};
  Place place;
  int best_u{0};
  for (int v{rounded(expected.v) - rows}; v <= rounded(expected.v) + rows; v += 2) {
    for (int i{0}; i <= columns; ++i) {
      const int u{first_u + 2 * i};
      if (!holds_patch(image, u, v)) continue;
      const int now{difference(patch.grey(), ScaledPatch::centre_u, ScaledPatch::centre_v, image, u, v)};
      int& of_column{least[static_cast<std::size_t>(i)]};
      of_column = std::min(of_column, now);
      if (now >= best) continue;
      best = now;
      best_u = u;
      place = {static_cast<float>(u), static_cast<float>(v)};
    }
  }
  int other{std::numeric_limits<int>::max()};
  for (int i{0}; i <= columns; ++i) {
    if (std::abs(first_u + 2 * i - best_u) > same_place_px) other = std::min(other, least[static_cast<std::size_t>(i)]);
  }
  if (best > clearly_best * other) return std::nullopt;
  return place;
}

}  // namespace stereogrid
