// SPDX-License-Identifier: Apache-2.0
//
// Evidence of the counted rays of a cell, for floats, on host and device, and for vectors of cells. No guard, no
// namespace: model.hpp includes it, and the vector code once more for each instruction set, whose functions must be
// compiled for it. Names in brackets are those next to the caller, as in filter/cell_formulas.hpp.

/// Addend to the log odds for `count` ≥ 0 rays of a kind (rounding errors below are harmless), without the factor of
/// known_share. docs/method.md §6.2.
template <class T>
STEREOGRID_HD inline T evidence_of(T count, float unit, float weight) {
  return number(count, weight) * (natural_log)(number(count, 1.0f) + count * number(count, 1 / unit));
}

template <class T>
STEREOGRID_HD inline T known_share(T arriving) {
  return arriving / (arriving + number(arriving, half_known_rays));
}

template <class T>
STEREOGRID_HD inline T probability_of(T log_odds) {
  const T one{number(log_odds, 1.0f)};
  const T most{number(log_odds, log_odds_max)};
  const T against{number(log_odds, 0.0f) - log_odds};
  return one / (one + (exponential)(Min(Max(against, number(log_odds, -log_odds_max)), most)));
}

/// Limits a weighted sum of evidence. Weak evidence against an obstacle counts little: some obstacles have no match,
/// and rays seem to pass through. docs/method.md §6.2.
template <class T>
STEREOGRID_HD inline T log_odds_of(T arriving_rays, T sum) {
  const T log_odds{(known_share)(arriving_rays)*sum};
  const T square{log_odds * log_odds};
  const T power{square * square * square};
  const T against{log_odds * (power / (power + number(sum, power_of_weak_log_odds)))};
  return IfThenElse(log_odds < number(sum, 0.0f), against, log_odds);
}
