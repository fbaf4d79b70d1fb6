// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. What a step looks up of the step before, in vectors
// along the cells of a row.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filter/joint/joint_before_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                                  // IWYU pragma: keep
// after foreach_target
#include "filter/joint/joint_simd.hpp"
#include "filter/resampling/partial_vectors_simd.hpp"
#include "hwy/highway.h"
#include "numbers_simd.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {
namespace {

#include "filter/lattice_formulas.hpp"

#include "filter/cell_formulas.hpp"

using Float = hn::CappedTag<float, block_columns>;

// A bit for each cell of a row of a block, the first one's lowest.
struct RowBits {
  std::uint32_t moving{0};
  std::uint32_t seen{0};
};

template <class D, class Mask>
HWY_INLINE std::uint32_t bits_of(D d, Mask cells) {
  std::uint8_t bytes[8]{};
  hn::StoreMaskBits(d, cells, bytes);
  return bytes[0] | static_cast<std::uint32_t>(bytes[1]) << 8;
}

RowBits bits_of_row(const JointStep& joint, int x_first, int x_end, int y) {
  const FilterState& before{joint.before};
  RowBits bits;
  for_shrinking_vectors(Float{}, x_first, x_end, [&](auto d, int x) {
    const auto occupancy = hn::LoadU(d, before.occupancy.row(y) + x);
    const auto standing = hn::LoadU(d, before.standing.row(y) + x);
    const auto is_unseen = (is_as_unseen)(joint.step, occupancy, standing, hn::LoadU(d, before.age_s.row(y) + x));
    const auto moves = hn::AndNot(is_unseen, (is_moving)(joint.step.moving_from, occupancy, standing));
    bits.moving |= bits_of(d, moves) << (x - x_first);
    bits.seen |= bits_of(d, hn::Not(is_unseen)) << (x - x_first);
  });
  return bits;
}

void extend(CellBox& box, std::uint32_t bits, int x_first, int y) {
  if (bits == 0) return;
  box = {std::min(box.x_first, x_first + std::countr_zero(bits)), std::min(box.y_first, y),
         std::max(box.x_last, x_first + 31 - std::countl_zero(bits)), y};
}

void FindCells(const JointStep& joint, int block_row) {
  const FilterState& before{joint.before};
  FilterWorkspace& space{joint.after.space};
  const BlockLayout& layout{before.blocks.layout()};
  const int first{block_row * layout.across};
  CellBox* const moving{space.moving.data() + first};
  constexpr CellBox none{std::numeric_limits<int>::max(), std::numeric_limits<int>::max(), -1, -1};
  for (int i{0}; i < layout.across; ++i) moving[i] = space.active.seen(first + i) = none;
  const CellBox rows{layout.cells_of(first)};
  for (int y{rows.y_first}; y <= rows.y_last; ++y) {
    for (int i{0}; i < layout.across; ++i) {
      if (before.is_unseen(first + i)) continue;
      const int x{i * block_columns};
      const RowBits bits{bits_of_row(joint, x, std::min(x + block_columns, layout.cells), y)};
      extend(space.active.seen(first + i), bits.seen, x, y);
      extend(moving[i], bits.moving, x, y);
    }
  }
  for (int i{0}; i < layout.across; ++i) {
    const CellBox cells{layout.cells_of(first + i)};
    if (!is_followed(joint.step, cells, joint.scroll.x, joint.scroll.y)) moving[i] = none;
  }
}

void TakeBefore(const JointStep& joint, BlockRow& row) {
  const FilterState& before{joint.before};
  const int y{row.y + joint.scroll.y};
  for_shrinking_vectors(Float{}, 0, row.columns, [&](auto d, int i) {
    const int x{row.x + joint.scroll.x + i};
    const auto age_s = hn::LoadU(d, before.age_s.row(y) + x);
    const auto is_unseen = (is_as_unseen)(joint.step, hn::LoadU(d, before.occupancy.row(y) + x),
                                          hn::LoadU(d, before.standing.row(y) + x), age_s);
    hn::StoreU(age_s, d, row.age_s + i);
    hn::StoreU(hn::LoadU(d, joint.after.space.standing.row(y) + x), d, row.standing + i);
    hn::StoreU(hn::IfThenElseZero(is_unseen, hn::Set(d, 1.0f)), d, row.unseen + i);
  });
}

}  // namespace
}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(FindCells);
HWY_EXPORT(TakeBefore);

void find_cells(const JointStep& joint, int block_row) {
  HWY_DYNAMIC_DISPATCH(FindCells)(joint, block_row);
}
void take_before(const JointStep& joint, BlockRow& row) {
  HWY_DYNAMIC_DISPATCH(TakeBefore)(joint, row);
}

}  // namespace stereogrid
#endif
