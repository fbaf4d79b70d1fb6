// SPDX-License-Identifier: Apache-2.0
#include "ground/ground_estimator.hpp"

#include <algorithm>
#include <cmath>

#include "images/patch.hpp"

namespace stereogrid {
namespace {

// Evidence that determines a plane in one frame, and in three that agree; nats. Source: real pairs with ground have 61
// and more, images without ground up to 50.
constexpr double sound_nats{55};
constexpr double candidate_nats{12};
constexpr double clear_nats{6};  // margin between planes: 400 to 1
// Uncertainty of a plane that one frame determines.
constexpr double height_sigma_max{0.08};  // share of the height
constexpr double pitch_sigma_max{radians(1.5)};
// Shape of its support: share of the nearest half on it, samples below it, range of distances.
constexpr double near_share_min{0.15};
constexpr double below_share_max{0.3};
constexpr double depth_ratio_min{1.35};
// A tracked plane is not measured with less of the nearest half on it, or more below it, or without evidence.
constexpr double tracked_share_min{0.3};
constexpr double tracked_below_max{0.5};
constexpr double tracked_nats{6};
// The nearest ground alone measures it, too: beyond an edge all samples lie below the plane.
constexpr double ring_share_min{0.6};
constexpr double ring_samples_min{3};
constexpr double samples_below_min{3};  // 2 to 3 nats each
// Maximum time without a measurement of the ground. Vans and bends hide it for shorter.
constexpr double coasting_max_s{3};
// Largest deviation of a frame's plane from the extrinsics: load, suspension and errors of a measured extrinsics.
constexpr double height_gate{0.1};  // share of the height
constexpr double pitch_gate_deg{2.5};
constexpr int tracking_rounds{8};
// The fit needs the prior for what the samples do not determine; the filter's step weighs it.
constexpr double tether{0.2};
constexpr float jolt_px{1.3F};  // error of the expected disparities where a wheel drops off a kerb: 2° within a frame

// True: the plane has the shape of ground. A wall has one distance only, and the foot of a wall little before it.
bool has_shape_of_ground(const FittedPlane& plane) {
  const PlaneSupport& support{plane.support};
  return plane.is_measured && plane.ground.height_sigma_m <= height_sigma_max * plane.ground.height_m &&
         plane.ground.pitch_sigma_rad <= pitch_sigma_max && support.near_share() >= near_share_min &&
         support.below <= below_share_max * support.on && support.depth_ratio >= depth_ratio_min;
}

bool is_sound(const FittedPlane& plane) {
  return plane.total >= sound_nats && has_shape_of_ground(plane);
}

// Standard deviations of disparities on ground. Stereo networks and depth cameras follow surfaces; at low resolution
// all ground may be within 3 px of a wall.
constexpr float own_noise_px{0.5F};
constexpr float external_noise_px{0.2F};

std::size_t samples_max(const Rig& level_rig) {
  const MatchLattice lattice{level_rig.width_px, level_rig.height_px};
  return static_cast<std::size_t>(lattice.across) * static_cast<std::size_t>(lattice.down);
}

// A plane behind the camera: every pixel is matched as upright.
Ground out_of_view(const Ground& extrinsics) {
  Ground ground{extrinsics};
  ground.pitch_rad = -1.5;
  return ground;
}

}  // namespace

GroundWorkspace::GroundWorkspace(const Rig& level_rig) : blocks(blocks_of(level_rig)) {
  const std::size_t most{samples_max(level_rig)};
  samples.reserve(most);
  search.reserve(most);
}

GroundEstimator::GroundEstimator(const Rig& level_rig, const Config& config, double turned_rad)
    : rig_{level_rig},
      config_{config.ground},
      disparities_{config.matching.disparities},
      step_m_{config.vehicle.step_max_m},
      turned_rad_{turned_rad} {}

Ground GroundEstimator::expected(const GroundState& state, double dt_s) const {
  if (!config_.estimate) return state.extrinsics;
  if (state.mode == GroundMode::assumed) return out_of_view(state.extrinsics);
  const Ground& centre{state.extrinsics};
  const Matrix3 around{covariance_of(centre) + suspension(centre)};
  if (!state.plane.estimated) return with_covariance(centre, around);
  const double memory{std::exp(-dt_s / correlated_s)};
  const Vector3 away{difference(state.plane, centre)};
  const Ground ground{centre.height_m + memory * away[0], centre.pitch_rad + memory * away[1],
                      centre.roll_rad + memory * away[2]};
  const double kept{memory * memory};
  return rounded(with_covariance(ground, scaled(kept, covariance_of(state.plane)) + scaled(1 - kept, around)));
}

void GroundEstimator::gather(const MatchedFrame& frame, int own_from_row, GroundWorkspace& space) const {
  PlaneSamples& samples{space.samples};
  collect(frame, own_from_row, samples);
  weigh(rig_, MatchLattice::step_u, space.blocks, samples);
  int last_row{std::min(rig_.height_px, own_from_row)};
  if (!frame.masked.empty()) {  // the vehicle's own bonnet is not the nearest ground
    const auto is_masked = [&](int v) {
      return std::count(frame.masked.row(v), frame.masked.row(v) + frame.masked.width, 0) * 4 < frame.masked.width;
    };
    while (last_row > 1 && is_masked(last_row - 1)) --last_row;
  }
  samples.first_x = static_cast<float>(-rig_.cx_px);
  samples.last_x = static_cast<float>(rig_.width_px - rig_.cx_px);
  samples.last_y = static_cast<float>(last_row - rig_.cy_px);
  samples.disparities = static_cast<float>(disparities_);
  samples.noise_px = frame.is_external() ? external_noise_px : own_noise_px;
}

// Disparities of either hypothesis at the pixels of MatchLattice.
void GroundEstimator::collect(const MatchedFrame& frame, int own_from_row, PlaneSamples& samples) const {
  constexpr float correlated_blocks{3};  // the rows of a window are alike for longer than its columns
  constexpr float upright_share{0.03F};  // upright windows on ground are biased towards obstacles
  const float side{static_cast<float>(block_px(rig_))};
  const float road_weight{MatchLattice::step_u * MatchLattice::step_v / (correlated_blocks * side * side)};
  const float upright_weight{upright_share * road_weight};
  const MatchLattice lattice{rig_.width_px, rig_.height_px};
  samples.resize(samples_max(rig_));
  std::size_t count{0};
  for (int j{0}; j < lattice.down; ++j) {
    const int v{MatchLattice::first_v + j * MatchLattice::step_v};
    if (v >= own_from_row) break;
    const float y{static_cast<float>(v - rig_.cy_px)};
    const float* const upright{frame.matches.obstacle.row(v)};
    const float* const road{frame.matches.road.row(v)};
    const std::uint8_t* const masked{frame.masked.empty() ? nullptr : frame.masked.row(v)};
    for (int i{0}; i < lattice.across; ++i) {
      const int u{MatchLattice::first_u + i * MatchLattice::step_u};
      const float disparity{std::max(upright[u], road[u])};
      if (!(disparity > 0) || (masked != nullptr && masked[u] != 0)) continue;
      samples.x[count] = static_cast<float>(u - rig_.cx_px);
      samples.y[count] = y;
      samples.disparity[count] = disparity;
      samples.fit_weight[count] = road[u] > 0 ? road_weight : upright_weight;
      ++count;
    }
  }
  samples.resize(count);
}

GroundFit GroundEstimator::fit(const GroundState& state, double dt_s, GroundWorkspace& space) const {
  GroundFit fit{};
  fit.plane = state.extrinsics;
  if (!config_.estimate) return fit;
  if (state.mode == GroundMode::assumed) return searched(space);
  const Ground before{expected(state, dt_s)};
  fit = tracked(state, before, space.samples);
  const bool is_confirmed{state.mode == GroundMode::given || state.agreeing >= agreeing_min};
  const bool is_certain{fit.plane.estimated && fit.support.below <= below_share_max * fit.support.on};
  if (!is_confirmed || !is_certain) compare(state, space, fit);
  fit.wants_rematch = is_far_from(before, fit.slope.value_or(fit.plane), space.samples);
  return fit;
}

GroundFit GroundEstimator::refit(const GroundState& state, const GroundFit& before, GroundWorkspace& space) const {
  if (before.slope) return before;
  Ground start{before.plane};
  if (state.mode != GroundMode::assumed) {
    start = with_covariance(start, covariance_of(state.extrinsics) + suspension(state.extrinsics));
  }
  GroundFit fit{before};
  const GroundFit again{tracked(state, start, space.samples)};
  fit.wants_rematch = false;
  if (before.plane.estimated && !again.plane.estimated) return fit;
  fit.plane = again.plane;
  fit.support = again.support;
  return fit;
}

// The Kalman filter's step from `expected`. Empty: the samples do not measure its plane.
std::optional<Ground> GroundEstimator::measured(const Ground& expected, const PlaneSamples& samples,
                                                PlaneSupport& support) const {
  const RoadPlane start{road_plane(rig_, expected)};
  PlanePrior prior{prior_of(expected)};
  prior.precision = scaled(tether, prior.precision);
  const std::optional<RefinedPlane> refined{
      refined_plane(rig_, samples, prior, {start, jolt_px}, tracking_rounds, samples.fit_weight)};
  if (!refined) return std::nullopt;
  const FittedPlane fitted{fitted_plane(rig_, samples, prior, *refined, samples.fit_weight)};
  support = fitted.support;
  const bool is_seen{fitted.total >= tracked_nats && support.near_share() >= tracked_share_min &&
                     support.below < tracked_below_max * support.on};
  const bool is_nearest_seen{support.ring_on >= ring_samples_min &&
                             support.ring_on >= ring_share_min * support.ring_all};
  if (!fitted.is_measured || (!is_seen && !is_nearest_seen)) return std::nullopt;
  const Matrix3& noise{fitted.measurement.covariance};
  const Matrix3 covariance{carried(numbers_by_ground(rig_, expected), covariance_of(expected))};
  const Matrix3 gain{covariance * inverse(covariance + noise)};
  RoadPlane plane{start};
  move(plane, gain * (fitted.measurement.numbers - numbers_of(start)));
  if (!(plane.per_v > 0)) return std::nullopt;
  const Ground found{rounded(ground_of(rig_, plane))};
  const Matrix3 rest{diagonal({{1, 1, 1}}) + scaled(-1, gain)};
  const Matrix3 after{carried(rest, covariance) + carried(gain, noise)};  // Joseph's form keeps it positive
  return rounded(with_covariance(found, carried(inverse(numbers_by_ground(rig_, found)), after)));
}

// The plane through the samples around the expected one, or the extrinsics.
GroundFit GroundEstimator::tracked(const GroundState& state, const Ground& expected,
                                   const PlaneSamples& samples) const {
  GroundFit fit;
  const std::optional<Ground> plane{measured(expected, samples, fit.support)};
  if (plane && is_within_gates(state.extrinsics, *plane)) {
    fit.plane = *plane;
    return fit;
  }
  fit.plane = with_covariance(state.extrinsics, covariance_of(state.extrinsics) + suspension(state.extrinsics));
  fit.support = support_of({road_plane(rig_, state.extrinsics), rig_, samples}, samples);
  return fit;
}

// The plane with most evidence, unless another sound one explains the nearest ground better.
std::size_t GroundEstimator::best_of(const PlaneSamples& samples, const std::vector<FittedPlane>& planes) const {
  std::size_t best{0};
  for (std::size_t i{1}; i < planes.size(); ++i) {
    const PlaneHypothesis& p{planes[best].hypothesis};
    const PlaneHypothesis& q{planes[i].hypothesis};
    if (!is_sound(planes[i]) || !are_in_conflict(p, q, samples)) continue;
    if (!is_sound(planes[best]) || ring_margin(q, p, samples) > clear_nats) best = i;
  }
  return best;
}

bool GroundEstimator::has_margin(const PlaneSamples& samples, const std::vector<FittedPlane>& planes,
                                 std::size_t best) const {
  for (std::size_t i{0}; i < planes.size(); ++i) {
    if (i == best || !are_in_conflict(planes[best].hypothesis, planes[i].hypothesis, samples)) continue;
    const bool is_clear{planes[best].total - planes[i].total >= clear_nats ||
                        ring_margin(planes[best].hypothesis, planes[i].hypothesis, samples) >= clear_nats};
    if (!is_clear) return false;
  }
  return true;
}

GroundFit GroundEstimator::searched(GroundWorkspace& space) const {
  GroundFit fit;
  search_planes(rig_, space.samples, {turned_rad_}, space.search);
  const std::vector<FittedPlane>& planes{space.search.found};
  double total{0};
  if (!planes.empty()) {
    const std::size_t best{best_of(space.samples, planes)};
    const bool is_clear{has_shape_of_ground(planes[best]) && has_margin(space.samples, planes, best)};
    total = is_clear ? planes[best].total : 0;
    fit.plane = rounded(planes[best].ground);
    fit.support = planes[best].support;
  }
  fit.rolled = rolled(total, space);
  fit.is_sound = !fit.rolled && total >= sound_nats;
  fit.is_candidate = !fit.rolled && total >= candidate_nats;
  return fit;
}

// Sound plane of a camera that is tilted, sideways or upside down. Each of them needs three times the evidence of those
// before: walls beside an upright camera have up to 2.1 times that of its ground, the ground of a rolled camera has 4.3
// times that of walls, or more.
std::optional<Ground> GroundEstimator::rolled(double upright_nats, GroundWorkspace& space) const {
  constexpr double clearly{3};
  std::optional<Ground> ground;
  double most_nats{std::max(clearly * upright_nats, sound_nats)};
  const auto add = [&](int quarters) {
    search_rolled_planes(rig_, space.samples, turned_rad_, quarters, space.search);
    for (const FittedPlane& plane : space.search.found) {
      const bool is_upright{std::abs(plane.ground.roll_rad) < SearchBounds{}.roll_max_rad};
      if (is_upright || !is_sound(plane) || plane.total <= most_nats) continue;
      most_nats = plane.total;
      ground = rounded(plane.ground);
    }
  };
  add(0);
  if (ground) most_nats *= clearly;
  for (const int quarters : {1, 2, 3}) add(quarters);
  return ground;
}

// Compares the plane in use with those of a search.
void GroundEstimator::compare(const GroundState& state, GroundWorkspace& space, GroundFit& fit) const {
  const PlaneSamples& samples{space.samples};
  const bool is_measured{fit.plane.estimated};
  const bool is_below{fit.support.below >= tracked_below_max * fit.support.on};
  const bool was_seen{state.agreeing > 0};
  fit.is_contradicted = !is_measured && !was_seen && is_below && fit.support.below >= samples_below_min;
  search_planes(rig_, samples, {turned_rad_}, space.search);
  const std::vector<FittedPlane>& planes{space.search.found};
  if (planes.empty()) return;
  const FittedPlane& other{planes[best_of(samples, planes)]};
  const PlaneHypothesis used{road_plane(rig_, fit.plane), rig_, samples};
  const bool is_nearest{ring_margin(other.hypothesis, used, samples) > clear_nats};
  const double margin{other.support.evidence - fit.support.evidence};
  if (!has_shape_of_ground(other) || !(is_nearest || (margin >= clear_nats && !is_measured))) return;
  if (!are_in_conflict(used, other.hypothesis, samples) && margin < sound_nats) return;
  if (!is_measured && !was_seen && other.total >= candidate_nats) fit.is_contradicted = true;
  if (!is_sound(other)) return;
  Ground seen{rounded(other.ground)};
  if (is_within_gates(state.extrinsics, seen)) {  // the fit had ended elsewhere
    seen.estimated = true;
    fit.plane = seen;
    fit.support = other.support;
    fit.is_contradicted = false;
    return;
  }
  // Planes may cross at the image's lower border.
  if (is_nearest && is_below) fit.plane.estimated = false;
  if (is_slope_ahead(state.extrinsics, seen)) {
    if (!fit.plane.estimated) fit.slope = seen;
    fit.is_contradicted = false;
  } else {
    fit.disagreeing = seen;
    if (!fit.plane.estimated && is_below) fit.is_contradicted = true;
  }
  if (state.mode != GroundMode::found || !is_nearest) return;
  fit.replacement = seen;
  fit.replaces_at_once = state.agreeing < agreeing_min;
}

bool GroundEstimator::is_within_gates(const Ground& extrinsics, const Ground& plane) const {
  return std::abs(plane.height_m - extrinsics.height_m) <=
             std::min(config_.height_gate_m, height_gate * extrinsics.height_m) &&
         std::abs(plane.pitch_rad - extrinsics.pitch_rad) <=
             radians(std::min(config_.pitch_gate_deg, pitch_gate_deg)) &&
         std::abs(plane.roll_rad - extrinsics.roll_rad) <= radians(config_.roll_gate_deg);
}

// True: ground without a jump leads to the nearest visible ground of the plane `seen`. Its slope begins before it, or
// the ground turns into it there, as steeply to the other side and with a step at most: a crest or a dip.
bool GroundEstimator::is_slope_ahead(const Ground& extrinsics, const Ground& seen) const {
  constexpr double steepest{radians(20)};
  const double turn{seen.pitch_rad - extrinsics.pitch_rad};
  const double slope{std::tan(std::abs(turn))};
  const double nearest_m{rig_.focal_px * rig_.baseline_m /
                         road_plane(rig_, seen).disparity(rig_.cx_px, rig_.height_px)};
  // rise of the plane at the nearest visible ground, in the direction of its slope
  const double below_m{seen.height_m / std::cos(turn) - extrinsics.height_m};
  const double rise_m{slope * nearest_m - std::copysign(below_m, turn * below_m)};
  // a turned camera sees the road meet its plane at height·tan(turn/2) ahead
  return std::abs(turn) <= steepest && rise_m >= -(slope * nearest_m + step_m_) &&
         rise_m <= slope * (nearest_m - extrinsics.height_m / 4);
}

// True: part of the nearest half is outside the range of the road hypothesis on `before`.
bool GroundEstimator::is_far_from(const Ground& before, const Ground& plane, const PlaneSamples& samples) const {
  constexpr float range_px{3};
  const PlaneHypothesis p{road_plane(rig_, before), rig_, samples};
  const PlaneHypothesis q{road_plane(rig_, plane), rig_, samples};
  const auto differ = [&](float x, float y) {
    const float most{samples.disparities};
    return std::abs(std::min(p.expected(x, y), most) - std::min(q.expected(x, y), most)) > range_px;
  };
  return differ(samples.first_x / 2, samples.last_y) || differ(samples.last_x / 2, samples.last_y) ||
         differ(0, samples.last_y - q.near_px / 2 / q.per_v);
}

Rejection::Reason GroundEstimator::reason_to_reject(const GroundState& state, const GroundFit& fit, double dt_s) const {
  if (!config_.estimate) return Rejection::none;
  if (state.mode == GroundMode::assumed) return fit.rolled ? Rejection::camera_rolled : Rejection::ground_not_found;
  if (fit.plane.estimated) return Rejection::none;
  if (fit.is_contradicted) return Rejection::plane_contradicted;
  return state.unmeasured_s + dt_s > coasting_max_s ? Rejection::road_not_seen : Rejection::none;
}

}  // namespace stereogrid
