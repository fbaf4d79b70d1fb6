// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along the pixels of a row.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/checks/classify_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                                 // IWYU pragma: keep
// after foreach_target
#include "hwy/highway.h"
#include "matching/checks/classify_simd.hpp"
#include "matching/matches.hpp"
#include "numbers_simd.hpp"

#include <algorithm>
#include <cstddef>

namespace stereogrid {
// Smallest ranks of the row's places, and which disparity claims each pixel's. Compiled for no instruction set: with
// one, g++ takes vectors for single numbers here, which is slower.
HWY_NOINLINE void claim_places(int width, ClassifySpace& space);
}  // namespace stereogrid

HWY_BEFORE_NAMESPACE();
namespace stereogrid {
namespace HWY_NAMESPACE {
namespace {

#if HWY_TARGET != HWY_SCALAR

#include "matching/checks/winner_formulas.hpp"

// Costs, shifts and columns have 16 bits; the other numbers of as many pixels fill two vectors.
using Words = hn::ScalableTag<std::int16_t>;
using Ints = hn::RepartitionToWide<Words>;
using Floats = hn::Rebind<float, Ints>;
using WordVector = hn::Vec<Words>;
using IntVector = hn::Vec<Ints>;
using FloatVector = hn::Vec<Floats>;
using WordMask = hn::Mask<Words>;

constexpr int lanes{static_cast<int>(hn::MaxLanes(Words{}))};

HWY_INLINE WordVector words(int value) {
  return hn::Set(Words{}, static_cast<std::int16_t>(value));
}

template <bool is_upper>
HWY_INLINE IntVector half_of(WordVector values) {
  const hn::Half<Words> half;
  if constexpr (is_upper) {
    return hn::PromoteTo(Ints{}, hn::UpperHalf(half, values));
  } else {
    return hn::PromoteTo(Ints{}, hn::LowerHalf(half, values));
  }
}
template <bool is_upper>
HWY_INLINE hn::Mask<Floats> half_of_mask(WordMask values) {
  return hn::RebindMask(Floats{}, hn::MaskFromVec(half_of<is_upper>(hn::VecFromMask(Words{}, values))));
}

struct CandidateVectors {
  WordVector cost;
  WordVector has_rivals;
  WordVector before;
  WordVector after;
  WordVector shift;
};

// A CandidateRow's members: stores of vectors may alias everything, and copies of pointers avoid reloads.
struct CandidatePointers {
  explicit CandidatePointers(const CandidateRow& row)
      : cost{row.cost()}, has_rivals{row.has_rivals()}, before{row.before()}, after{row.after()}, shift{row.shift()} {}

  [[nodiscard]] HWY_INLINE CandidateVectors at(int u) const {
    const auto load = [u](const auto* from) {
      return hn::LoadU(Words{}, reinterpret_cast<const std::int16_t*>(from) + u);
    };
    return {load(cost), load(has_rivals), load(before), load(after), load(shift)};
  }

  const std::uint16_t* cost;
  const std::uint16_t* has_rivals;
  const std::uint16_t* before;
  const std::uint16_t* after;
  const std::int16_t* shift;
};

HWY_INLINE CandidateVectors chosen_of(WordMask is_road, const CandidateVectors& upright,
                                      const CandidateVectors& level) {
  const auto of = [&](auto member) { return hn::IfThenElse(is_road, level.*member, upright.*member); };
  return {of(&CandidateVectors::cost), of(&CandidateVectors::has_rivals), of(&CandidateVectors::before),
          of(&CandidateVectors::after), of(&CandidateVectors::shift)};
}

// ConfidenceWeights of pixels.
struct WeightVectors {
  template <class Of>
  static HWY_INLINE WeightVectors from(const Of& of) {
    return {of(&ConfidenceWeights::constant), of(&ConfidenceWeights::cost),   of(&ConfidenceWeights::small_rise),
            of(&ConfidenceWeights::rise),     of(&ConfidenceWeights::margin), of(&ConfidenceWeights::near_disparity),
            of(&ConfidenceWeights::disparity)};
  }

