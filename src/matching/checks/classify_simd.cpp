// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along the pixels of a row.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/checks/classify_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                                 // IWYU pragma: keep
// after foreach_target
#include "geometry/matches.hpp"
#include "hwy/highway.h"
#include "matching/checks/simd.hpp"
#include "numbers_simd.hpp"

#include <algorithm>
#include <cstddef>
#include <type_traits>

namespace stereogrid {
// Smallest ranks of the row's places, and which of them each pixel meets. Compiled for no instruction set: with one,
// g++ takes vectors for single numbers here, which is slower.
HWY_NOINLINE void claim_places(int width, ClassifyWorkspace& space);
}  // namespace stereogrid

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {
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

template <class Vector>
struct CandidateVectors {
  Vector cost;
  Vector has_rivals;
  Vector before;
  Vector after;
  Vector shift;
};

// A CandidateRow's members: stores of vectors may alias everything, and copies of pointers avoid reloads.
struct CandidatePointers {
  explicit CandidatePointers(CandidateRow& row)
      : cost{row.cost()}, has_rivals{row.has_rivals()}, before{row.before()}, after{row.after()}, shift{row.shift()} {}
  // load(pointer)
  template <class Load>
  [[nodiscard]] HWY_INLINE auto from(int u, const Load& load) const {
    return CandidateVectors<decltype(load(shift))>{load(cost + u), load(has_rivals + u), load(before + u),
                                                   load(after + u), load(shift + u)};
  }

  std::uint16_t* cost;
  std::uint16_t* has_rivals;
  std::uint16_t* before;
  std::uint16_t* after;
  std::int16_t* shift;
};

// Replaces upright candidates where the road hypothesis is cheaper.
HWY_NOINLINE void choose_candidates(const DecideRow& row, std::int16_t* lead) {
  const hn::ScalableTag<std::int16_t> d16;
  const auto set = [&](int value) { return hn::Set(d16, static_cast<std::int16_t>(value)); };
  const auto load = [&](const auto* of) { return hn::LoadU(d16, reinterpret_cast<const std::int16_t*>(of)); };
  const CandidatePointers upright{row.candidates.upright};
  const CandidatePointers level{row.candidates.level};
  const Columns road{columns_of_road(row.road, row.width)};
  const int width{row.width};
  const int lanes{static_cast<int>(hn::Lanes(d16))};
  for (int u{0}; u < width; u += lanes) {
    const auto leads = hn::Sub(load(level.cost + u), load(upright.cost + u));
    hn::StoreU(leads, d16, lead + u);
    const auto column = hn::Add(hn::Iota(d16, 0), set(u));
    const auto counts = hn::And(hn::Gt(column, set(road.begin - 1)), hn::Lt(column, set(road.end)));
    const auto is_road = hn::And(counts, hn::Lt(leads, hn::Zero(d16)));
    if (hn::AllFalse(d16, is_road)) continue;
    const auto chosen = chosen_of(is_road, upright.from(u, load), level.from(u, load));
    const auto store = [&](auto of, auto* to) { hn::StoreU(of, d16, reinterpret_cast<std::int16_t*>(to + u)); };
    store(chosen.cost, upright.cost);
    store(chosen.has_rivals, upright.has_rivals);
    store(chosen.before, upright.before);
    store(chosen.after, upright.after);
    store(chosen.shift, upright.shift);
  }
}

// winner_of, and whether anything is wrong with it but its claim
HWY_NOINLINE void find_winners(const DecideRow& of_row, ClassifyWorkspace& space) {
  const Ints d32;
  const Floats df;
  const hn::Rebind<std::uint8_t, Ints> d8;
  const auto set = [&](int value) { return hn::Set(d32, value); };
  const DecideRow row{of_row};
  const CandidatePointers chosen{row.candidates.upright};
  const std::int16_t* const lead{space.lead.data()};
  auto* const places = reinterpret_cast<std::int32_t*>(space.place.data());
  auto* const ranks = reinterpret_cast<std::int32_t*>(space.rank.data());
  float* const evidence{space.evidence.data()};
  float* const unmatched{space.unmatched.data()};
  float* const labelled{space.labelled.data()};
  const int lanes{static_cast<int>(hn::Lanes(d32))};
  auto place_0 = numbers_from(d32, 1);  // place at disparity 0
  auto tilt = hn::Add(hn::Mul(hn::Iota(d32, 0), set(row.road.slope)), set(2));
  for (int u{0}; u < row.width; u += lanes) {
    const auto road = hn::Add(hn::ShiftRight<2>(tilt), set(row.road.start));
    const auto winner = winner_of(chosen.from(u, [](const auto* of) { return load(of); }), load(lead + u), road,
                                  row.disparities, row.subpixel, row.confidences);
    const auto textured = hn::Gt(hn::PromoteTo(d32, hn::LoadU(d8, row.textured + u)), set(0));
    const auto is_good = condition(winner.disparity, hn::And(winner.is_plausible, textured));
    const auto is_road = condition(winner.disparity, winner.is_road);
    const auto place = hn::Min(hn::Max(hn::Sub(place_0, winner.whole), set(0)), set(row.width + 1));
    const auto rank = hn::Or(hn::ShiftLeft<16>(winner.cost), hn::And(winner.whole, set(65535)));
    hn::StoreU(place, d32, places + u);
    hn::StoreU(rank, d32, ranks + u);
    hn::StoreU(winner.evidence, df, evidence + u);
    const auto is_similar = hn::Lt(winner.cost, set(row.confidences.ambiguous_cost_limit + 1));
    const auto is_upright = hn::AndNot(winner.is_road, hn::Gt(winner.whole, set(0)));
    const auto is_ambiguous = condition(winner.disparity, hn::And(is_upright, hn::And(is_similar, textured)));
    hn::StoreU(hn::IfThenElseZero(is_ambiguous, hn::Set(df, ambiguous_px)), df, unmatched + u);
    const auto sign = hn::IfThenElseZero(is_road, hn::Set(df, -0.0f));
    hn::StoreU(hn::IfThenElseZero(is_good, hn::Xor(winner.disparity, sign)), df, labelled + u);
    place_0 = hn::Add(place_0, set(lanes));
    tilt = hn::Add(tilt, set(lanes * row.road.slope));
  }
}

// To obstacle[u] and so on, whole vectors.
HWY_INLINE void write_results(int left_right_px, int u, const ClassifyWorkspace& space, float* obstacle, float* on_road,
                              float* confidence) {
  const Ints d32;
  const Floats df;
  const auto load = [&](const std::uint32_t* of) {
    return hn::LoadU(d32, reinterpret_cast<const std::int32_t*>(of) + u);
  };
  const auto of_ranks = hn::Sub(load(space.place.data()), load(space.rank.data()));
  const auto difference = hn::Abs(hn::ShiftRight<16>(hn::ShiftLeft<16>(of_ranks)));
  const auto is_consistent = hn::RebindMask(df, hn::Lt(difference, hn::Set(d32, left_right_px + 1)));
  const auto labelled = hn::IfThenElseZero(is_consistent, hn::LoadU(df, space.labelled.data() + u));
  const auto upright = hn::Max(labelled, hn::Zero(df));
  const auto is_unmatched = hn::Eq(labelled, hn::Zero(df));
  const auto sure = confidence_of(hn::LoadU(df, space.evidence.data() + u));
  hn::StoreU(hn::IfThenElse(is_unmatched, hn::LoadU(df, space.unmatched.data() + u), upright), df, obstacle + u);
  hn::StoreU(hn::Sub(upright, labelled), df, on_road + u);
  hn::StoreU(hn::IfThenZeroElse(is_unmatched, sure), df, confidence + u);
}

void Decide(const DecideRow& row, ClassifyWorkspace& space) {
  const int lanes{static_cast<int>(hn::Lanes(Ints{}))};
  choose_candidates(row, space.lead.data());
  find_winners(row, space);
  claim_places(row.width, space);
  const int most{row.left_right_px};
  int u{0};
  for (; u + lanes <= row.width; u += lanes) write_results(most, u, space, row.obstacle, row.on_road, row.confidence);
  if (u == row.width) return;
  write_results(most, u, space, space.obstacle.data(), space.on_road.data(), space.confidence.data());
  const auto copy = [&](const std::vector<float>& from, float* to) {
    std::copy(from.begin() + u, from.begin() + row.width, to + u);
  };
  copy(space.obstacle, row.obstacle);
  copy(space.on_road, row.on_road);
  copy(space.confidence, row.confidence);
}

}  // namespace
}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(Decide);

void claim_places(int width, ClassifyWorkspace& space) {
  std::uint32_t* const claims{space.claims.data()};
  std::uint32_t* const place{space.place.data()};
  const std::uint32_t* const rank{space.rank.data()};
  std::fill(space.claims.begin(), space.claims.end(), ~std::uint32_t{0});
#pragma GCC unroll 4
  for (int u{0}; u < width; ++u) claims[place[u]] = std::min(claims[place[u]], rank[u]);
  claims[0] = claims[width + 1] = 0x8000;
#pragma GCC unroll 4
  for (int u{0}; u < width; ++u) place[u] = claims[place[u]];
}

ClassifyWorkspace::ClassifyWorkspace(int width) {
  const std::size_t size{static_cast<std::size_t>(width) + CandidateRow::padding};
  lead.resize(size);
  place.resize(size);
  rank.resize(size);
  labelled.resize(size);
  evidence.resize(size);
  unmatched.resize(size);
  obstacle.resize(size);
  on_road.resize(size);
  confidence.resize(size);
  claims.resize(size);
}

void classify_row(const DecideRow& row, ClassifyWorkspace& space) {
  HWY_DYNAMIC_DISPATCH(Decide)(row, space);
}

}  // namespace stereogrid
#endif
