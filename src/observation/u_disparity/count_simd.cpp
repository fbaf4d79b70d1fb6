// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along the columns of a row.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "observation/u_disparity/count_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                                      // IWYU pragma: keep
// after foreach_target
#include "hwy/cache_control.h"
#include "hwy/highway.h"
#include "observation/u_disparity/model.hpp"
#include "observation/u_disparity/simd.hpp"
#include "observation/u_disparity/vectors_simd.hpp"

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {
namespace {

using Float = hn::CappedTag<float, 16>;
using Int = hn::Rebind<std::int32_t, Float>;
using Count = hn::CappedTag<std::uint16_t, 32>;
using V = hn::VFromD<Int>;

constexpr int rows_ahead{6};  // fetched: a block's rows lie too far apart for the machine to see it coming

HWY_INLINE V number(int value) {
  return hn::Set(Int{}, value);
}

// Rows to which the pixels of a row of a block contribute.
struct RowPlaces {
  HWY_ALIGN std::int32_t place[block_columns];
  HWY_ALIGN std::int32_t late[block_columns];  // 1: needs a second count
  bool any_late;
};

HWY_INLINE V place_of(V bin, V kind) {
  return hn::ShiftLeft<6>(hn::Add(hn::Mul(bin, number(pixel_kinds)), kind));
}

// Bounds for all pixels of a row of a block.
struct RowBounds {
  explicit RowBounds(const PixelBlock& block, int v)
      : first{number(block.bins[v].first)},
        behind{number(block.bins[v].last + 1)},
        upright_first{number(block.upright[v].first)},
        upright_last{number(block.upright[v].last)},
        disparities{number(block.disparities)},
        road_rays{number(block.road_rays ? 1 : 0)},
        leaves{block.bins[v].last >= 0 && block.bins[v].last + 1 < block.disparities} {}

  V first;
  V behind;
  V upright_first;
  V upright_last;
  V disparities;
  V road_rays;
  bool leaves;
};

class BlockCounter {
 public:
  BlockCounter(const PixelBlock& block, std::uint16_t* counts) : block_{block}, counts_{counts} {
    for (int u{0}; u < block_columns; ++u) columns_[u] = u;
  }

  HWY_INLINE void run() {
    for (int v{0}; v < block_.height; ++v) {
      fetch_ahead(v + rows_ahead);
      const std::ptrdiff_t at{block_.stride * v};
      const RowBounds bounds{block_, v};
      RowPlaces places;
      places.any_late = false;
      for_vectors(Float{}, block_.width, [&](int u, auto n) { find_places(bounds, v, at + u, u, n, places); });
      for (int u{0}; u < block_.width; ++u) ++counts_[places.place[u]];
      if (places.any_late) add_late(block_.bins[v].first, places);
    }
  }

 private:
  HWY_INLINE void fetch_ahead(int v) const {
    if (v >= block_.height) return;
    for (int u{0}; u < block_.width; u += 16) {
      hwy::Prefetch(block_.obstacle + block_.stride * v + u);
      hwy::Prefetch(block_.road + block_.stride * v + u);
    }
  }

  template <class N>
  HWY_INLINE void find_places(const RowBounds& bounds, int v, std::ptrdiff_t at, int u, N n, RowPlaces& places) {
    const Float df;
    const Int di;
    const auto half = hn::Set(df, 0.5f);
    const V upright{hn::ConvertTo(di, hn::Add(load(df, block_.obstacle + at, n), half))};
    const V ground{hn::ConvertTo(di, hn::Add(load(df, block_.road + at, n), half))};
    const auto is_road = hn::Gt(ground, hn::Zero(di));
    const V end{hn::Add(upright, ground)};
    const V from{hn::Max(end, bounds.first)};
    // obstacles
    const auto is_seen = hn::And(hn::Gt(upright, hn::Zero(di)), hn::Lt(from, bounds.behind));
    const auto is_low = hn::Or(hn::Lt(upright, bounds.upright_first), hn::Gt(upright, bounds.upright_last));
    V kind{hn::IfThenElseZero(is_low, number(passing_pixel))};
    V bin{hn::IfThenElseZero(is_seen, from)};
    // road: always marked, its ray where there is one
    const auto has_ray = hn::And(hn::And(is_road, hn::Lt(from, bounds.behind)), hn::Gt(bounds.road_rays, hn::Zero(di)));
    const auto is_early = hn::And(has_ray, hn::Eq(hn::Add(end, number(1)), bounds.first));
    const auto is_late = hn::And(has_ray, hn::Lt(hn::Add(end, number(1)), bounds.first));
    const V road_kind{hn::IfThenElse(hn::Or(is_late, hn::Not(has_ray)), number(road_mark),
                                     hn::IfThenElse(is_early, number(early_road_pixel), number(road_pixel)))};
    const V road_bin{hn::IfThenElse(is_early, bounds.first, end)};
    const auto is_marked = hn::And(is_road, hn::Lt(road_bin, bounds.disparities));
    kind = hn::IfThenElse(is_road, road_kind, kind);
    bin = hn::IfThenElse(is_marked, road_bin, bin);
    hn::Store(hn::Add(place_of(bin, kind), hn::Load(di, columns_ + u)), di, places.place + u);
    if (!hn::AllFalse(di, is_late)) note_late(is_late, u, places);
    if (bounds.leaves) leave(v, hn::IfThenElseZero(hn::Or(is_seen, has_ray), number(1)), u);
  }

  template <class M>
  HWY_INLINE void note_late(M is_late, int u, RowPlaces& places) {
    if (!places.any_late) std::fill_n(places.late, block_columns, 0);
    places.any_late = true;
    hn::Store(hn::IfThenElseZero(is_late, number(1)), Int{}, places.late + u);
  }

  // Road far before the bins of its row: marked there, its ray begins with the first of them.
  HWY_NOINLINE void add_late(int first, const RowPlaces& places) {
    std::uint16_t* counts{counts_ + (first * pixel_kinds + passing_pixel) * block_columns};
    for (int u{0}; u < block_.width; ++u) counts[u] = static_cast<std::uint16_t>(counts[u] + places.late[u]);
  }

  HWY_INLINE void leave(int v, V rays, int u) {
    const hn::Rebind<std::uint16_t, Float> d16;
    std::uint16_t* leaving{counts_ + ((block_.bins[v].last + 1) * pixel_kinds + leaving_pixels) * block_columns + u};
    hn::StoreU(hn::Add(hn::LoadU(d16, leaving), hn::DemoteTo(d16, rays)), d16, leaving);
  }

  const PixelBlock& block_;
  std::uint16_t* counts_;
  HWY_ALIGN std::int32_t columns_[block_columns];
};

void CountPixels(const PixelBlock& block, std::uint16_t* counts) {
  BlockCounter{block, counts}.run();
}

// The rays of the nearer bins remain in `rays`.
template <class N>
HWY_INLINE void total_bin(const BlockTotals& totals, int d, int u, N n, std::uint16_t* counts, std::uint16_t* rays) {
  const Count dc;
  const hn::Rebind<std::uint8_t, Count> d8;
  const auto of = [&](int bin, int kind) {
    return hn::LoadU(dc, counts + (bin * pixel_kinds + kind) * block_columns + u);
  };
  const std::ptrdiff_t at{totals.stride * d + u};
  const auto observed = d == 0 ? hn::Zero(dc) : of(d, upright_pixel);  // bin 0 contains pixels without a bin
  const auto early_behind = of(d + 1, early_road_pixel);
  auto visible = hn::Zero(dc);
  auto road = hn::Zero(dc);
  if (d > 0) {
    const auto on_road = of(d, road_pixel);
    const auto obstacles = hn::Add(observed, of(d, passing_pixel));
    const auto arrived = hn::Add(obstacles, hn::Add(on_road, of(d, early_road_pixel)));
    visible = hn::Sub(hn::Add(hn::LoadU(dc, rays + u), arrived), of(d, leaving_pixels));
    hn::StoreU(visible, dc, rays + u);
    road = hn::Or(hn::Or(on_road, of(d, road_mark)), early_behind);
  }
  for (int kind{0}; kind < pixel_kinds; ++kind) {
    hn::StoreU(hn::Zero(dc), dc, counts + (d * pixel_kinds + kind) * block_columns + u);
  }
  store(visible, dc, totals.visible + at, n);
  store(observed, dc, totals.observed + at, n);
  store(hn::DemoteTo(d8, hn::BitCast(hn::Rebind<std::int16_t, Count>{}, hn::Min(road, hn::Set(dc, 1)))), d8,
        totals.has_road + at, n);
}

void TotalBlock(const BlockTotals& totals, std::uint16_t* counts) {
  HWY_ALIGN std::uint16_t rays[block_columns]{};
  for (int d{0}; d < totals.disparities; ++d) {
    for_vectors(Count{}, totals.width, [&](int u, auto n) { total_bin(totals, d, u, n, counts, rays); });
  }
}

}  // namespace
}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(CountPixels);
HWY_EXPORT(TotalBlock);

void count_pixels(const PixelBlock& block, std::uint16_t* counts) {
  HWY_DYNAMIC_DISPATCH(CountPixels)(block, counts);
}

void total_block(const BlockTotals& totals, std::uint16_t* counts) {
  HWY_DYNAMIC_DISPATCH(TotalBlock)(totals, counts);
}

}  // namespace stereogrid
#endif
