// SPDX-License-Identifier: Apache-2.0
//
// Functions of floats, on host and device, and of vectors of them: sums and products only, the same on all machines. No
// guard, no namespace: numbers.hpp includes it, and numbers_simd.hpp once more for each instruction set, whose
// functions must be compiled for it.

/// Natural logarithm of a normal x > 0, to 1e-6; the same on all machines, and without branches.
template <class T>
STEREOGRID_HD inline T natural_log(T x) {
  const auto exponent = exponent_of(x);
  const T t{mantissa_of(x, exponent) - number(x, 1.0f)};
  const auto of = [&](float factor) { return number(x, factor); };
  // polynomial of least error from −¼ to ½
  const T part{
      of(1.0000009f) +
      t * (of(-0.499986653f) +
           t * (of(0.333143244f) +
                t * (of(-0.250605507f) + t * (of(0.206759358f) + t * (of(-0.168271005f) + t * of(0.0831664767f))))))};
  return real(exponent) * of(0.693147181f) + t * part;
}

/// e^x for |x| ≤ 80, to a relative 1e-6; the same on all machines.
template <class T>
STEREOGRID_HD inline T exponential(T x) {
  const auto of = [&](float factor) { return number(x, factor); };
  const T halves{x * of(1.44269504f)};
  const T rounding{of(12582912)};  // 1.5·2^23: sums with it are whole numbers
  const T whole_halves{(halves + rounding) - rounding};
  const T t{(halves - whole_halves) * of(0.693147181f)};
  const T part{
      of(1) +
      t * (of(1) + t * (of(0.5f) + t * (of(0.166666667f) +
                                        t * (of(0.0416666667f) + t * (of(0.00833333333f) + t * of(0.00138888889f))))))};
  return part * power_of_two(whole_halves);
}

/// 1/√x to six digits, of sums and products only: the same everywhere, and many times as fast as a root and
/// a division. An integer view of the number gives a first guess (Quake III's, after C. Walsh), Newton's steps the
/// rest.
template <class T>
STEREOGRID_HD inline T inverse_root(T x) {
  const T half{number(x, 0.5f) * x};
  const T three_halves{number(x, 1.5f)};
  const T guess{less_half_of_bits(0x5f375a86u, x)};
  const T root{guess * (three_halves - half * guess * guess)};
  return root * (three_halves - half * root * root);
}
