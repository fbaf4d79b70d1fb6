// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Numbers of the decision at a pixel, on host and device, and vectors of them. No guard, no namespace: model.hpp
// includes it, and the vector code once more for each instruction set, whose functions must be compiled for it.

/// Costs of a candidate, as its disparity and its evidence depend on them.
template <class Number>
struct CostCurve {
  Number cost;
  Number slope;   ///< from after to before
  Number higher;  ///< rise to the more expensive neighbour
  Number lower;   ///< rise to the cheaper one
};
template <class Int>
STEREOGRID_HD inline CostCurve<Int> curve_of(Int cost, Int before, Int after) {
  return {cost, before - after, Max(before, after) - cost, Min(before, after) - cost};
}

/// Sub-pixel place of a cost curve's minimum between the integers, from the costs one step before, at and after it: the
/// equiangular fit of Shimizu and Okutomi, made for costs that rise linearly. Within ±0.49, so that rounding gives the
/// integer back.
template <class Real>
STEREOGRID_HD inline Real subpixel_offset(Real slope, Real higher) {
  const Real offset{slope / (higher + higher)};
  const Real bounded{Min(Max(offset, number(offset, -0.49f)), number(offset, 0.49f))};
  return IfThenElseZero(higher > number(higher, 0.0f), bounded);
}

/// 1/√x to six digits, for x ≥ 1, of sums and products only: the same everywhere, and many times as fast as a root and
/// a division. An integer view of the number gives a first guess (Quake III's, after C. Walsh), Newton's steps the
/// rest.
template <class Real>
STEREOGRID_HD inline Real inverse_root(Real x) {
  const Real half{number(x, 0.5f) * x};
  const Real three_halves{number(x, 1.5f)};
  const Real guess{less_half_of_bits(0x5f375a86u, x)};
  const Real root{guess * (three_halves - half * guess * guess)};
  return root * (three_halves - half * root * root);
}

/// Evidence for a disparity, from the winner's costs, the other hypothesis' distance (`margin`, a cost) and the
/// disparity (px): straight lines with ends, fitted to lidar and exact truth; nothing in it rounds differently
/// elsewhere. `Weights`: members like those of ConfidenceWeights.
template <class Weights, class Real>
STEREOGRID_HD inline Real evidence_of(const Weights& weight, float per_cost, const CostCurve<Real>& costs, Real margin,
                                      Real disparity) {
  const auto constant = [&](float value) { return number(disparity, value); };
  const auto share = [&](Real cost) { return cost * constant(per_cost); };
  const Real rise{share(costs.lower)};
  return weight.constant + weight.cost * Min(share(costs.cost), constant(0.5f)) +
         weight.small_rise * Min(rise, constant(0.02f)) + weight.rise * Min(rise, constant(0.08f)) +
         weight.margin * Min(share(margin), constant(0.06f)) +
         weight.near_disparity * Min(disparity * constant(0.05f), constant(1.0f)) +
         weight.disparity * Min(disparity * constant(0.0125f), constant(1.0f));
}

/// Probability that a disparity is right to a pixel: a sigmoid of its evidence.
template <class Real>
STEREOGRID_HD inline Real confidence_of(Real evidence) {
  const Real half{number(evidence, 0.5f)};
  return half + half * (evidence * inverse_root(number(evidence, 1.0f) + evidence * evidence));
}

/// Disparity of the road in px.
template <class Int>
STEREOGRID_HD inline auto road_px(Int road_65536) {
  const auto fixed = real(road_65536);
  return fixed * number(fixed, 1.0f / 65536);
}

/// Whether a disparity is one of those searched.
template <class Real>
STEREOGRID_HD inline auto is_searched(Real disparity, int disparities) {
  return And(disparity >= number(disparity, 0.5f),
             disparity < number(disparity, static_cast<float>(disparities) - 0.5f));
}
