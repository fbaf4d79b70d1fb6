// SPDX-License-Identifier: Apache-2.0
//
// Likelihood of a disparity if a plane is the ground, for floats and for vectors of samples. No guard, no namespace:
// plane_evidence.hpp includes it, and the vector code once more for each instruction set, whose functions must be
// compiled for it.

template <class T>
STEREOGRID_HD inline T expected_of(const PlaneHypothesis& plane, T x, T y) {
  return number(x, plane.at_centre) + number(x, plane.per_u) * x + number(x, plane.per_v) * y;
}

/// Variance of disparities on the plane, px².
template <class T>
STEREOGRID_HD inline T variance_of(const PlaneHypothesis& plane, T expected) {
  const T uneven{number(expected, plane.flatness) * expected};
  return number(expected, plane.noise_px * plane.noise_px) + uneven * uneven;
}

/// Weight of a sample by distance, 0.15 … 1: the nearest half of the view counts fully, slopes and stairs ahead less.
template <class T>
STEREOGRID_HD inline T weight_of_distance(const PlaneHypothesis& plane, T expected) {
  constexpr float far_weight{0.15F};
  const T share{expected * number(expected, 2 / plane.near_px)};
  return Max(Min(share, number(share, 1.0F)), number(share, far_weight));
}

/// Likelihood of one disparity if the plane is the ground, by visibility: a sample lies on the ground, above it
/// (obstacles stand on ground: neutral) or below it (ground is opaque: unlikely).
template <class T>
struct PlaneTerm {
  T evidence;   ///< ln(p(d | plane) / p(d | no ground)), nats; 0 where the plane cannot be seen
  T on;         ///< probability that the sample is on the plane
  T precision;  ///< 1/σ² of samples on the plane, px⁻²
  T expected;   ///< disparity of the plane, px
  T residual;   ///< d − expected, px
  T weight;     ///< weight_of_distance; 0 where the plane cannot be seen
};

template <class T>
STEREOGRID_HD inline PlaneTerm<T> term_of(const PlaneHypothesis& plane, float disparities, T x, T y, T d) {
  constexpr float on_share{0.5F};
  constexpr float above_share{0.47F};
  constexpr float above_share_ahead{0.12F};  // in front of the wheels the space is free: the vehicle stands there
  constexpr float below_share{0.03F};        // mirrors and mismatches
  constexpr float ahead_part{0.7F};          // share of near_px
  constexpr float least_range_px{4};
  constexpr float inverse_root_2pi{0.39894228F};
  constexpr float least_exponent{-80};
  const auto of = [&](float value) { return number(x, value); };
  const T e{(expected_of)(plane, x, y)};
  const T r{d - e};
  const T root{(inverse_root)((variance_of)(plane, e))};
  const T precision{root * root};
  const T exponent{Max(of(-0.5F) * (r * r) * precision, of(least_exponent))};
  const T normal{of(on_share * inverse_root_2pi) * root * (exponential)(exponent)};
  const auto is_ahead = And(Abs(x) * of(plane.per_path_px) <= e, e >= of(ahead_part * plane.near_px));
  const auto is_above = r > of(0);
  const T range{of(disparities) - e};
  const T side{IfThenElse(is_above, IfThenElse(is_ahead, of(above_share_ahead), of(above_share)), of(below_share))};
  const T width{Max(IfThenElse(is_above, range, e), of(least_range_px))};
  const T all{normal + side / width};
  const auto is_seen = And(e > of(ground_px_min), range > of(1));  // the plane is there, and can be matched
  return {IfThenElseZero(is_seen, (natural_log)(all * of(disparities))),
          IfThenElseZero(is_seen, normal / all),
          precision,
          e,
          r,
          IfThenElseZero(is_seen, (weight_of_distance)(plane, e))};
}

/// Addends of one sample to sums and to a distribution of shares.
template <class T, std::size_t count>
struct PlaneAddends {
  T sums[count];
  T share;   ///< 0 … 1
  T weight;  ///< weight of the share
};

/// Addends of support_of(). `weight`: of PlaneSamples.
template <class T>
STEREOGRID_HD inline PlaneAddends<T, support_sums> support_addends(const PlaneHypothesis& plane, float disparities, T x,
                                                                   T y, T d, T weight) {
  constexpr float near_part{0.5F};
  constexpr float ring_part{0.7F};
  const auto of = [&](float value) { return number(x, value); };
  const PlaneTerm<T> term{(term_of)(plane, disparities, x, y, d)};
  const T whole_weight{IfThenElseZero(term.weight > of(0), weight)};
  const T by_distance{weight * term.weight};
  const T nats{by_distance * term.evidence};
  const auto is_on = term.on > of(0.5F);
  const auto is_near = term.expected >= of(near_part * plane.near_px);
  const auto is_nearest = term.expected >= of(ring_part * plane.near_px);
  const T below{IfThenElseZero(term.residual < of(0), by_distance)};
  const T near_weight{IfThenElseZero(is_near, whole_weight)};
  const T ring_weight{IfThenElseZero(is_nearest, whole_weight)};
  return {{nats, IfThenElseZero(is_near, nats), IfThenElseZero(is_on, by_distance), IfThenElse(is_on, of(0), below),
           near_weight, IfThenElseZero(is_on, near_weight), ring_weight, IfThenElseZero(is_on, ring_weight)},
          term.expected * of(1 / plane.near_px),
          IfThenElseZero(is_on, whole_weight)};
}

/// Addends of equations_of(): of the vector for 1, x and y, and of the matrix for 1, x, y, x², xy and y². `weight`: of
/// PlaneSamples.
template <class T>
STEREOGRID_HD inline PlaneAddends<T, equation_sums> equation_addends(const PlaneHypothesis& plane, float disparities,
                                                                     T x, T y, T d, T weight) {
  constexpr float nearest_far_px{4};  // farther away, the feet of obstacles have as many samples as ground
  const auto of = [&](float value) { return number(x, value); };
  const PlaneTerm<T> term{(term_of)(plane, disparities, x, y, d)};
  const auto counts = term.expected >= of(nearest_far_px < plane.near_px / 4 ? nearest_far_px : plane.near_px / 4);
  const T by_distance{IfThenElseZero(counts, weight * term.weight)};
  const T one{by_distance * term.on * term.precision};
  const T r{one * term.residual};
  const T of_x{one * x};
  const T of_y{one * y};
  const T deviation{Abs(term.residual) * of(1 / deviation_max_px)};
  return {{r, r * x, r * y, one, of_x, of_y, of_x * x, of_x * y, of_y * y},
          deviation,
          IfThenElseZero(deviation < of(1), by_distance)};
}

/// Bin of a share, 0 … share_bins − 1.
template <class T>
STEREOGRID_HD inline auto bin_of(T share) {
  const T bin{share * number(share, 1.0F * share_bins)};
  return whole(Max(Min(bin, number(share, share_bins - 1.0F)), number(share, 0.0F)));
}

/// The weight of a share in whole parts: sums do not depend on their order.
template <class T>
STEREOGRID_HD inline auto parts_of(T weight) {
  return whole(weight * number(weight, 1.0F * share_parts));
}