  FloatVector constant;
  FloatVector cost;
  FloatVector small_rise;
  FloatVector rise;
  FloatVector margin;
  FloatVector near_disparity;
  FloatVector disparity;
};

enum class Surface { upright, road, mixed };

// Winners of pixels side by side.
struct WinnerVectors {
  CostCurve<WordVector> costs;
  WordVector shift;
  WordVector margin;
  WordMask is_road;
  WordMask is_good;  // unique, cheap enough and textured
  WordMask is_ambiguous;
};

// Disparities and confidences of winners, without regard to claims.
class Refinement {
 public:
  Refinement(const DecideRow& row, ClassifySpace& space)
      : road_{row.road},
        disparities_{row.disparities},
        subpixel_{row.subpixel},
        confidences_{row.confidences},
        of_upright_{WeightVectors::from([&](auto of) { return hn::Set(Floats{}, row.confidences.upright.*of); })},
        of_road_{WeightVectors::from([&](auto of) { return hn::Set(Floats{}, row.confidences.road.*of); })},
        labelled_{space.labelled.data()},
        confidence_{space.confidence.data()} {}

  // Of the pixels from u on; returns whole disparities, for upright surfaces the shifts.
  HWY_INLINE WordVector refine(int u, const WinnerVectors& winners) const {
    const Words d16;
    if (hn::AllFalse(d16, winners.is_road)) {
      if (hn::AllFalse(d16, winners.is_good)) {
        refuse<false>(u, winners);
        refuse<true>(u, winners);
      } else {
        refine_half<Surface::upright, false>(u, winners);
        refine_half<Surface::upright, true>(u, winners);
      }
      return winners.shift;
    }
    return hn::AllTrue(d16, winners.is_road) ? refine_road<Surface::road>(u, winners)
                                             : refine_road<Surface::mixed>(u, winners);
  }

 private:
  template <bool is_upper>
  static constexpr int first{is_upper ? lanes / 2 : 0};

  template <Surface surface>
  HWY_INLINE WordVector refine_road(int u, const WinnerVectors& winners) const {
    const Words d16;
    const IntVector lower{refine_half<surface, false>(u, winners)};
    const IntVector upper{refine_half<surface, true>(u, winners)};
    return hn::ConcatEven(d16, hn::BitCast(d16, upper), hn::BitCast(d16, lower));
  }

  template <bool is_upper>
  static HWY_INLINE FloatVector mark_of(const WinnerVectors& winners) {
    return hn::IfThenElseZero(half_of_mask<is_upper>(winners.is_ambiguous), hn::Set(Floats{}, ambiguous_px));
  }

  template <bool is_upper>
  HWY_INLINE void refuse(int u, const WinnerVectors& winners) const {
    const Floats df;
    hn::StoreU(mark_of<is_upper>(winners), df, labelled_ + u + first<is_upper>);
    hn::StoreU(hn::Zero(df), df, confidence_ + u + first<is_upper>);
  }

  template <Surface surface>
  HWY_INLINE WeightVectors weights(hn::Mask<Floats> is_road) const {
    if constexpr (surface == Surface::upright) return of_upright_;
    if constexpr (surface == Surface::road) return of_road_;
    return WeightVectors::from([&](auto of) {
      const Floats df;
      return hn::IfThenElse(is_road, hn::Set(df, confidences_.road.*of), hn::Set(df, confidences_.upright.*of));
    });
  }

  // RoadRow::disparity_px of the columns from u on.
  [[nodiscard]] HWY_INLINE FloatVector road_from(int u) const {
    const Ints d32;
    const auto tilt = hn::Mul(numbers_from(d32, u), hn::Set(d32, road_.slope));
    return road_px(hn::Add(hn::ShiftRight<2>(hn::Add(tilt, hn::Set(d32, 2))), hn::Set(d32, road_.start)));
  }

