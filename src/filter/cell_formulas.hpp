// SPDX-License-Identifier: Apache-2.0
//
// Formulas of a cell and its observation, for numbers, on host and device, and for vectors of cells. No guard, no
// namespace: model.hpp includes it, and the vector code once more for each instruction set, whose functions must be
// compiled for it. Names in brackets are those next to the caller: FilterStep would bring in model.hpp's.

/// The likelihoods of an observed probability p formed with prior ½: (p, 1 − p), tempered, and the odds that p is, as
/// they are. docs/method.md §8.3.
template <class T>
struct CellLikelihood {
  T occupied;
  T empty;
  T odds;
};

/// `look(i)`: p to the power of the exponent for p = i / likelihood_steps.
template <class Look, class T>
STEREOGRID_HD inline T tempered(const Look& look, T p) {
  const T at{p * number(p, static_cast<float>(likelihood_steps))};
  const auto floor = whole(at);
  const auto i = Min(floor, number(floor, likelihood_steps - 1));
  return between(T{look(i)}, T{look(i + number(i, 1))}, at - real(i));
}

/// 0 and 1 would make a cell deaf to everything that comes later.
template <class Look, class T>
STEREOGRID_HD inline CellLikelihood<T> likelihood_of_cell(const Look& look, T observed) {
  const T one{number(observed, 1.0f)};
  const T p{Min(Max(observed, number(observed, 0.001f)), number(observed, 0.999f))};
  return {tempered(look, p), tempered(look, one - p), p / (one - p)};
}

/// Mean and covariance of the velocity, given that the cell is occupied.
template <class T>
struct EstimateOfVelocity {
  T x;  ///< m/s
  T y;
  T xx;  ///< m²/s²
  T xy;
  T yy;
};

/// Mean over the states of the occupied cell, from sums up to a factor; 0 for none.
template <class T>
STEREOGRID_HD inline EstimateOfVelocity<T> estimate_of(const LatticeSums<T>& sums) {
  const T none{number(sums.mass, 0.0f)};
  const T share{IfThenElseZero(sums.mass > none, number(sums.mass, 1.0f) / sums.mass)};
  const T x{share * sums.x};
  const T y{share * sums.y};
  return {x, y, Max(share * sums.xx - x * x, none), share * sums.xy - x * y, Max(share * sums.yy - y * y, none)};
}

/// The same in axes rotated by the angle with the given cosine and sine. Isotropic values are unchanged to the bit;
/// adding 0 turns −0 into 0.
template <class T>
STEREOGRID_HD inline EstimateOfVelocity<T> turned(const EstimateOfVelocity<T>& v, T c, T s) {
  const T none{number(c, 0.0f)};
  const T one_half{number(c, 0.5f)};
  const T cos_twice{c * c - s * s};
  const T sin_twice{number(c, 2.0f) * c * s};
  const T mean{one_half * (v.xx + v.yy)};
  const T half{one_half * (v.xx - v.yy)};
  const T along{cos_twice * half + sin_twice * v.xy};
  return {c * v.x + s * v.y + none, c * v.y - s * v.x + none, mean + along, cos_twice * v.xy - sin_twice * half + none,
          mean - along};
}

/// Between four cells, by the shares of the way along x and along y; of four alike it is what they are, to the bit.
template <class T>
STEREOGRID_HD inline T among(T low_left, T low_right, T high_left, T high_right, T x_share, T y_share) {
  const T low{low_left + x_share * (low_right - low_left)};
  const T high{high_left + x_share * (high_right - high_left)};
  return low + y_share * (high - low);
}

/// P(occupied, moving), for a cell with probability `occupancy`.
template <class T>
STEREOGRID_HD inline T moving_share(T occupancy, T standing) {
  return Max(occupancy - standing, number(occupancy, 0.0f));
}

template <class T>
STEREOGRID_HD inline auto is_moving(MovingFrom from, T occupancy, T standing) {
  const T moving{(moving_share)(occupancy, standing)};
  return And(moving > number(moving, from.mass), moving > number(moving, from.part) * occupancy);
}

