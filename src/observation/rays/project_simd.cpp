// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along the cells of a row; each goes
// through the operations of find_rays in their order.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "observation/rays/project_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                                 // IWYU pragma: keep
// after foreach_target
#include "hwy/highway.h"
#include "numbers_simd.hpp"
#include "observation/rays/simd.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {
namespace {

#include "observation/rays/evidence_formulas.hpp"

using Floats = hn::CappedTag<float, 16>;
using Ints = hn::RebindToSigned<Floats>;
using Bits = hn::RebindToUnsigned<Floats>;
using VFloat = hn::Vec<Floats>;
using VInt = hn::Vec<Ints>;
using VBits = hn::Vec<Bits>;
using Mask = hn::Mask<Floats>;

constexpr std::size_t lanes_max{hn::MaxLanes(Floats{})};

HWY_INLINE VFloat floats(float value) {
  return hn::Set(Floats{}, value);
}
HWY_INLINE VInt ints(int value) {
  return hn::Set(Ints{}, value);
}

/// ColumnPart of each cell.
struct Columns {
  VInt begin;
  VInt end;
  VFloat share;

  HWY_INLINE Columns(VInt from, VInt to)
      : begin{from}, end{to}, share{hn::Div(floats(1), hn::ConvertTo(Floats{}, hn::Sub(to, from)))} {}
};

/// Two words of PackedRays, of each cell.
struct Words {
  VBits low;
  VBits high;

  HWY_INLINE Words() {}  // an implicit one would not be of this instruction set

  template <PackedRays kind>
  [[nodiscard]] HWY_INLINE VFloat count() const {
    constexpr int shift{kind == ending_ray ? 0 : (kind == ending_on_road ? ray_bits : 2 * ray_bits)};
    static_assert(PackedRays{1} << shift == kind);
    return hn::ConvertTo(Floats{}, hn::BitCast(Ints{}, hn::And(from<shift>(), hn::Set(Bits{}, (1U << ray_bits) - 1))));
  }

 private:
  // Kind of a bit.
  template <int bit>
  [[nodiscard]] HWY_INLINE VBits from() const {
    constexpr int word{32};
    if constexpr (bit == 0) return low;
    if constexpr (bit > 0 && bit < word) return hn::Or(hn::ShiftRight<bit>(low), hn::ShiftLeft<word - bit>(high));
    if constexpr (bit >= word) return hn::ShiftRight<bit - word>(high);
  }
};

/// RaysAround of each cell.
struct Around {
  Words before;
  Words behind;
  VFloat part;

  HWY_INLINE Around() {}

  template <PackedRays kind>
  [[nodiscard]] HWY_INLINE VFloat count() const {
    const VFloat least{before.template count<kind>()};
    return hn::Add(least, hn::Mul(part, hn::Sub(behind.template count<kind>(), least)));
  }
};

template <PackedRays kind>
HWY_INLINE VFloat between(const Around& first, const Around& last, const Columns& columns) {
  return hn::Mul(hn::Sub(last.template count<kind>(), first.template count<kind>()), columns.share);
}

/// Positions of cells in the image, and a mask of those inside.
struct Sight {
  VFloat near_px;
  VFloat far_px;
  Columns columns;
  Columns wide;
  Mask is_seen;
};

/// Computes cells of a grid, many at a time.
class CellVectors {
 public:
  CellVectors(const RaySums<Host>& sums, int most_columns, const CellsInView& cells)
      : sums_{sums}, pitch_{static_cast<int>(sums.pitch)}, most_columns_{most_columns}, cells_{cells} {}

  // Occupancy of cells ix, ix + 1 … of row iy.
  [[nodiscard]] HWY_INLINE VFloat occupancy(int ix, int iy) const {
    const VFloat unknown{floats(0.5f)};
    const Sight cells{sight(ix, iy)};
    if (hn::AllFalse(Floats{}, cells.is_seen)) return unknown;
    Around near[1];
    look_up(cells.columns, {place_of(cells.near_px)}, near);
    // without arriving rays a cell is ½, as known_share says
    const Mask is_seen{hn::And(cells.is_seen, hn::Gt(near[0].count<arriving_ray>(), floats(0)))};
    if (hn::AllFalse(Floats{}, is_seen)) return unknown;
    return hn::IfThenElse(is_seen, seen_occupancy(cells, near[0]), unknown);
  }

