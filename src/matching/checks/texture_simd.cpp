// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along the pixels of a row.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/checks/texture_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                                // IWYU pragma: keep
// after foreach_target
#include "hwy/highway.h"
#include "matching/checks/simd.hpp"
#include "matching/window_sums_simd.hpp"

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {
namespace {

// columns += contrast of one row − contrast of another (null: none)
void update_columns(const std::uint8_t* entering, const std::uint8_t* leaving, int width, std::uint16_t* columns) {
  const hn::ScalableTag<std::uint16_t> d16;
  const hn::Rebind<std::uint8_t, decltype(d16)> d8;
  const int lanes{static_cast<int>(hn::Lanes(d16))};
  for (int u{0}; u < width; u += lanes) {
    const auto contrast = [&](const std::uint8_t* row) {
      const auto before = hn::LoadU(d8, row + u - 1);
      const auto after = hn::LoadU(d8, row + u + 1);
      return hn::PromoteTo(d16, hn::Sub(hn::Max(before, after), hn::Min(before, after)));
    };
    auto sum = hn::Add(hn::LoadU(d16, columns + u), contrast(entering));
    if (leaving != nullptr) sum = hn::Sub(sum, contrast(leaving));
    hn::StoreU(sum, d16, columns + u);
  }
}

// With sums of type T, which may saturate above `least`.
template <class T>
void finish_row(int width, int half, std::int32_t least, TextureWorkspace& space, std::uint8_t* textured) {
  const hn::ScalableTag<T> d;
  const hn::Rebind<std::uint16_t, decltype(d)> d16;
  const hn::Rebind<std::uint8_t, decltype(d)> d8;
  const hn::RebindToSigned<decltype(d)> flags;
  std::uint16_t* columns{space.columns.data()};
  std::fill(columns, columns + half, columns[half]);
  std::fill(columns + half + width, columns + half + width + half, columns[half + width - 1]);
  const auto load = [&](int u) {
    if constexpr (sizeof(T) == 2)
      return hn::LoadU(d16, columns + u);
    else
      return hn::PromoteTo(d, hn::LoadU(d16, columns + u));
  };
  const auto enough = hn::Set(d, static_cast<T>(least));
  auto* const fours = reinterpret_cast<T*>(space.fours.data());
  sums_of_fours(d, load, width, 2 * half + 1, fours);
  window_sums(d, load, width, 2 * half + 1, fours, [&](auto sums, int u) {
    const auto is_textured = hn::RebindMask(flags, hn::Eq(hn::Max(sums, enough), sums));
    hn::StoreU(hn::DemoteTo(d8, hn::IfThenElseZero(is_textured, hn::Set(flags, 1))), d8, textured + u);
  });
}

void TextureRows(const Padded<std::uint8_t>& left, int half, std::int32_t least, int begin, int end,
                 TextureWorkspace& space, Padded<std::uint8_t>& textured) {
  const int width{left.width()};
  std::fill(space.columns.begin(), space.columns.end(), std::uint16_t{0});
  std::uint16_t* columns{space.columns.data() + half};
  for (int v{begin - half}; v < begin + half; ++v) update_columns(left.clamped_row(v), nullptr, width, columns);
  for (int v{begin}; v < end; ++v) {
    const std::uint8_t* leaving{v == begin ? nullptr : left.clamped_row(v - half - 1)};
    update_columns(left.clamped_row(v + half), leaving, width, columns);
    least <= 65535 ? finish_row<std::uint16_t>(width, half, least, space, textured.row(v))
                   : finish_row<std::int32_t>(width, half, least, space, textured.row(v));
  }
}

}  // namespace
}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(TextureRows);

TextureWorkspace::TextureWorkspace(int width, int half_window) {
  // two vectors beyond the window's columns
  const std::size_t size{static_cast<std::size_t>(width + 4 * half_window + 2 + 128)};
  columns.resize(size);
  fours.resize(size);
}

void texture_rows(const Padded<std::uint8_t>& left, int half_window, std::int32_t least, int begin, int end,
                  TextureWorkspace& space, Padded<std::uint8_t>& textured) {
  HWY_DYNAMIC_DISPATCH(TextureRows)(left, half_window, least, begin, end, space, textured);
}

}  // namespace stereogrid
#endif