/// Mass of each moving velocity of a cell without masses of its own. `each_moving`: of FilterStep.
template <class T>
STEREOGRID_HD inline T even_mass(float each_moving, T occupancy, T standing) {
  return number(occupancy, each_moving) * (moving_share)(occupancy, standing);
}

/// Velocity noise is a Markov chain over the velocities: each keeps a share of its mass and gains what depends on the
/// cell alone. `all`: mass of all velocities, `standing`: that of standstill.
template <class T>
STEREOGRID_HD inline T gained_by_moving(const FilterStep& step, T all, T standing) {
  return number(all, step.spread) * (all - standing) + number(all, step.start) * standing;
}
template <class T>
STEREOGRID_HD inline T disturbed_standing(const FilterStep& step, T all, T standing) {
  return number(all, step.kept_standing) * standing + number(all, step.stop) * (all - standing);
}

/// Greater than every age of a cell that has been seen.
constexpr float never_s{3e38f};

/// Still as `unseen_cell` says. It does not count as moving, either.
template <class T>
STEREOGRID_HD inline auto is_as_unseen(const FilterStep& step, T occupancy, T standing, T age_s) {
  const auto of = [age_s](float value) { return number(age_s, value); };
  return And(age_s > of(never_s), And(occupancy == of(0.5f), standing == of(0.5f * step.prior_static)));
}

/// Coefficients of prediction and update (docs/method.md §8.7) for the masses that arrive in a cell: m(k) ← scale·m(k)
/// + birth(k).
template <class T>
struct UpdateOfCell {
  T scale;
  T birth_static;  ///< birth(k) of standstill
  T birth_moving;  ///< for every other velocity
  T occupancy;     ///< Σ m(k) afterwards
};

/// View of a cell by the camera. docs/method.md §8.3, §8.4.
template <class T>
struct ViewOfCell {
  T repeated;  ///< similarity to the view of the step before: 0: different, 1: the same
  T decay;
  T coarseness;  ///< depth of a pixel of disparity, relative to the largest at which memory is sharp; 1 at least
  T squares;     ///< squared distance from the camera, in cells
  T partial;     ///< 1: in view, but not wholly; 0: else
};

/// By how many cells a cell lies within a view: in_angle ≥ 0: the left camera sees a part of it; wholly ≥ 0: both
/// cameras see it from the least height of obstacles on.
template <class T>
struct DepthInView {
  T in_angle;
  T wholly;
};

/// Depth of the cell that is (dx, dy) cells from the camera of `view`.
template <class T>
STEREOGRID_HD inline DepthInView<T> depth_in_view(const ViewOfStep& view, T dx, T dy) {
  const auto of = [dx](float value) { return number(dx, value); };
  const T ahead{dx * of(view.ahead_x) + dy * of(view.ahead_y)};
  const T left{dy * of(view.ahead_x) - dx * of(view.ahead_y)};
  const T within_left{ahead * of(view.left) - left};
  const T within_right{left + ahead * of(view.right)};
  return {Min(ahead, Min(within_left, within_right)),
          Min(ahead - of(view.nearest), Min(within_left - of(view.baseline), within_right))};
}

/// View of the cell in column x and row y.
template <class T>
STEREOGRID_HD inline ViewOfCell<T> view_of_cell(const FilterStep& step, T x, T y) {
  const auto of = [x](float value) { return number(x, value); };
  const T dx{x - of(step.views[0].camera_x)};
  const T dy{y - of(step.views[0].camera_y)};
  const T squares{dx * dx + dy * dy};
  DepthInView<T> depth{(depth_in_view)(step.views[0], dx, dy)};
  for (int i{1}; i <= step.other_views; ++i) {
    const ViewOfStep& view{step.views[i]};
    const DepthInView<T> other{(depth_in_view)(view, x - of(view.camera_x), y - of(view.camera_y))};
    depth = {Max(depth.in_angle, other.in_angle), Max(depth.wholly, other.wholly)};
  }
  const auto is_in_view = depth.in_angle >= of(0);
  const T coarseness{Max(squares / of(step.sharp_squares), of(1))};
  const T decay_in_view{Min(of(step.decay_in_view) * coarseness, of(0.5f))};
  return {IfThenElseZero(squares > of(step.new_view_squares), of(1) - of(step.new_view_squares) / squares),
          IfThenElse(is_in_view, decay_in_view, of(step.decay)), IfThenElse(is_in_view, coarseness, of(1)), squares,
          IfThenElseZero(And(is_in_view, depth.wholly < of(0)), of(1))};
}

