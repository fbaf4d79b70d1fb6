// SPDX-License-Identifier: Apache-2.0
//
// The decision at a pixel for numbers, on host and device, and for vectors of them. No guard, no namespace: model.hpp
// includes it, and the vector code once more for each instruction set, whose functions must be compiled for it.

/// Sub-pixel place of a cost curve's minimum between the integers, from the costs one step before, at and after it: the
/// equiangular fit of Shimizu and Okutomi, made for costs that rise linearly. Within ±0.49, so that rounding gives the
/// integer back.
template <class Int>
STEREOGRID_HD inline auto subpixel_offset(Int before, Int at, Int after) {
  const auto rise = Max(before, after) - at;
  const auto offset = real(before - after) / real(rise + rise);
  const auto bounded = Min(Max(offset, number(offset, -0.49f)), number(offset, 0.49f));
  return IfThenElseZero(condition(offset, rise > number(rise, 0)), bounded);
}

/// Evidence for a disparity, from the winner's cost, its rise to the cheaper neighbour, the other hypothesis' distance
/// (all costs) and the disparity (px): straight lines with ends, fitted to lidar and exact truth; nothing in it rounds
/// differently elsewhere.
template <class Condition, class Int, class Real>
STEREOGRID_HD inline Real evidence_of(const ConfidenceModel& model, Condition is_road, Int cost, Int rise, Int margin,
                                      Real disparity) {
  const auto constant = [&](float value) { return number(disparity, value); };
  const auto weight = [&](float ConfidenceWeights::*member) {
    return IfThenElse(is_road, constant(model.road.*member), constant(model.upright.*member));
  };
  const auto term = [&](float ConfidenceWeights::*member, Real value, float most) {
    return weight(member) * Min(value, constant(most));
  };
  const auto share = [&](Int value) { return real(value) * constant(model.per_cost); };
  const Real rise_share{share(rise)};
  return weight(&ConfidenceWeights::constant) + term(&ConfidenceWeights::cost, share(cost), 0.5f) +
         term(&ConfidenceWeights::small_rise, rise_share, 0.02f) + term(&ConfidenceWeights::rise, rise_share, 0.08f) +
         term(&ConfidenceWeights::margin, share(margin), 0.06f) +
         term(&ConfidenceWeights::near_disparity, disparity * constant(0.05f), 1.0f) +
         term(&ConfidenceWeights::disparity, disparity * constant(0.0125f), 1.0f);
}

/// Probability that a disparity is right to a pixel: a sigmoid of its evidence.
template <class Real>
STEREOGRID_HD inline Real confidence_of(Real evidence) {
  const Real half{number(evidence, 0.5f)};
  return half + half * (evidence * inverse_root(number(evidence, 1.0f) + evidence * evidence));
}

/// Whether the road hypothesis can win: its disparity is 1 px or more.
template <class Int>
STEREOGRID_HD inline auto road_counts(Int road_65536) {
  return road_65536 > number(road_65536, 65535);
}

/// Candidate of one of the hypotheses. `Candidates`: members like Candidate's, of one type.
template <class Candidates, class Condition>
STEREOGRID_HD inline Candidates chosen_of(Condition is_road, const Candidates& upright, const Candidates& level) {
  const auto best = [&](auto Candidates::*member) { return IfThenElse(is_road, level.*member, upright.*member); };
  return {best(&Candidates::cost), best(&Candidates::has_rivals), best(&Candidates::before), best(&Candidates::after),
          best(&Candidates::shift)};
}

/// Match of the cheaper hypothesis at a pixel.
template <class Int, class Real, class Condition>
struct WinnerOf {
  Condition is_road;
  Int cost;
  Real disparity;          ///< px
  Int whole;               ///< px: the column of the right image that is claimed is u − whole
  Condition is_plausible;  ///< unique, cheap enough and within the disparities searched
  Real evidence;           ///< confidence_of makes a probability of it
};

/// The paper's decision without a threshold (T-ITS 2012, III-C): road where the road hypothesis costs less. `chosen`:
/// candidate of the cheaper one; `lead`: cost of the road hypothesis less that of the upright one.
template <class Candidates, class Int>
STEREOGRID_HD inline auto winner_of(const Candidates& chosen, Int lead, Int road_65536, int disparities, bool subpixel,
                                    const ConfidenceModel& confidences) {
  const auto is_road = And(road_counts(road_65536), lead < number(lead, 0));
  const Int cost{chosen.cost};
  auto within = real(chosen.shift);
  if (subpixel) within = within + subpixel_offset(chosen.before, cost, chosen.after);
  const auto on_road = real(road_65536) * number(within, 1.0f / 65536);
  const auto disparity = IfThenElseZero(condition(within, is_road), on_road) + within;
  const auto half = number(disparity, 0.5f);
  const auto in_range = And(disparity >= half, disparity < number(disparity, static_cast<float>(disparities) - 0.5f));
  const auto unique = chosen.has_rivals == number(cost, 0);
  const auto cheap = cost < number(cost, confidences.cost_limit + 1);
  const auto evidence = evidence_of(confidences, condition(disparity, is_road), cost,
                                    Min(chosen.before, chosen.after) - cost, Abs(lead), disparity);
  return WinnerOf<Int, std::decay_t<decltype(disparity)>, std::decay_t<decltype(is_road)>>{
      is_road, cost, disparity, whole(disparity + half), And(And(unique, cheap), condition(cost, in_range)), evidence};
}
