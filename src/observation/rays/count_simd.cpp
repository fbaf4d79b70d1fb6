// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along the columns of a row; each goes
// through the operations of count_ray.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "observation/rays/count_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                               // IWYU pragma: keep
// after foreach_target
#include "hwy/cache_control.h"
#include "hwy/highway.h"
#include "observation/rays/simd.hpp"
#include "observation/u_disparity/vectors_simd.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {
namespace {

using Floats = hn::CappedTag<float, ray_block_columns>;
using Ints = hn::RebindToSigned<Floats>;
using Bits = hn::RebindToUnsigned<Floats>;
using VFloat = hn::Vec<Floats>;
using VInt = hn::Vec<Ints>;
using Mask = hn::Mask<Ints>;

constexpr int lanes_max{hn::MaxLanes(Floats{})};

HWY_INLINE VFloat floats(float value) {
  return hn::Set(Floats{}, value);
}
HWY_INLINE VInt ints(int value) {
  return hn::Set(Ints{}, value);
}

/// RayRow of each pixel.
struct RayRows {
  VInt first;
  VInt end;
  VFloat drop;
};

// A column's counts of bins are preceded by one that receives what does not count.
class RayCounter {
 public:
  RayCounter(const Matches& matches, int begin, int end, RayWorkspace& space)
      : matches_{matches}, space_{space}, begin_{begin}, counts_{space.sums.row(begin + 1)}, columns_{end - begin} {
    static_assert(relief_bins_per_px == ray_bins_per_px);
    const Relief<Host>& relief{space.relief};
    std::fill(counts_, counts_ + columns_ * pitch(), PackedRays{0});
    for (int i{0}; i < ray_block_columns; ++i) {
      const int u{begin + std::min(i, columns_ - 1)};
      unused_[i] = (u - begin) * pitch();
      rows_[i] = space.rows.data() + space.margin - space.shift[static_cast<std::size_t>(u)];
      raised_[i] = relief.is_plane() ? &on_plane : relief.rows.row(std::min(u / sector_px, relief.rows.height - 1));
      is_even_ = is_even_ && rows_[i] == rows_[0] && (i % sector_px != 0 || is_level(relief, u));
    }
  }

  HWY_INLINE AmbiguousPixels run() {
    for (int v{0}; v < space_.height; ++v) {
      const float* const obstacle{matches_.obstacle.row(v) + begin_};
      const float* const road{matches_.road.row(v) + begin_};
      prefetch(v + rows_ahead);
      for_vectors(Floats{}, columns_, [&](int i, auto n) HWY_ATTR {
        add(v, i, load(Floats{}, obstacle + i, n), load(Floats{}, road + i, n));
      });
    }
    for (int i{0}; i < columns_; ++i) counts_[unused_[i]] = 0;
    return ambiguous_;
  }

 private:
  static constexpr std::int16_t on_plane{0};
  static constexpr int rows_ahead{8};

  // Processors foresee steps along a row only. The block before has read the first columns' line.
  HWY_INLINE void prefetch(int v) const {
    if (v >= space_.height) return;
    hwy::Prefetch(matches_.obstacle.row(v) + begin_ + columns_ - 1);
    hwy::Prefetch(matches_.road.row(v) + begin_ + columns_ - 1);
  }

  [[nodiscard]] int pitch() const { return space_.bins + 1; }
  [[nodiscard]] int raised_bins() const { return space_.relief.is_plane() ? 1 : space_.relief.rows.width; }
  [[nodiscard]] HWY_INLINE RayRows rows_of(int v, int column, VInt bin) const {
    if (is_even_) {
      const RayRow& row{rows_[0][v]};
      return {ints(row.first), ints(row.end), floats(row.drop)};
    }
    HWY_ALIGN std::int32_t bins[lanes_max];
    HWY_ALIGN std::int32_t first[lanes_max];
    HWY_ALIGN std::int32_t end[lanes_max];
    HWY_ALIGN float drop[lanes_max];
    hn::Store(hn::Min(bin, ints(raised_bins() - 1)), Ints{}, bins);
    for (int i{0}; i < lanes_max; ++i) {
      const RayRow& row{rows_[column + i][v + raised_[column + i][bins[i]]]};
      first[i] = row.first;
      end[i] = row.end;
      drop[i] = row.drop;
    }
    return {hn::Load(Ints{}, first), hn::Load(Ints{}, end), hn::Load(Floats{}, drop)};
  }

