// SPDX-License-Identifier: Apache-2.0
//
// Equations 8 and 14 for floats, on host and device, and for vectors of them. No guard, no namespace: model.hpp
// includes it, and the vector code once more for each instruction set, whose functions must be compiled for it.

/// Constants of both as numbers of type T.
template <class T>
struct BinConstants {
  T one;
  T half;
  T lowest;   ///< P_FN
  T highest;  ///< 1 − P_FP
};

/// Eq. 8: occupancy from visibility P(V) and obstacle confidence P(C).
template <class T>
STEREOGRID_HD inline T obstacle_probability(T visible, T confidence, const BinConstants<T>& numbers) {
  return visible * confidence * numbers.highest + visible * (numbers.one - confidence) * numbers.lowest +
         (numbers.one - visible) * numbers.half;
}

/// Eq. 14, kept within what a sensor with errors can know (docs/method.md §5.3). Min and Max: Highway's, for vectors.
template <class T>
STEREOGRID_HD inline T occupancy_probability(T obstacle, T road, const BinConstants<T>& numbers) {
  return Min(Max(obstacle * (numbers.one - road), numbers.lowest), numbers.highest);
}