/// Limits repeated evidence, since errors repeat while the view is the same. A repeated observation moves a cell to its
/// own odds at most; evidence against the present state counts in full. docs/method.md §8.3.
template <class T>
STEREOGRID_HD inline T fresh_ratio(T repeated, T predicted, const CellLikelihood<T>& likelihood) {
  const T one{number(predicted, 1.0f)};
  const T ratio{likelihood.occupied / likelihood.empty};
  const T wanted{likelihood.odds * (one - predicted) / predicted};
  const T capped{Min(Max(wanted, Min(ratio, one)), Max(ratio, one))};
  return ratio + repeated * (capped - ratio);
}

/// Share of the predicted occupancy that a coarse cell in view keeps: the odds are divided by its coarseness, but not
/// below those of the observation, nor below 1. docs/method.md §8.4.
template <class T>
STEREOGRID_HD inline T kept_where_coarse(T predicted, T coarseness, T observed_odds) {
  const T one{number(predicted, 1.0f)};
  const T half{number(predicted, 0.5f)};
  const T lowered{predicted / (predicted + coarseness * (one - predicted))};
  const T least{Max(observed_odds / (one + observed_odds), half)};
  return IfThenElse(predicted > half, Min(Max(lowered, least) / predicted, one), one);
}

/// Static mass of a never observed cell that dynamic mass displaces: static mass is not evidence there, it completes
/// the cell to ½. `arrived`: Σ m(k), of which `standing` is static. docs/method.md §8.7.
template <class T>
STEREOGRID_HD inline T displaced_standing(T arrived, T standing) {
  const T most{Max((moving_share)(arrived, standing), number(arrived, 0.5f))};
  return Min(Max(arrived - most, number(arrived, 0.0f)), standing);
}

/// `arrived`: Σ m(k) before it, of which `standing` is static; `age_s`: of the cell before the step; `view`:
/// view_of_cell. An unseen cell stays unknown even if its mass has moved into seen cells. Mass that appears on ground
/// just seen free is more likely to move than mass from unknown space, unless a pixel of disparity has a large depth
/// there. Rays that pass above a standing thing, or where the right camera does not see it, are no evidence against it.
template <class T>
STEREOGRID_HD inline UpdateOfCell<T> joint_update(const FilterStep& step, T arrived, T standing, T age_s,
                                                  const CellLikelihood<T>& likelihood, const ViewOfCell<T>& view) {
  const auto of = [arrived](float value) { return number(arrived, value); };
  const T one{of(1)};
  const auto is_never_seen = age_s > of(never_s);
  const T displaced{IfThenElseZero(is_never_seen, (displaced_standing)(arrived, standing))};
  const T stayed{arrived - displaced};
  const T total{Min(stayed, one)};
  const T lacking{IfThenElseZero(is_never_seen, Max(of(0.5f) - total, of(0)))};
  const T kept{one - view.decay};
  const T empty{one - total - lacking};
  const T remembered{kept * (total + lacking) + view.decay * empty};
  const T share{(kept_where_coarse)(remembered, view.coarseness, likelihood.odds)};
  const T predicted{share * remembered};
  const T repeated{IfThenElse(is_never_seen, one, view.repeated)};
  const auto is_repeated = And(repeated > of(0), predicted > of(0));
  const auto is_overlooked = And(view.partial > of(0), And(predicted > of(0.5f), standing > of(0.5f) * arrived));
  const auto is_kept = And(is_overlooked, likelihood.odds < one);
  const T ratio{IfThenElse(is_repeated, fresh_ratio(repeated, predicted, likelihood), likelihood.occupied)};
  const T occupied{IfThenElse(is_kept, one, ratio)};
  const T free{IfThenElse(Or(is_repeated, is_kept), one, likelihood.empty)};
  const T gain{share * occupied / (occupied * predicted + free * (one - predicted))};
  const T unseen{gain * kept * lacking};
  const T changed{gain * Min(view.decay, of(step.decay_in_view)) * empty};
  const T misplaced{gain * view.decay * empty - changed};  // by the growth with depth
  const auto was_seen = And(age_s <= of(0), view.squares <= of(step.appearing_squares));
  const T birth_static{IfThenElse(was_seen, of(step.appearing_static), of(step.prior_static))};
  const T birth_moving{IfThenElse(was_seen, of(step.appearing_moving), of(step.prior_moving))};
  const T scale{gain * kept * IfThenElse(stayed > one, one / stayed, one)};
  return {scale, (unseen + misplaced) * of(step.prior_static) + changed * birth_static - scale * displaced,
          (unseen + misplaced) * of(step.prior_moving) + changed * birth_moving, gain * remembered};
}