 private:
  // `near`: the neighbourhood of their near ends.
  [[nodiscard]] HWY_INLINE VFloat seen_occupancy(const Sight& cells, const Around& near) const {
    const Columns& columns{cells.columns};
    const auto nearer = [&](float px) HWY_ATTR { return place_of(hn::Add(cells.near_px, floats(px))); };
    const auto farther = [&](float px) HWY_ATTR { return place_of(hn::Sub(cells.far_px, floats(px))); };
    enum { far, near_4, near_1, far_1, far_4 };
    Around at[5];
    look_up(columns, {farther(0), nearer(4), nearer(1), farther(1), farther(4)}, at);
    Around ends[2];
    look_up(cells.wide, {farther(cells_.blur_px), nearer(cells_.blur_px)}, ends);
    const RayWeights weights{};
    VFloat sum{floats(0)};
    const auto add = [&](int kind, VFloat count)
                         HWY_ATTR { sum = hn::Add(sum, (evidence_of)(count, unit_of(kind), weights.value[kind])); };
    const auto arriving_at = [&](const Around& where)
                                 HWY_ATTR { return hn::Mul(where.template count<arriving_ray>(), columns.share); };
    const VFloat all{arriving_at(near)};
    add(ending, between<ending_ray>(ends[0], ends[1], cells.wide));
    add(behind, between<ending_ray>(at[far_4], at[far], columns));
    add(in_front, between<ending_ray>(near, at[near_4], columns));
    add(road_in_front, between<ending_on_road>(near, at[near_1], columns));
    add(arriving, all);
    add(passing, arriving_at(at[far]));
    add(passing_farther, arriving_at(at[far_1]));
    return (probability_of)((log_odds_of)(all, sum));
  }

  [[nodiscard]] HWY_INLINE Sight sight(int ix, int iy) const {
    const CellPlaces& places{cells_.places};
    const VFloat x{hn::ConvertTo(Floats{}, numbers_from(Ints{}, ix))};
    const VFloat ahead_m{hn::Add(floats(places.x_of(0, iy)), hn::Mul(floats(places.along), x))};
    const VFloat left_m{hn::Add(floats(places.y_of(0, iy)), hn::Mul(floats(places.across), x))};
    const VFloat half{floats(cells_.half_m)};
    const VFloat columns_per_m{hn::Div(floats(cells_.focal_px), ahead_m)};
    const VInt begin{border(columns_per_m, hn::Add(left_m, half))};
    const VInt right{border(columns_per_m, hn::Sub(left_m, half))};
    const VInt end{hn::IfThenElse(hn::Gt(right, begin), right, hn::Add(begin, ints(1)))};
    const Columns columns{within(begin), within(end)};
    const Columns wide{within(hn::Sub(begin, ints(columns_around))), within(hn::Add(end, ints(columns_around)))};
    const VFloat near_px{disparity(hn::Sub(ahead_m, half))};  // behind the camera: not above 0
    const float nearest_px{static_cast<float>(bins_of(sums_)) / ray_bins_per_px - 1};
    const auto is_wide_enough =
        hn::And(hn::Gt(columns.end, columns.begin), hn::Gt(ints(most_columns_ + 1), hn::Sub(wide.end, wide.begin)));
    const Mask is_seen{hn::And(hn::And(hn::Gt(near_px, floats(0)), hn::Le(near_px, floats(nearest_px))),
                               hn::RebindMask(Floats{}, is_wide_enough))};
    return {near_px, disparity(hn::Add(ahead_m, half)), columns, wide, is_seen};
  }