  template <Surface surface, bool is_upper>
  HWY_INLINE IntVector refine_half(int u, const WinnerVectors& winners) const {
    const Floats df;
    const auto real_of = [](WordVector values) { return real(half_of<is_upper>(values)); };
    const CostCurve<FloatVector> costs{real_of(winners.costs.cost), real_of(winners.costs.slope),
                                       real_of(winners.costs.higher), real_of(winners.costs.lower)};
    const auto is_road = half_of_mask<is_upper>(winners.is_road);
    auto disparity = real_of(winners.shift);
    auto sign = hn::Zero(df);  // negative: road
    if (subpixel_) disparity = disparity + subpixel_offset(costs.slope, costs.higher);
    if constexpr (surface != Surface::upright) {
      disparity = hn::IfThenElseZero(is_road, road_from(u + first<is_upper>)) + disparity;
      sign = hn::IfThenElseZero(is_road, hn::Set(df, -0.0f));
    }
    const auto is_found = hn::And(half_of_mask<is_upper>(winners.is_good), is_searched(disparity, disparities_));
    const auto evidence =
        evidence_of(weights<surface>(is_road), confidences_.per_cost, costs, real_of(winners.margin), disparity);
    const auto found = hn::IfThenElseZero(is_found, hn::Xor(disparity, sign));
    hn::StoreU(hn::Or(found, mark_of<is_upper>(winners)), df, labelled_ + u + first<is_upper>);
    hn::StoreU(hn::IfThenElseZero(is_found, confidence_of(evidence)), df, confidence_ + u + first<is_upper>);
    return whole(disparity + hn::Set(df, 0.5f));
  }

