// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along the cells of a row; each goes
// through the operations of find_rays in their order.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "rays/project_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                     // IWYU pragma: keep
// after foreach_target
#include "hwy/highway.h"
#include "rays/project_simd.hpp"

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace stereogrid {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Reals = hn::CappedTag<double, 8>;
using Floats = hn::Rebind<float, Reals>;
using Ints = hn::Rebind<std::int32_t, Reals>;
using Bits = hn::Rebind<std::uint32_t, Reals>;
using Packed = hn::Rebind<PackedRays, Reals>;
using VReal = hn::Vec<Reals>;
using VFloat = hn::Vec<Floats>;
using VInt = hn::Vec<Ints>;
using VPacked = hn::Vec<Packed>;
using Mask = hn::Mask<Floats>;

HWY_INLINE VReal reals(double value) {
  return hn::Set(Reals{}, value);
}
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

/// RaysAround of each cell.
struct Around {
  VPacked before;
  VPacked behind;
  VFloat part;

  HWY_INLINE Around() {}  // an implicit one would not be of this instruction set

  template <PackedRays kind>
  HWY_INLINE static VFloat count_of(VPacked rays) {
    constexpr int shift{kind == ending_ray ? 0 : (kind == ending_on_road ? ray_bits : 2 * ray_bits)};
    static_assert(PackedRays{1} << shift == kind);
    const auto low = hn::TruncateTo(Bits{}, hn::ShiftRight<shift>(rays));
    const auto count = hn::And(low, hn::Set(Bits{}, (1U << ray_bits) - 1));
    return hn::ConvertTo(Floats{}, hn::BitCast(Ints{}, count));
  }
  template <PackedRays kind>
  [[nodiscard]] HWY_INLINE VFloat count() const {
    const VFloat least{count_of<kind>(before)};
    return hn::Add(least, hn::Mul(part, hn::Sub(count_of<kind>(behind), least)));
  }
};

template <PackedRays kind>
HWY_INLINE VFloat between(const Around& first, const Around& last, const Columns& columns) {
  return hn::Mul(hn::Sub(last.template count<kind>(), first.template count<kind>()), columns.share);
}

/// Where cells lie in the image, and which of them do.
struct Sight {
  VFloat near_px;
  VFloat far_px;
  Columns columns;
  Columns wide;
  Mask is_seen;
};

/// Looks up cells of a grid, many at a time.
class CellVectors {
 public:
  CellVectors(const RaySums<Host>& sums, int most_columns, const BinGeometry& geometry, const GridInVehicle& grid)
      : sums_{sums},
        pitch_{static_cast<int>(sums.pitch)},
        most_columns_{most_columns},
        geometry_{geometry},
        grid_{grid} {}

  // Of cells ix, ix + 1 … of row iy.
  [[nodiscard]] HWY_INLINE Sight sight(int ix, int iy) const {
    const double size_m{grid_.grid.cell_size_m};
    const VReal at{hn::Add(hn::Iota(Reals{}, ix), reals(0.5))};
    const VReal x{hn::Add(reals(grid_.grid.x_min_m), hn::Mul(at, reals(size_m)))};
    const VReal y{reals(grid_.grid.y_min_m + (iy + 0.5) * size_m)};
    const VReal c{reals(grid_.cos_yaw)};
    const VReal s{reals(grid_.sin_yaw)};
    const VReal ahead_m{hn::Sub(hn::Add(reals(grid_.x_m), hn::Mul(c, x)), hn::Mul(s, y))};
    const VReal left_m{hn::Add(hn::Add(reals(grid_.y_m), hn::Mul(s, x)), hn::Mul(c, y))};
    const VReal half{reals(size_m / 2)};
    const VInt begin{border(ahead_m, hn::Add(left_m, half))};
    const VInt right{border(ahead_m, hn::Sub(left_m, half))};
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

  // At the near ends of cells.
  [[nodiscard]] HWY_INLINE Around near(const Sight& cells) const {
    Around found[1];
    look_up(cells.columns, {place_of(cells.near_px)}, found);
    return found[0];
  }

  // write(kind, counts) for each kind of CellRays. `near`: of these cells.
  template <class Write>
  HWY_INLINE void look_up(const Sight& cells, const Around& near, const Write& write) const {
    const Columns& columns{cells.columns};
    const auto nearer = [&](float px) HWY_ATTR { return place_of(hn::Add(cells.near_px, floats(px))); };
    const auto farther = [&](float px) HWY_ATTR { return place_of(hn::Sub(cells.far_px, floats(px))); };
    enum { far, near_4, near_1, far_1, far_4 };
    Around at[5];
    look_up(columns, {farther(0), nearer(4), nearer(1), farther(1), farther(4)}, at);
    Around ends[2];
    look_up(cells.wide, {farther(0.5f), nearer(0.5f)}, ends);
    write(ending, between<ending_ray>(ends[0], ends[1], cells.wide));
    write(behind, between<ending_ray>(at[far_4], at[far], columns));
    write(in_front, between<ending_ray>(near, at[near_4], columns));
    write(road_in_front, between<ending_on_road>(near, at[near_1], columns));
    const auto arrive = [&](const Around& where)
                            HWY_ATTR { return hn::Mul(where.template count<arriving_ray>(), columns.share); };
    write(arriving, arrive(near));
    write(passing, arrive(at[far]));
    write(passing_farther, arrive(at[far_1]));
  }

 private:
  [[nodiscard]] HWY_INLINE VFloat disparity(VReal ahead_m) const {
    return hn::DemoteTo(Floats{}, hn::Div(reals(geometry_.focal_baseline_pxm), ahead_m));
  }
  // Between two columns; some outside the image.
  [[nodiscard]] HWY_INLINE VInt border(VReal ahead_m, VReal left_m) const {
    const VReal column{
        hn::Sub(reals(geometry_.centre_u_px), hn::Div(hn::Mul(reals(geometry_.focal_px), left_m), ahead_m))};
    const VReal limited{hn::Min(hn::Max(column, reals(-2)), reals(columns_of(sums_) + 1))};
    return hn::Sub(hn::DemoteTo(Ints{}, hn::Add(limited, reals(3))), ints(2));
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
    const VInt k{hn::Min(hn::ConvertTo(Ints{}, place), ints(bins_of(sums_) - 1))};
    return {k, hn::Sub(place, hn::ConvertTo(Floats{}, k))};
  }
  // Both bins of a place lie side by side: loads of both are faster than gathers of one. All are stored before the
  // first is read again, which would have to wait.
  template <std::size_t count>
  HWY_INLINE void look_up(const Columns& columns, const Between (&places)[count], Around (&found)[count]) const {
    constexpr std::size_t lanes{hn::MaxLanes(Reals{})};
    HWY_ALIGN std::int32_t begin[lanes];
    HWY_ALIGN std::int32_t end[lanes];
    HWY_ALIGN std::int32_t bins[count][lanes];
    HWY_ALIGN PackedRays pairs[count][2 * lanes];
    hn::Store(hn::Mul(columns.begin, ints(pitch_)), Ints{}, begin);
    hn::Store(hn::Mul(columns.end, ints(pitch_)), Ints{}, end);
    for (std::size_t i{0}; i < count; ++i) hn::Store(places[i].k, Ints{}, bins[i]);
    const hn::CappedTag<PackedRays, 2> pair;
    for (std::size_t c{0}; c < lanes; ++c) {
      const PackedRays* const at_begin{sums_.data + begin[c]};
      const PackedRays* const at_end{sums_.data + end[c]};
      for (std::size_t i{0}; i < count; ++i) {
        for (std::size_t j{0}; j < 2; j += hn::Lanes(pair)) {
          const auto k = static_cast<std::size_t>(bins[i][c]) + j;
          hn::Store(hn::Sub(hn::LoadU(pair, at_end + k), hn::LoadU(pair, at_begin + k)), pair, &pairs[i][2 * c + j]);
        }
      }
    }
    for (std::size_t i{0}; i < count; ++i) {
      hn::LoadInterleaved2(Packed{}, pairs[i], found[i].before, found[i].behind);
      found[i].part = places[i].part;
    }
  }

  const RaySums<Host>& sums_;
  int pitch_;
  int most_columns_;
  const BinGeometry& geometry_;
  const GridInVehicle& grid_;
};

/// Counts of those cells that are seen, without gaps between them.
class SeenCells {
 public:
  explicit SeenCells(View<float> cells) : cells_{cells} {}

  // Without arriving rays a cell is ½, as known_share says.
  HWY_INLINE void add(const CellVectors& cells, Sight sight, int ix, int iy) {
    const Around near{cells.near(sight)};
    sight.is_seen = hn::And(sight.is_seen, hn::Gt(near.template count<arriving_ray>(), floats(0)));
    if (hn::AllFalse(Floats{}, sight.is_seen)) return;
    const auto keep = [&](auto d, auto values, auto* to)
                          HWY_ATTR { hn::StoreU(hn::Compress(values, hn::RebindMask(d, sight.is_seen)), d, to); };
    cells.look_up(sight, near,
                  [&](int kind, VFloat counts) HWY_ATTR { keep(Floats{}, counts, &counts_[kind][size_]); });
    keep(Ints{}, hn::Iota(Ints{}, iy * static_cast<int>(cells_.pitch) + ix), &cell_[size_]);
    size_ += hn::CountTrue(Floats{}, sight.is_seen);
  }
  [[nodiscard]] bool is_full() const { return size_ >= at_once; }

  // The compiler makes vectors of it.
  HWY_INLINE void write() {
    const RayWeights weights{};
    float log_odds[at_once + more]{};
    for (int i{0}; i < cell_rays; ++i) {
      // what was looked up of cells that are not seen may be no number
      std::fill(counts_[i] + size_, counts_[i] + at_once + more, 0.0f);
      for (std::size_t c{0}; c < at_once + more; ++c) {
        log_odds[c] += evidence_of(counts_[i][c], unit_of(i), weights.value[i]);
      }
    }
    for (std::size_t c{0}; c < at_once + more; ++c) {
      log_odds[c] = probability_of(log_odds_of(counts_[arriving][c], log_odds[c]));
    }
    for (std::size_t c{0}; c < size_; ++c) cells_.data[cell_[c]] = log_odds[c];
    size_ = 0;
  }

 private:
  static constexpr std::size_t at_once{56};
  static constexpr std::size_t more{8};

  View<float> cells_;
  HWY_ALIGN float counts_[cell_rays][at_once + 2 * more]{};
  std::int32_t cell_[at_once + 2 * more]{};
  std::size_t size_{0};
};

void ProjectRayCells(const RaySums<Host>& sums, int most_columns, const BinGeometry& geometry,
                     const GridInVehicle& grid, const CellRange& range, View<float> cells) {
  const CellVectors vectors{sums, most_columns, geometry, grid};
  const int lanes{static_cast<int>(hn::Lanes(Reals{}))};
  SeenCells seen{cells};
  for (int iy{range.y_begin}; iy < range.y_end; ++iy) {
    float* const row{cells.row(iy)};
    std::fill(row + range.x_begin, row + range.x_end, 0.5f);
    for (int ix{range.x_begin}; ix < range.x_end; ix += lanes) {
      Sight sight{vectors.sight(ix, iy)};
      const auto is_in_row = hn::FirstN(Floats{}, static_cast<std::size_t>(range.x_end - ix));
      sight.is_seen = hn::And(sight.is_seen, is_in_row);
      if (hn::AllFalse(Floats{}, sight.is_seen)) continue;
      seen.add(vectors, sight, ix, iy);
      if (seen.is_full()) seen.write();
    }
  }
  seen.write();
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stereogrid
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(ProjectRayCells);

void project_ray_cells(const RaySums<Host>& sums, int most_columns, const BinGeometry& geometry,
                       const GridInVehicle& grid, const CellRange& range, View<float> cells) {
  HWY_DYNAMIC_DISPATCH(ProjectRayCells)(sums, most_columns, geometry, grid, range, cells);
}

}  // namespace stereogrid
#endif
