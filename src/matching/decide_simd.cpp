// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along the pixels of a row.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/decide_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                        // IWYU pragma: keep
// after foreach_target
#include "hwy/highway.h"
#include "matching/decide_simd.hpp"

#include <algorithm>
#include <cstddef>

namespace stereogrid {
// Compiled for no instruction set: with one, g++ takes vectors for single numbers here, which is slower.
void claim_places(int width, DecideSpace& space);
}  // namespace stereogrid

HWY_BEFORE_NAMESPACE();
namespace stereogrid {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Ints = hn::CappedTag<std::int32_t, 16>;
using Floats = hn::Rebind<float, Ints>;
using IntVector = hn::Vec<Ints>;
using FloatVector = hn::Vec<Floats>;

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

FloatVector real(IntVector values) {
  return hn::ConvertTo(Floats{}, values);
}

// subpixel_offset
FloatVector offset_of(IntVector before, IntVector at, IntVector after) {
  const Floats d;
  const auto rise = hn::Sub(hn::Max(before, after), at);
  const auto quotient = hn::Div(real(hn::Sub(before, after)), real(hn::Add(rise, rise)));
  const auto bounded = hn::Min(hn::Max(quotient, hn::Set(d, -0.49f)), hn::Set(d, 0.49f));
  return hn::IfThenElseZero(hn::RebindMask(d, hn::Gt(rise, hn::Zero(Ints{}))), bounded);
}

// inverse_root
FloatVector inverse_roots(FloatVector x) {
  const Floats d;
  const hn::Rebind<std::uint32_t, Floats> bits;
  const auto half = hn::Mul(hn::Set(d, 0.5f), x);
  const auto guess = hn::Sub(hn::Set(bits, root_guess), hn::ShiftRight<1>(hn::BitCast(bits, x)));
  const auto improved = [&](FloatVector root) {
    return hn::Mul(root, hn::Sub(hn::Set(d, 1.5f), hn::Mul(hn::Mul(half, root), root)));
  };
  return improved(improved(hn::BitCast(d, guess)));
}

// Columns from u on; hn::Iota would write them to memory one by one.
IntVector columns_from(int u) {
  return hn::Add(hn::Iota(Ints{}, 0), hn::Set(Ints{}, u));
}

// confidence_of
FloatVector confidence(const ConfidenceModel& model, hn::Mask<Floats> is_road, IntVector cost, IntVector rise,
                       IntVector margin, FloatVector disparity) {
  const Floats d;
  const auto weight = [&](float ConfidenceWeights::*member) {
    return hn::IfThenElse(is_road, hn::Set(d, model.road.*member), hn::Set(d, model.upright.*member));
  };
  const auto up_to = [&](FloatVector value, float most) { return hn::Min(value, hn::Set(d, most)); };
  const auto scaled = [&](IntVector value) { return hn::Mul(real(value), hn::Set(d, model.per_cost)); };
  const auto rise_share = scaled(rise);
  auto x = weight(&ConfidenceWeights::constant);
  const auto add = [&](float ConfidenceWeights::*member, FloatVector term) {
    x = hn::Add(x, hn::Mul(weight(member), term));
  };
  add(&ConfidenceWeights::cost, up_to(scaled(cost), 0.5f));
  add(&ConfidenceWeights::small_rise, up_to(rise_share, 0.02f));
  add(&ConfidenceWeights::rise, up_to(rise_share, 0.08f));
  add(&ConfidenceWeights::margin, up_to(scaled(margin), 0.06f));
  add(&ConfidenceWeights::near_disparity, up_to(hn::Mul(disparity, hn::Set(d, 0.05f)), 1.0f));
  add(&ConfidenceWeights::disparity, up_to(hn::Mul(disparity, hn::Set(d, 0.0125f)), 1.0f));
  const auto half = hn::Set(d, 0.5f);
  const auto per_length = inverse_roots(hn::Add(hn::Set(d, 1.0f), hn::Mul(x, x)));
  return hn::Add(half, hn::Mul(half, hn::Mul(x, per_length)));
}

// winner_of, and whether anything is wrong with it but its claim
void find_winners(const DecideRow& row, int u, DecideSpace& space) {
  const Ints d32;
  const Floats df;
  const hn::Rebind<std::uint8_t, Ints> d8;
  const auto set = [&](int value) { return hn::Set(d32, value); };
  const CandidateRow& upright{row.candidates.upright};
  const CandidateRow& level{row.candidates.level};
  const auto tilt = hn::ShiftRight<2>(hn::Add(hn::Mul(columns_from(u), set(row.road.slope)), set(2)));
  const auto road = hn::Add(tilt, set(row.road.start));
  const auto upright_cost = load(upright.cost() + u);
  const auto level_cost = load(level.cost() + u);
  const auto is_road = hn::And(hn::Gt(road, set(65535)), hn::Lt(level_cost, upright_cost));
  const auto best = [&](const auto* of_upright, const auto* of_level) {
    return hn::IfThenElse(is_road, load(of_level + u), load(of_upright + u));
  };
  const auto cost = hn::IfThenElse(is_road, level_cost, upright_cost);
  const auto before = best(upright.before(), level.before());
  const auto after = best(upright.after(), level.after());
  auto within = real(best(upright.shift(), level.shift()));
  if (row.subpixel) {
    within = hn::Add(within, offset_of(before, cost, after));
  }
  const auto base = hn::IfThenElseZero(hn::RebindMask(df, is_road), hn::Mul(real(road), hn::Set(df, 1.0f / 65536)));
  const auto disparity = hn::Add(base, within);
  const auto unique = hn::Eq(best(upright.rivals(), level.rivals()), set(0));
  const auto in_range = hn::And(hn::Ge(disparity, hn::Set(df, 0.5f)),
                                hn::Lt(disparity, hn::Set(df, static_cast<float>(row.disparities) - 0.5f)));
  const auto textured = hn::Gt(hn::PromoteTo(d32, hn::LoadU(d8, row.textured + u)), set(0));
  const auto cheap = hn::Lt(cost, set(row.confidences.cost_limit + 1));
  const auto good = hn::And(hn::And(hn::And(unique, cheap), textured), hn::RebindMask(d32, in_range));
  const auto label = hn::IfThenElseZero(good, hn::IfThenElse(is_road, set(2), set(1)));
  const auto whole = hn::ConvertTo(d32, hn::Add(disparity, hn::Set(df, 0.5f)));
  const auto right_u = hn::Sub(columns_from(u), whole);
  const auto place = hn::Min(hn::Max(right_u, set(-1)), set(row.width));
  const auto rank = hn::Or(hn::ShiftLeft<16>(cost), hn::And(whole, set(65535)));
  hn::StoreU(hn::Add(place, set(1)), d32, space.place.data() + u);
  hn::StoreU(rank, d32, reinterpret_cast<std::int32_t*>(space.rank.data()) + u);
  const auto margin = hn::Abs(hn::Sub(level_cost, upright_cost));
  const auto rise = hn::Sub(hn::Min(before, after), cost);
  hn::StoreU(confidence(row.confidences, hn::RebindMask(df, is_road), cost, rise, margin, disparity), df,
             space.confidence.data() + u);
  hn::StoreU(disparity, df, space.disparity.data() + u);
  hn::StoreU(hn::DemoteTo(d8, label), d8, space.label.data() + u);
}

// To obstacle[u] and so on, whole vectors.
void write_results(const DecideRow& row, int u, const DecideSpace& space, float* obstacle, float* on_road,
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

void Decide(const DecideRow& row, DecideSpace& space) {
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

void claim_places(int width, DecideSpace& space) {
  std::uint32_t* const claims{space.claims.data()};
  const std::int32_t* const place{space.place.data()};
  const std::uint32_t* const rank{space.rank.data()};
  std::fill(space.claims.begin(), space.claims.end(), ~std::uint32_t{0});
  for (int u{0}; u < width; ++u) claims[place[u]] = std::min(claims[place[u]], rank[u]);
}

DecideSpace::DecideSpace(int width) {
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

void decide_row(const DecideRow& row, DecideSpace& space) {
  HWY_DYNAMIC_DISPATCH(Decide)(row, space);
}

}  // namespace stereogrid
#endif