  [[nodiscard]] HWY_INLINE VFloat disparity(VFloat ahead_m) const {
    return hn::Div(floats(cells_.focal_baseline_pxm), ahead_m);
  }
  // Between two columns; some outside the image.
  [[nodiscard]] HWY_INLINE VInt border(VFloat columns_per_m, VFloat left_m) const {
    const VFloat column{hn::Sub(floats(cells_.cx_px), hn::Mul(columns_per_m, left_m))};
    const VFloat last{floats(static_cast<float>(columns_of(sums_) + 1))};
    const VFloat limited{hn::Min(hn::Max(column, floats(-2)), last)};
    return hn::Sub(whole(hn::Add(limited, floats(3))), ints(2));
  }
  [[nodiscard]] HWY_INLINE VInt within(VInt column) const {
    return hn::Min(hn::Max(column, ints(0)), ints(columns_of(sums_)));
  }
  // A place between bins: bin k, and how far on to the next.
  struct Between {
    VInt k;
    VFloat part;
  };
  [[nodiscard]] HWY_INLINE Between place_of(VFloat disparity) const {
    const VFloat last{floats(static_cast<float>(bins_of(sums_)))};
    const VFloat place{hn::Min(hn::Max(hn::Mul(disparity, floats(ray_bins_per_px)), floats(0)), last)};
    const VInt k{hn::Min(whole(place), ints(bins_of(sums_) - 1))};
    return {k, hn::Sub(place, hn::ConvertTo(Floats{}, k))};
  }
  // Both bins of a place lie side by side: loads of both are faster than gathers of one. All are stored before the
  // first is read again, which would have to wait.
  template <std::size_t count>
  HWY_INLINE void look_up(const Columns& columns, const Between (&places)[count], Around (&found)[count]) const {
    HWY_ALIGN std::int32_t begin[lanes_max];
    HWY_ALIGN std::int32_t end[lanes_max];
    HWY_ALIGN std::int32_t bins[count][lanes_max];
    HWY_ALIGN std::uint32_t words[count][4 * lanes_max];
    hn::Store(hn::Mul(columns.begin, ints(pitch_)), Ints{}, begin);
    hn::Store(hn::Mul(columns.end, ints(pitch_)), Ints{}, end);
    for (std::size_t i{0}; i < count; ++i) hn::Store(places[i].k, Ints{}, bins[i]);
    for (std::size_t c{0}; c < hn::Lanes(Floats{}); ++c) {
      const PackedRays* const at_begin{sums_.data + begin[c]};
      const PackedRays* const at_end{sums_.data + end[c]};
      for (std::size_t i{0}; i < count; ++i) {
        const int k{bins[i][c]};
        store_difference(hn::CappedTag<PackedRays, 2>{}, at_end + k, at_begin + k, &words[i][4 * c]);
      }
    }
    for (std::size_t i{0}; i < count; ++i) {
      Words& before{found[i].before};
      Words& behind{found[i].behind};
      hn::LoadInterleaved4(Bits{}, words[i], before.low, before.high, behind.low, behind.high);
      found[i].part = places[i].part;
    }
  }

  // Two numbers less two others.
  template <class D>
  HWY_INLINE static void store_difference(D d, const PackedRays* from, const PackedRays* less, std::uint32_t* words) {
    static_assert(std::endian::native == std::endian::little);
    if constexpr (hn::MaxLanes(D{}) == 2) {
      const hn::Repartition<std::uint32_t, D> of_words;
      hn::Store(hn::BitCast(of_words, hn::Sub(hn::LoadU(d, from), hn::LoadU(d, less))), of_words, words);
    } else {
      const PackedRays difference[2]{from[0] - less[0], from[1] - less[1]};
      std::memcpy(words, difference, sizeof difference);
    }
  }

  const RaySums<Host>& sums_;
  int pitch_;
  int most_columns_;
  const CellsInView& cells_;
};

void ProjectRayCells(const RaySums<Host>& sums, int most_columns, const CellsInView& in_view, const CellRange& range,
                     View<float> cells) {
  const CellVectors vectors{sums, most_columns, in_view};
  for (int iy{range.y_begin}; iy < range.y_end; ++iy) {
    float* const row{cells.row(iy)};
    for (int ix{range.x_begin}; ix < range.x_end; ix += static_cast<int>(hn::Lanes(Floats{}))) {
      const Mask is_in_row{hn::FirstN(Floats{}, static_cast<std::size_t>(range.x_end - ix))};
      hn::BlendedStore(vectors.occupancy(ix, iy), is_in_row, Floats{}, row + ix);
    }
  }
}

}  // namespace
}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(ProjectRayCells);

void project_ray_cells(const RaySums<Host>& sums, int most_columns, const CellsInView& in_view, const CellRange& range,
                       View<float> cells) {
  HWY_DYNAMIC_DISPATCH(ProjectRayCells)(sums, most_columns, in_view, range, cells);
}

}  // namespace stereogrid
#endif