  HWY_INLINE void add(int v, int column, VFloat obstacle, VFloat road) {
    const VInt signs{hn::BroadcastSignBit(hn::BitCast(Ints{}, obstacle))};
    std::int32_t* const ambiguous{ambiguous_.data() + column};
    hn::StoreU(hn::Sub(hn::LoadU(Ints{}, ambiguous), signs), Ints{}, ambiguous);
    const auto is_obstacle = hn::Gt(obstacle, hn::Zero(Floats{}));
    const VFloat disparity{hn::IfThenElse(is_obstacle, obstacle, road)};
    const auto is_matched = hn::Gt(disparity, hn::Zero(Floats{}));
    if (hn::AllFalse(Floats{}, is_matched)) return;
    const Mask is_ray{hn::RebindMask(Ints{}, is_matched)};
    const VInt bin{hn::ConvertTo(Ints{}, hn::Mul(disparity, floats(ray_bins_per_px)))};
    const RayRows rows{rows_of(v, column, bin)};
    const Mask is_before{hn::And(hn::And(is_ray, hn::Lt(bin, rows.first)), hn::Lt(rows.first, rows.end))};
    const Mask is_seen{hn::And(hn::And(is_ray, hn::Lt(bin, rows.end)), hn::Lt(rows.first, rows.end))};
    const Places places{hn::Load(Ints{}, unused_ + column)};
    add_ends(places.at(hn::And(is_ray, hn::Lt(bin, ints(space_.bins))), bin),
             ends_of(is_obstacle, disparity, rows.drop),
             hn::IfThenElseZero(hn::AndNot(is_before, is_seen), ints(arriving_ray >> word_bits)));
    add_to(places, is_before, rows.first, arriving_ray);
    add_to(places, hn::And(is_seen, hn::Lt(rows.end, ints(space_.bins))), rows.end, PackedRays{0} - arriving_ray);
  }

  /// Places of counts; those of other pixels are not used.
  struct Places {
    VInt unused;

    [[nodiscard]] HWY_INLINE VInt at(Mask is_used, VInt bin) const {
      return hn::Add(unused, hn::IfThenElseZero(is_used, hn::Add(bin, ints(1))));
    }
  };

  // Lower word of the rays that end at an obstacle or on the road.
  [[nodiscard]] HWY_INLINE VInt ends_of(hn::Mask<Floats> is_obstacle, VFloat disparity, VFloat drop) const {
    const UprightRange& range{space_.upright};
    const auto is_upright = hn::And(hn::Ge(drop, hn::Mul(floats(range.top_drop_m), disparity)),
                                    hn::Le(drop, hn::Mul(floats(range.bottom_drop_m), disparity)));
    return hn::IfThenElse(hn::RebindMask(Ints{}, is_obstacle),
                          hn::IfThenElseZero(hn::RebindMask(Ints{}, is_upright), ints(ending_ray)),
                          ints(ending_on_road));
  }

  HWY_INLINE void add_ends(VInt places, VInt low, VInt high) {
    static_assert(std::endian::native == std::endian::little);
    HWY_ALIGN std::int32_t at[lanes_max];
    HWY_ALIGN std::uint32_t words[2 * lanes_max];
    hn::Store(places, Ints{}, at);
    hn::StoreInterleaved2(hn::BitCast(Bits{}, low), hn::BitCast(Bits{}, high), Bits{}, words);
    for (int i{0}; i < lanes_max; ++i) {
      PackedRays rays{0};
      std::memcpy(&rays, words + 2 * i, sizeof rays);
      counts_[at[i]] += rays;
    }
  }

  HWY_INLINE void add_to(const Places& places, Mask chosen, VInt bin, PackedRays rays) {
    if (hn::AllFalse(Ints{}, chosen)) return;
    HWY_ALIGN std::int32_t at[lanes_max];
    hn::Store(places.at(chosen, bin), Ints{}, at);
    for (const std::int32_t place : at) counts_[place] += rays;
  }

  static constexpr int word_bits{32};

  const Matches& matches_;
  RayWorkspace& space_;
  int begin_;
  PackedRays* counts_;
  int columns_;
  bool is_even_{true};  ///< all pixels of a row have one RayRow
  AmbiguousPixels ambiguous_{};
  HWY_ALIGN std::int32_t unused_[ray_block_columns];
  const RayRow* rows_[ray_block_columns];          ///< row 0 of a column, on the plane
  const std::int16_t* raised_[ray_block_columns];  ///< rows by bin
};

AmbiguousPixels CountRayBlock(const Matches& matches, int begin, int end, RayWorkspace& space) {
  return RayCounter{matches, begin, end, space}.run();
}

}  // namespace
}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(CountRayBlock);

AmbiguousPixels count_ray_block(const Matches& matches, int begin, int end, RayWorkspace& space) {
  return HWY_DYNAMIC_DISPATCH(CountRayBlock)(matches, begin, end, space);
}

}  // namespace stereogrid
#endif
