// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. All vectors run along the shifts of one pixel.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/correlate_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                           // IWYU pragma: keep
// after foreach_target
#include "hwy/highway.h"
#include "matching/correlate_simd.hpp"
#include "matching/curve_simd.hpp"

#include <algorithm>
#include <cstdlib>

HWY_BEFORE_NAMESPACE();
namespace stereogrid {
namespace HWY_NAMESPACE {
namespace {

// Rows of shifts are padded to a multiple of every target's vector of uint16; the few shifts of the road hypothesis to
// one short vector.
constexpr int block{64};
constexpr int short_block{16};
constexpr int padded(int count) {
  return count <= short_block ? short_block : (count + block - 1) / block * block;
}

using Long16 = hn::ScalableTag<std::uint16_t>;
using Short16 = hn::CappedTag<std::uint16_t, short_block>;

struct Space {
  Space(const Band& band, int n) : width{band.left.width} {
    const auto take = [&](std::size_t size) {
      std::uint8_t* start{band.memory == nullptr ? nullptr : band.memory + bytes};
      bytes += (size + 63) / 64 * 64;
      return start;
    };
    const std::size_t volume{static_cast<std::size_t>(width) * static_cast<std::size_t>(n)};
    const std::size_t reach{static_cast<std::size_t>(width + 2 * n + 2 * std::abs(band.shifts.first))};
    column_sums = reinterpret_cast<std::uint16_t*>(take(2 * volume));
    box = reinterpret_cast<std::uint16_t*>(take(2 * static_cast<std::size_t>(n)));
    right_reversed = reinterpret_cast<std::uint32_t*>(take(4 * reach));
    right_cost = reinterpret_cast<std::uint16_t*>(take(2 * reach));
    right_best = reinterpret_cast<std::uint16_t*>(take(2 * reach));
    rows = 2 * band.half_window + 2;
    ring = take(static_cast<std::size_t>(rows) * volume);
  }

  int width;
  int rows{0};
  std::uint16_t* column_sums;     // [u][shift]: costs summed over the window's rows
  std::uint16_t* box;             // [shift]: costs summed over the window
  std::uint32_t* right_reversed;  // right descriptors from right to left, borders repeated
  std::uint16_t* right_cost;      // smallest cost and its shift, seen from the right pixel
  std::uint16_t* right_best;
  std::uint8_t* ring;  // [row % rows][u][shift]: costs of single pixels
  std::size_t bytes{0};
};

void hamming_row(const Band& band, int n, int v, const Space& space) {
  const int width{band.left.width};
  const RightToLeft order{width, band.shifts};
  order.reverse(band.right.row(v), n, space.right_reversed);
  std::uint8_t* out{space.ring + static_cast<std::size_t>(v % space.rows) * static_cast<std::size_t>(width * n)};
  for (int u{0}; u < width; ++u, out += n) hamming(band.left(u, v), space.right_reversed + order.start(u), n, out);
}

// column_sums += added − removed; either may be null
template <class D16>
void update_column_sums(D16 d16, const Space& space, int n, const std::uint8_t* added, const std::uint8_t* removed) {
  const hn::Rebind<std::uint8_t, D16> d8;
  const int lanes{static_cast<int>(hn::Lanes(d16))};
  const int volume{space.width * n};
  for (int k{0}; k < volume; k += lanes) {
    auto sum = hn::Load(d16, space.column_sums + k);
    sum = hn::Add(sum, hn::PromoteTo(d16, hn::LoadU(d8, added + k)));
    if (removed != nullptr) sum = hn::Sub(sum, hn::PromoteTo(d16, hn::LoadU(d8, removed + k)));
    hn::Store(sum, d16, space.column_sums + k);
  }
}

// box += column `entering` − column `leaving`
template <class D16>
void update_box(D16 d16, const Space& space, int n, int entering, int leaving) {
  const int lanes{static_cast<int>(hn::Lanes(d16))};
  const std::uint16_t* in{space.column_sums + static_cast<std::ptrdiff_t>(entering) * n};
  const std::uint16_t* out{leaving < 0 ? nullptr : space.column_sums + static_cast<std::ptrdiff_t>(leaving) * n};
  for (int k{0}; k < n; k += lanes) {
    auto sum = hn::Add(hn::Load(d16, space.box + k), hn::Load(d16, in + k));
    if (out != nullptr) sum = hn::Sub(sum, hn::Load(d16, out + k));
    hn::Store(sum, d16, space.box + k);
  }
}

template <class D16>
void finish_row(D16 d16, const Band& band, const Space& space, int n, int v) {
  const int width{space.width};
  const int half{band.half_window};
  const RightToLeft order{width, band.shifts};
  std::fill(space.right_cost, space.right_cost + order.length(n), std::uint16_t{65535});
  std::fill(space.box, space.box + n, std::uint16_t{0});
  for (int i{-half}; i < half; ++i) update_box(d16, space, n, std::clamp(i, 0, width - 1), -1);
  for (int u{0}; u < width; ++u) {
    update_box(d16, space, n, std::min(u + half, width - 1), u == 0 ? -1 : std::max(u - half - 1, 0));
    band.candidates(u, v) = candidate_of(d16, space.box, band.shifts, n);
    const int start{order.start(u)};
    offer_to_right(d16, space.box, space.right_cost + start, space.right_best + start, n);
  }
  order.mark_consistent(space.right_best, band.left_right_px, band.candidates.row(v));
}

template <class D16>
void correlate_with(D16 d16, const Band& band) {
  const int n{padded(band.shifts.count)};
  const int half{band.half_window};
  const int last{band.left.height - 1};
  const Space space{band, n};
  const auto costs_of = [&](int v) {
    return space.ring +
           static_cast<std::size_t>(std::clamp(v, 0, last) % space.rows) * static_cast<std::size_t>(space.width * n);
  };
  std::fill(space.column_sums, space.column_sums + static_cast<std::ptrdiff_t>(space.width) * n, std::uint16_t{0});
  const int first{band.first_row - half};
  for (int v{std::max(first, 0)}; v <= std::min(first + 2 * half - 1, last); ++v) hamming_row(band, n, v, space);
  for (int v{first}; v < first + 2 * half; ++v) update_column_sums(d16, space, n, costs_of(v), nullptr);
  for (int v{band.first_row}; v < band.end_row; ++v) {
    if (v + half <= last) hamming_row(band, n, v + half, space);
    update_column_sums(d16, space, n, costs_of(v + half), v == band.first_row ? nullptr : costs_of(v - half - 1));
    finish_row(d16, band, space, n, v);
  }
}

void Correlate(const Band& band) {
  if (padded(band.shifts.count) == short_block) {
    correlate_with(Short16{}, band);
  } else {
    correlate_with(Long16{}, band);
  }
}

const char* Target() {
  return hwy::TargetName(HWY_TARGET);
}

std::size_t Memory(const Band& band) {
  return Space{band, padded(band.shifts.count)}.bytes;
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stereogrid
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(Correlate);
HWY_EXPORT(Target);
HWY_EXPORT(Memory);

std::size_t correlate_memory(int width, Shifts shifts, int half_window) {
  Band band;
  band.left.width = width;
  band.shifts = shifts;
  band.half_window = half_window;
  return HWY_DYNAMIC_DISPATCH(Memory)(band);
}

void correlate_band(const Band& band) {
  HWY_DYNAMIC_DISPATCH(Correlate)(band);
}

std::string_view correlate_target() {
  return HWY_DYNAMIC_DISPATCH(Target)();
}

}  // namespace stereogrid
#endif
