// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along the pixels of a row.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/checks/classify_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                                 // IWYU pragma: keep
// after foreach_target
#include "hwy/highway.h"
#include "matching/checks/classify_simd.hpp"
#include "numbers_simd.hpp"

#include <algorithm>
#include <cstddef>
#include <type_traits>

namespace stereogrid {
// Compiled for no instruction set: with one, g++ takes vectors for single numbers here, which is slower.
void claim_places(int width, ClassifySpace& space);
}  // namespace stereogrid

HWY_BEFORE_NAMESPACE();
namespace stereogrid {
namespace HWY_NAMESPACE {
namespace {

#include "matching/checks/winner_formulas.hpp"

using Ints = hn::CappedTag<std::int32_t, 16>;
using Floats = hn::Rebind<float, Ints>;
using IntVector = hn::Vec<Ints>;

IntVector load(const std::uint16_t* values) {
  const Ints d32;
  const hn::Rebind<std::uint16_t, Ints> d16;
  return hn::PromoteTo(d32, hn::LoadU(d16, values));
}

IntVector load(const std::int16_t* values) {
  const Ints d32;
  const hn::Rebind<std::int16_t, Ints> d16;
  return hn::PromoteTo(d32, hn::LoadU(d16, values));
}

// A CandidateRow's members from u on.
struct CandidateVectors {
  IntVector cost;
  IntVector has_rivals;
  IntVector before;
  IntVector after;
  IntVector shift;
};
HWY_INLINE CandidateVectors candidates_from(const CandidateRow& row, int u) {
  return {load(row.cost() + u), load(row.has_rivals() + u), load(row.before() + u), load(row.after() + u),
          load(row.shift() + u)};
}

// winner_of, and whether anything is wrong with it but its claim
HWY_INLINE void find_winners(const DecideRow& row, int u, ClassifySpace& space) {
  const Ints d32;
  const Floats df;
  const hn::Rebind<std::uint8_t, Ints> d8;
  const auto set = [&](int value) { return hn::Set(d32, value); };
  const auto tilt = hn::ShiftRight<2>(hn::Add(hn::Mul(numbers_from(Ints{}, u), set(row.road.slope)), set(2)));
  const auto winner = winner_of(candidates_from(row.candidates.upright, u), candidates_from(row.candidates.level, u),
                                hn::Add(tilt, set(row.road.start)), row.disparities, row.subpixel, row.confidences);
  const auto textured = hn::Gt(hn::PromoteTo(d32, hn::LoadU(d8, row.textured + u)), set(0));
  const auto good = hn::And(winner.is_plausible, textured);
  const auto label = hn::IfThenElseZero(good, hn::IfThenElse(winner.is_road, set(2), set(1)));
  const auto right_u = hn::Sub(numbers_from(Ints{}, u), winner.whole);
  const auto place = hn::Min(hn::Max(right_u, set(-1)), set(row.width));
  const auto rank = hn::Or(hn::ShiftLeft<16>(winner.cost), hn::And(winner.whole, set(65535)));
  hn::StoreU(hn::Add(place, set(1)), d32, space.place.data() + u);
  hn::StoreU(rank, d32, reinterpret_cast<std::int32_t*>(space.rank.data()) + u);
  hn::StoreU(winner.confidence, df, space.confidence.data() + u);
  hn::StoreU(winner.disparity, df, space.disparity.data() + u);
  hn::StoreU(hn::DemoteTo(d8, label), d8, space.label.data() + u);
}

// To obstacle[u] and so on, whole vectors.
void write_results(const DecideRow& row, int u, const ClassifySpace& space, float* obstacle, float* on_road,
                   float* confidence) {
  const Ints d32;
  const Floats df;
  const hn::Rebind<std::uint8_t, Ints> d8;
  const auto set = [&](int value) { return hn::Set(d32, value); };
  const auto lower_half = [](IntVector rank) { return hn::ShiftRight<16>(hn::ShiftLeft<16>(rank)); };
  const auto rank = hn::LoadU(d32, reinterpret_cast<const std::int32_t*>(space.rank.data()) + u);
  const auto place = hn::LoadU(d32, space.place.data() + u);
  const auto claimed = hn::GatherIndex(d32, reinterpret_cast<const std::int32_t*>(space.claims.data()), place);
  const auto difference = hn::Abs(hn::Sub(lower_half(claimed), lower_half(rank)));
  const auto inside = hn::And(hn::Gt(place, set(0)), hn::Lt(place, set(row.width + 1)));
  const auto consistent = hn::And(inside, hn::Lt(difference, set(row.left_right_px + 1)));
  const auto label = hn::PromoteTo(d32, hn::LoadU(d8, space.label.data() + u));
  const auto disparity = hn::LoadU(df, space.disparity.data() + u);
  const auto is = [&](int wanted) { return hn::RebindMask(df, hn::And(consistent, hn::Eq(label, set(wanted)))); };
  hn::StoreU(hn::IfThenElseZero(is(1), disparity), df, obstacle + u);
  hn::StoreU(hn::IfThenElseZero(is(2), disparity), df, on_road + u);
  const auto sure = hn::LoadU(df, space.confidence.data() + u);
  hn::StoreU(hn::IfThenElseZero(hn::Or(is(1), is(2)), sure), df, confidence + u);
}

void Decide(const DecideRow& row, ClassifySpace& space) {
  const int lanes{static_cast<int>(hn::Lanes(Ints{}))};
  for (int u{0}; u < row.width; u += lanes) find_winners(row, u, space);
  claim_places(row.width, space);
  int u{0};
  for (; u + lanes <= row.width; u += lanes) write_results(row, u, space, row.obstacle, row.on_road, row.confidence);
  if (u == row.width) return;
  write_results(row, u, space, space.obstacle.data(), space.on_road.data(), space.confidence.data());
  const auto copy = [&](const std::vector<float>& from, float* to) {
    std::copy(from.begin() + u, from.begin() + row.width, to + u);
  };
  copy(space.obstacle, row.obstacle);
  copy(space.on_road, row.on_road);
  copy(space.confidence, row.confidence);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stereogrid
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(Decide);

void claim_places(int width, ClassifySpace& space) {
  std::uint32_t* const claims{space.claims.data()};
  const std::int32_t* const place{space.place.data()};
  const std::uint32_t* const rank{space.rank.data()};
  std::fill(space.claims.begin(), space.claims.end(), ~std::uint32_t{0});
  for (int u{0}; u < width; ++u) claims[place[u]] = std::min(claims[place[u]], rank[u]);
}

ClassifySpace::ClassifySpace(int width) {
  const std::size_t size{static_cast<std::size_t>(width) + CandidateRow::padding};
  place.resize(size);
  rank.resize(size);
  disparity.resize(size);
  label.resize(size);
  obstacle.resize(size);
  on_road.resize(size);
  confidence.resize(size);
  claims.resize(size);
}

void classify_row(const DecideRow& row, ClassifySpace& space) {
  HWY_DYNAMIC_DISPATCH(Decide)(row, space);
}

}  // namespace stereogrid
#endif
