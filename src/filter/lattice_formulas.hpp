// SPDX-License-Identifier: Apache-2.0
//
// Formulas of a cell and its masses over the velocity lattice, for numbers, on host and device, and for vectors of
// them. No guard, no namespace: model.hpp includes it, and the vector code once more for each instruction set, whose
// functions must be compiled for it.

/// Sums over a row of the lattice, whose velocities share v_y.
template <class T>
struct LatticeRowSums {
  T mass{};
  T x{};   ///< Σ mass · v_x
  T xx{};  ///< Σ mass · v_x²

  STEREOGRID_HD void add(T vx_mps, T of_velocity) {
    mass = mass + of_velocity;
    x = x + vx_mps * of_velocity;
    xx = xx + vx_mps * vx_mps * of_velocity;
  }
};

/// Moments of a cell's mass over the velocity lattice, summed row by row of it.
template <class T>
struct LatticeSums {
  T mass{};
  T x{};  ///< Σ mass · v_x
  T y{};
  T xx{};  ///< Σ mass · v_x²
  T xy{};
  T yy{};

  STEREOGRID_HD void add(T vy_mps, const LatticeRowSums<T>& row) {
    mass = mass + row.mass;
    x = x + row.x;
    y = y + vy_mps * row.mass;
    xx = xx + row.xx;
    xy = xy + vy_mps * row.x;
    yy = yy + vy_mps * vy_mps * row.mass;
  }
};

// Vectors need `none` explicitly: uninitialised vectors are undefined on some machines.
template <class T>
STEREOGRID_HD inline LatticeRowSums<T> no_row_sums(T none) {
  return {none, none, none};
}
template <class T>
STEREOGRID_HD inline LatticeSums<T> no_sums(T none) {
  return {none, none, none, none, none, none};
}

/// Mass of a moving velocity after the velocity noise: the rest, and the gain.
template <class T>
STEREOGRID_HD inline T disturbed(T kept_moving, T mass, T gained) {
  return kept_moving * mass + gained;
}

/// First along x within both rows, then between the rows.
template <class T>
STEREOGRID_HD inline T between(T first, T second, T share) {
  return (number(share, 1.0f) - share) * first + share * second;
}

/// The likelihood of tay2008's P(v_k) at a cell (docs/method.md §8.6): `all` = Σ over both of P(v_k), `occupied` of
/// P(occupied, v_k) predicted; afterwards β_occ(k) and l(k).
template <class T>
struct TayUpdate {
  T occupied;
  T all;
};
template <class T>
STEREOGRID_HD inline TayUpdate<T> tay_update(T all, T occupied, T likelihood_occupied, T likelihood_empty) {
  const T beta{likelihood_occupied * occupied};
  return {beta, beta + likelihood_empty * (all - occupied)};
}

/// The least that velocity evidence says: now and then something else has been measured.
constexpr float likelihood_floor{0.02f};

/// Parts of the squared distance of a velocity from the measurement that depend on its v_x.
template <class T>
struct DistanceAlongX {
  T squares;
  T cross;  ///< times the distance along y
};
template <class Evidence, class T>
STEREOGRID_HD inline DistanceAlongX<T> distance_along_x(const Evidence& evidence, T vx_mps) {
  const T x{vx_mps - evidence.x};
  return {evidence.xx * x * x, number(x, 2.0f) * evidence.xy * x};
}

/// Likelihood of the measurement for a velocity at `y` from it, `y_squares` = yy·y². Its tails end on a floor.
template <class T>
STEREOGRID_HD inline T likelihood_at(const DistanceAlongX<T>& along_x, T y, T y_squares) {
  const T one{number(y, 1.0f)};
  const T near{one / (one + number(y, 0.5f) * (along_x.squares + along_x.cross * y + y_squares))};
  return number(y, likelihood_floor) + near * near * near;
}

/// For the velocity (vx, vy). `Evidence`: members like VelocityEvidence's, each a T.
template <class Evidence, class T>
STEREOGRID_HD inline T likelihood_of(const Evidence& evidence, T vx_mps, T vy_mps) {
  const T y{vy_mps - evidence.y};
  return likelihood_at(distance_along_x(evidence, vx_mps), y, T{evidence.yy * y * y});
}