  RoadRow road_;
  int disparities_;
  bool subpixel_;
  ConfidenceModel confidences_;
  WeightVectors of_upright_;
  WeightVectors of_road_;
  float* labelled_;
  float* confidence_;
};

// The cheaper hypothesis at the pixels from u on.
HWY_INLINE WinnerVectors winners_at(int u, const DecideRow& row, Columns road, const CandidatePointers& upright,
                                    const CandidatePointers& level) {
  const Words d16;
  const hn::Rebind<std::uint8_t, Words> d8;
  const auto none = hn::Zero(d16);
  auto chosen = upright.at(u);
  const auto lead = hn::Sub(hn::LoadU(d16, reinterpret_cast<const std::int16_t*>(level.cost) + u), chosen.cost);
  const auto column = numbers_from(d16, static_cast<std::int16_t>(u));
  const auto counts = hn::And(hn::Gt(column, words(road.begin - 1)), hn::Lt(column, words(road.end)));
  const auto is_road = hn::And(counts, hn::Lt(lead, none));
  if (!hn::AllFalse(d16, is_road)) chosen = chosen_of(is_road, chosen, level.at(u));
  const auto is_textured = hn::Gt(hn::PromoteTo(d16, hn::LoadU(d8, row.textured + u)), none);
  const auto has_rivals = hn::Gt(chosen.has_rivals, none);
  const auto is_up_to = [&](int limit) { return hn::Not(hn::Gt(chosen.cost, words(std::min(limit, 32767)))); };
  const auto is_usable = hn::And(is_textured, is_up_to(row.confidences.cost_limit));
  const auto is_tied = hn::AndNot(is_road, is_up_to(row.confidences.ambiguous_cost_limit));
  return {curve_of(chosen.cost, chosen.before, chosen.after),
          chosen.shift,
          hn::Abs(lead),
          is_road,
          hn::AndNot(has_rivals, is_usable),
          hn::And(has_rivals, hn::And(is_usable, is_tied))};
}

// Winners of both hypotheses, and whether anything is wrong with them but their claims.
HWY_NOINLINE void find_winners(const DecideRow& of_row, ClassifySpace& space) {
  const Words d16;
  const DecideRow row{of_row};
  const CandidatePointers upright{row.candidates.upright};
  const CandidatePointers level{row.candidates.level};
  const Columns road{columns_of_road(row.road, row.width)};
  const Refinement refinement{row, space};
  auto* const places = reinterpret_cast<std::int16_t*>(space.place.data());
  auto* const ranks = reinterpret_cast<std::int16_t*>(space.rank.data());
  std::int16_t* const wholes{space.whole.data()};
  for (int u{0}; u < row.width; u += lanes) {
    const WinnerVectors winners{winners_at(u, row, road, upright, level)};
    const WordVector whole{refinement.refine(u, winners)};
    const auto place = hn::SaturatedSub(numbers_from(d16, static_cast<std::int16_t>(u + 1)), whole);
    hn::StoreU(hn::Min(hn::Max(place, hn::Zero(d16)), words(row.width + 1)), d16, places + u);
    hn::StoreU(whole, d16, wholes + u);
    hn::StoreInterleaved2(whole, winners.costs.cost, d16, ranks + 2 * u);
  }
}

struct Results {
  float* obstacle;
  float* on_road;
  float* confidence;
};

// Of the pixels from u on, whole vectors.
HWY_INLINE void write_results(int left_right_px, int u, const ClassifySpace& space, const Results& to) {
  const Words d16;
  const Floats df;
  const auto claimed = hn::LoadU(d16, reinterpret_cast<const std::int16_t*>(space.place.data()) + u);
  const auto off = hn::Abs(hn::Sub(claimed, hn::LoadU(d16, space.whole.data() + u)));
  const auto is_consistent = hn::Lt(off, words(left_right_px + 1));
  const auto write_half = [&](auto is_consistent_half, int first) {
    const auto of_winner = hn::LoadU(df, space.labelled.data() + u + first);
    const auto labelled = hn::IfThenElseZero(is_consistent_half, of_winner);
    const auto upright = hn::Max(labelled, hn::Zero(df));
    const auto mark = hn::IfThenElseZero(hn::Eq(of_winner, hn::Zero(df)), of_winner);
    const auto confidence = hn::LoadU(df, space.confidence.data() + u + first);
    hn::StoreU(hn::Or(upright, mark), df, to.obstacle + first);
    hn::StoreU(hn::Sub(upright, labelled), df, to.on_road + first);
    hn::StoreU(hn::IfThenElseZero(is_consistent_half, confidence), df, to.confidence + first);
  };
  write_half(half_of_mask<false>(is_consistent), 0);
  write_half(half_of_mask<true>(is_consistent), lanes / 2);
}

void Decide(const DecideRow& row, ClassifySpace& space) {
  find_winners(row, space);
  claim_places(row.width, space);
  int u{0};
  for (; u + lanes <= row.width; u += lanes) {
    write_results(row.left_right_px, u, space, {row.obstacle + u, row.on_road + u, row.confidence + u});
  }
  if (u == row.width) return;
  float obstacle[lanes];
  float on_road[lanes];
  float confidence[lanes];
  write_results(row.left_right_px, u, space, {obstacle, on_road, confidence});
  std::copy_n(obstacle, row.width - u, row.obstacle + u);
  std::copy_n(on_road, row.width - u, row.on_road + u);
  std::copy_n(confidence, row.width - u, row.confidence + u);
}

#else

void Decide(const DecideRow&, ClassifySpace&) {}

#endif

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stereogrid
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(Decide);

void claim_places(int width, ClassifySpace& space) {
  constexpr std::uint32_t outside{0x4000};  // far from every disparity that a pixel can have
  std::uint32_t* const claims{space.claims.data()};
  std::uint16_t* const place{space.place.data()};
  const std::uint32_t* const rank{space.rank.data()};
  std::fill(space.claims.begin(), space.claims.end(), ~std::uint32_t{0});
#pragma GCC unroll 4
  for (int u{0}; u < width; ++u) claims[place[u]] = std::min(claims[place[u]], rank[u]);
  claims[0] = claims[width + 1] = outside;
#pragma GCC unroll 4
  for (int u{0}; u < width; ++u) place[u] = static_cast<std::uint16_t>(claims[place[u]]);
}

ClassifySpace::ClassifySpace(int width) {
  const std::size_t size{static_cast<std::size_t>(width) + CandidateRow::padding};
  whole.resize(size);
  place.resize(size);
  rank.resize(size);
  labelled.resize(size);
  confidence.resize(size);
  claims.resize(size);
}

void classify_row(const DecideRow& row, ClassifySpace& space) {
  HWY_DYNAMIC_DISPATCH(Decide)(row, space);
}

}  // namespace stereogrid
#endif