/// The same for the sums over a cell's masses. New mass has mean velocity 0.
template <class T>
STEREOGRID_HD inline LatticeSums<T> updated(const FilterStep& step, const UpdateOfCell<T>& update,
                                            const LatticeSums<T>& arrived) {
  const T spread{update.birth_moving * number(arrived.mass, step.lattice_squares)};
  return {update.occupancy,          update.scale * arrived.x,
          update.scale * arrived.y,  update.scale * arrived.xx + spread,
          update.scale * arrived.xy, update.scale * arrived.yy + spread};
}

/// Arriving mass of each moving velocity, if they are equal. `spread`: sum over all velocities of their contributions;
/// `here`: the contribution of standstill.
template <class T>
STEREOGRID_HD inline T even_arrived(T each_moving, T spread, T here) {
  return each_moving * Max(spread - here, number(spread, 0.0f));
}

/// State of a cell after a step.
template <class T>
struct CellAfter {
  T occupancy;
  T standing;
  LatticeSums<T> sums;
};

/// State of an unseen cell in a block without masses: arriving mass is dropped.
template <class T>
STEREOGRID_HD inline CellAfter<T> unseen_cell(const FilterStep& step, T like) {
  const T none{number(like, 0.0f)};
  const T occupancy{number(like, 0.5f)};
  const T squares{number(like, 0.5f * step.prior_moving * step.lattice_squares)};
  return {occupancy, number(like, 0.5f * step.prior_static), {occupancy, none, none, squares, none, squares}};
}

template <class Condition, class T>
STEREOGRID_HD inline CellAfter<T> either(Condition chosen, const CellAfter<T>& yes, const CellAfter<T>& no) {
  return {IfThenElse(chosen, yes.occupancy, no.occupancy),
          IfThenElse(chosen, yes.standing, no.standing),
          {IfThenElse(chosen, yes.sums.mass, no.sums.mass), IfThenElse(chosen, yes.sums.x, no.sums.x),
           IfThenElse(chosen, yes.sums.y, no.sums.y), IfThenElse(chosen, yes.sums.xx, no.sums.xx),
           IfThenElse(chosen, yes.sums.xy, no.sums.xy), IfThenElse(chosen, yes.sums.yy, no.sums.yy)}};
}

/// State of a cell without masses of its own; `each`: arriving mass of each moving velocity; `is_unseen`: unseen
/// before, and not observed now.
template <class Condition, class T>
STEREOGRID_HD inline CellAfter<T> updated_evenly(const FilterStep& step, T standing, T each, T age_s,
                                                 Condition is_unseen, const CellLikelihood<T>& likelihood,
                                                 const ViewOfCell<T>& view) {
  const T total{standing + number(each, step.moving_velocities) * each};
  const UpdateOfCell<T> update{(joint_update)(step, total, standing, age_s, likelihood, view)};
  const T squares{(update.scale * each + update.birth_moving) * number(each, step.lattice_squares)};
  const T none{number(each, 0.0f)};
  const CellAfter<T> seen{update.occupancy,
                          update.scale * standing + update.birth_static,
                          {update.occupancy, none, none, squares, none, squares}};
  return (either)(is_unseen, (unseen_cell)(step, each), seen);
}
