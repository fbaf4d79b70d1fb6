// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along the samples.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "ground/plane_evidence_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                              // IWYU pragma: keep
// after foreach_target
#include "ground/plane_evidence.hpp"
#include "hwy/highway.h"
#include "numbers_simd.hpp"

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {
namespace {

#include "ground/plane_formulas.hpp"

using D = hn::CappedTag<float, plane_lanes>;
using V = hn::Vec<D>;
constexpr std::size_t lanes{hn::MaxLanes(D{})};
constexpr std::size_t parts{plane_lanes / lanes};

// Adds by halves.
HWY_INLINE float sum_of(const V (&part)[parts]) {
  HWY_ALIGN float sums[plane_lanes];
  for (std::size_t p{0}; p < parts; ++p) hn::Store(part[p], D{}, sums + p * lanes);
  for (std::size_t half{plane_lanes / 2}; half > 0; half /= 2) {
    for (std::size_t i{0}; i < half; ++i) sums[i] += sums[i + half];
  }
  return sums[0];
}

struct Columns {
  const float* of[4];  // x, y, disparity, weight

  HWY_INLINE V load(int column, std::size_t at) const { return hn::LoadU(D{}, of[column] + at); }
};

// Addends of plane_lanes samples from `at` on. Those over the horizon add nothing.
template <std::size_t count, class AddendsOf>
HWY_INLINE void add(const PlaneHypothesis& plane, const Columns& columns, std::size_t at, const AddendsOf& addends_of,
                    V (&sums)[count][parts], std::array<std::uint64_t, share_bins>& bins) {
  HWY_ALIGN std::int32_t bin[lanes];
  HWY_ALIGN std::int32_t weight[lanes];
  for (std::size_t p{0}; p < parts; ++p) {
    const std::size_t i{at + p * lanes};
    const V x{columns.load(0, i)};
    const V y{columns.load(1, i)};
    if (hn::AllFalse(D{}, hn::Gt((expected_of)(plane, x, y), hn::Set(D{}, ground_px_min)))) continue;
    const auto addends = addends_of(x, y, columns.load(2, i), columns.load(3, i));
    for (std::size_t k{0}; k < count; ++k) sums[k][p] = hn::Add(sums[k][p], addends.sums[k]);
    const hn::Rebind<std::int32_t, D> ints;
    hn::Store((bin_of)(addends.share), ints, bin);
    hn::Store((parts_of)(addends.weight), ints, weight);
    for (std::size_t lane{0}; lane < lanes; ++lane)
      bins[static_cast<std::size_t>(bin[lane])] += static_cast<std::uint32_t>(weight[lane]);
  }
}

template <std::size_t count, class AddendsOf>
HWY_INLINE void sum_blocks(const PlaneHypothesis& plane, const PlaneSamples& samples, std::span<const float> weights,
                           const AddendsOf& addends_of, PlaneSums<count>& all) {
  const Columns columns{{samples.x.data(), samples.y.data(), samples.disparity.data(), weights.data()}};
  for (std::size_t begin{0}; begin < samples.size(); begin += plane_block) {
    V sums[count][parts];
    for (auto& sum : sums) {
      for (V& part : sum) part = hn::Zero(D{});
    }
    const std::size_t end{std::min(begin + plane_block, samples.size())};
    std::size_t i{begin};
    for (; i + plane_lanes <= end; i += plane_lanes) add(plane, columns, i, addends_of, sums, all.bins);
    if (i < end) {  // samples without weight add nothing
      float rest[4][plane_lanes]{};
      for (std::size_t k{0}; k < 4; ++k) std::copy(columns.of[k] + i, columns.of[k] + end, rest[k]);
      add(plane, {{rest[0], rest[1], rest[2], rest[3]}}, 0, addends_of, sums, all.bins);
    }
    for (std::size_t k{0}; k < count; ++k) all.sums[k] += sum_of(sums[k]);
  }
}

void SumSupport(const PlaneHypothesis& plane, const PlaneSamples& samples, PlaneSums<support_sums>& all) {
  const auto addends_of = [&](V x, V y, V d, V weight)
                              HWY_ATTR { return (support_addends)(plane, samples.disparities, x, y, d, weight); };
  sum_blocks(plane, samples, samples.weight, addends_of, all);
}

void SumEquations(const PlaneHypothesis& plane, const PlaneSamples& samples, std::span<const float> weights,
                  PlaneSums<equation_sums>& all) {
  const auto addends_of = [&](V x, V y, V d, V weight)
                              HWY_ATTR { return (equation_addends)(plane, samples.disparities, x, y, d, weight); };
  sum_blocks(plane, samples, weights, addends_of, all);
}

}  // namespace
}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(SumSupport);
HWY_EXPORT(SumEquations);

PlaneSums<support_sums> sum_support(const PlaneHypothesis& plane, const PlaneSamples& samples) {
  PlaneSums<support_sums> all;
  HWY_DYNAMIC_DISPATCH(SumSupport)(plane, samples, all);
  return all;
}

PlaneSums<equation_sums> sum_equations(const PlaneHypothesis& plane, const PlaneSamples& samples,
                                       std::span<const float> weights) {
  PlaneSums<equation_sums> all;
  HWY_DYNAMIC_DISPATCH(SumEquations)(plane, samples, weights, all);
  return all;
}

}  // namespace stereogrid
#endif
