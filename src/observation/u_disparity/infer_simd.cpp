// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along the columns of a row.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "observation/u_disparity/infer_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                                      // IWYU pragma: keep
// after foreach_target
#include "hwy/highway.h"
#include "observation/u_disparity/model.hpp"
#include "observation/u_disparity/simd.hpp"
#include "observation/u_disparity/vectors_simd.hpp"

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {
namespace {

#include "observation/u_disparity/bin_formulas.hpp"

constexpr std::size_t lanes_max{16};
using Float = hn::CappedTag<float, lanes_max>;
using Int = hn::Rebind<std::int32_t, Float>;

// Eq. 11 for the columns from u on.
template <class N>
HWY_INLINE hn::VFromD<Float> visibility(const BinRow& row, hn::VFromD<Int> visible, int u, N n) {
  const Float df;
  const Int di;
  const auto shift = load(di, row.shift + u, n);
  const auto first = hn::Max(hn::Add(shift, hn::Set(di, row.first_row)), hn::Zero(di));
  const auto last = hn::Min(hn::Add(shift, hn::Set(di, row.last_row)), hn::Set(di, row.image_height - 1));
  const auto possible = hn::Add(hn::Sub(last, first), hn::Set(di, 1));
  const auto is_possible = hn::RebindMask(df, hn::Gt(possible, hn::Zero(di)));
  const auto rays = hn::ConvertTo(df, hn::Max(possible, hn::Set(di, 1)));
  return hn::IfThenElseZero(is_possible, hn::Div(hn::ConvertTo(df, visible), rays));
}

template <class N>
HWY_INLINE hn::VFromD<Float> road_factor(const BinRow& row, int u, N n) {
  const Float df;
  const Int di;
  const hn::Rebind<std::uint8_t, Float> d8;
  const auto cells = hn::Add(load(d8, row.road_here + u, n),
                             hn::Add(load(d8, row.road_before + u, n), load(d8, row.road_behind + u, n)));
  const auto index = hn::PromoteTo(di, cells);
  if (hn::AllFalse(di, hn::Gt(index, hn::Zero(di)))) return hn::Set(df, row.road_factor[0]);
  return hn::GatherIndex(df, row.road_factor, index);
}

void InferBins(const BinRow& row, int width) {
  const Float df;
  const Int di;
  const hn::Rebind<std::uint16_t, Float> d16;
  const auto one = hn::Set(df, 1.0f);
  const auto half = hn::Set(df, 0.5f);
  const BinConstants<hn::VFromD<Float>> constants{one, half, hn::Set(df, row.false_negative),
                                                  hn::Set(df, 1 - row.false_positive)};
  const auto columns = hn::Iota(di, 0);
  for_vectors(df, width, [&](int u, auto n) {
    const auto count = hn::PromoteTo(di, load(d16, row.visible + u, n));
    const auto observed = hn::PromoteTo(di, load(d16, row.observed + u, n));
    const auto pairs = hn::Mul(count, hn::Add(count, hn::Set(di, 1)));
    auto miss = one;  // most bins have no obstacle pixels
    if (!hn::AllFalse(di, hn::Gt(observed, hn::Zero(di)))) {
      miss = hn::GatherIndex(df, row.miss, hn::Add(hn::ShiftRight<1>(pairs), observed));
    }
    const auto visible = visibility(row, count, u, n);
    const auto confidence = hn::Sub(one, miss);
    const auto road = hn::Mul(road_factor(row, u, n), miss);
    const auto occupied = occupancy_probability(obstacle_probability(visible, confidence, constants), road, constants);
    const auto is_hidden = hn::Lt(hn::Add(columns, hn::Set(di, u)), hn::Set(di, row.first_sighted));
    store(visible, df, row.visibility + u, n);
    store(confidence, df, row.obstacle_confidence + u, n);
    store(road, df, row.road_confidence + u, n);
    store(hn::IfThenElse(hn::RebindMask(df, is_hidden), half, occupied), df, row.occupancy + u, n);
  });
}

void WeighRows(const float* const* in, const float* weights, int count, int width, float* out) {
  const Float df;
  for_vectors(df, width, [&](int u, auto n) {
    auto sum = hn::Mul(hn::Set(df, weights[0]), load(df, in[0] + u, n));
    for (int k{1}; k < count; ++k) sum = hn::Add(sum, hn::Mul(hn::Set(df, weights[k]), load(df, in[k] + u, n)));
    store(sum, df, out + u, n);
  });
}

}  // namespace
}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(InferBins);
HWY_EXPORT(WeighRows);

void infer_bins(const BinRow& row, int width) {
  HWY_DYNAMIC_DISPATCH(InferBins)(row, width);
}

void weigh_rows(const float* const* in, const float* weights, int count, int width, float* out) {
  HWY_DYNAMIC_DISPATCH(WeighRows)(in, weights, count, width, out);
}

}  // namespace stereogrid
#endif
