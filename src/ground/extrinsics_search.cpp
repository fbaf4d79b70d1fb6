// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "ground/extrinsics_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "clamped_to_int.hpp"
#include "ground/fit.hpp"

namespace stereogrid {
namespace {

constexpr int rounds{2000};  // for a wide range, and a road in a small part of the view
constexpr double expected_min_px{1.5};
constexpr int columns{8};
constexpr int frames_to_confirm{3};
constexpr int columns_to_confirm{6};
constexpr double lost_max_s{1};

// Calibration with gates around all plausible extrinsics.
struct AnyExtrinsics {
  Rig rig;
  GroundConfig gates;
};
AnyExtrinsics any_extrinsics(const Rig& rig, double turned_rad) {
  AnyExtrinsics any{rig, {}};
  any.rig.camera_height_m = 2.1;
  any.gates.height_gate_m = 1.9;
  any.rig.camera_pitch_rad = radians(12.5) - turned_rad;
  any.gates.pitch_gate_deg = 22.5;
  any.rig.camera_roll_rad = 0;
  any.gates.roll_gate_deg = 10;
  return any;
}

// Covariance of the plane's numbers, wide enough for the samples alone to decide.
Matrix3 wide_covariance(const Rig& rig, const Ground& ground) {
  const double height{ground.height_m / 2};
  const double angle{radians(10)};
  return carried(numbers_by_ground(rig, ground), diagonal({{height * height, angle * angle, angle * angle}}));
}

// `samples`: in the order of their rows.
std::span<const GroundSample> from_row(std::span<const GroundSample> samples, double row) {
  const auto first{std::ranges::partition_point(samples, [row](const GroundSample& s) { return s.v < row; })};
  return samples.subspan(static_cast<std::size_t>(first - samples.begin()));
}

bool are_alike(const Ground& a, const Ground& b) {
  return std::abs(a.height_m - b.height_m) <= 0.1 * b.height_m + 0.02 &&
         std::abs(a.pitch_rad - b.pitch_rad) <= radians(1.5) && std::abs(a.roll_rad - b.roll_rad) <= radians(2);
}

Ground mean_of(const Ground& sum, int count) {
  return {sum.height_m / count, sum.pitch_rad / count, sum.roll_rad / count};
}

// True: nearly all samples on `used` in the nearest ground, up to twice its least distance in view, lie on `candidate`,
// too.
bool explains_nearest(const Rig& rig, const std::vector<GroundSample>& samples, const RoadPlane& used,
                      const RoadPlane& candidate) {
  const double nearest_px{candidate.disparity(rig.cx_px, rig.height_px)};
  int by_used_alone{0};
  int by_candidate{0};
  for (const GroundSample& sample : samples) {
    if (2 * candidate.disparity(sample.u, sample.v) < nearest_px) continue;
    const bool is_on_candidate{std::abs(residual(candidate, sample)) < 1};
    by_candidate += is_on_candidate ? 1 : 0;
    by_used_alone += !is_on_candidate && std::abs(residual(used, sample)) < 1 ? 1 : 0;
  }
  return 10 * by_used_alone <= by_candidate && 2 * by_candidate >= ground_samples_min;
}

// True: the plane `seen` meets that of the extrinsics between the vehicle and the nearest visible ground.
bool is_slope_ahead(const Rig& rig, const Ground& seen) {
  constexpr double steepest{radians(20)};
  constexpr double bend{1.25};  // a slope begins gently
  const double turn{seen.pitch_rad - rig.camera_pitch_rad};
  const double nearest_px{road_plane(rig, seen).disparity(rig.cx_px, rig.height_px)};
  // a turned camera sees the road meet its plane at height·tan(turn/2) ahead
  const double begin_m{(seen.height_m - rig.camera_height_m * std::cos(turn)) / std::sin(turn)};
  return std::abs(turn) <= steepest && 4 * begin_m >= rig.camera_height_m &&
         begin_m * nearest_px <= bend * rig.focal_px * rig.baseline_m;
}

}  // namespace

bool RoadSupport::is_road() const {
  return near >= ground_samples_min && near >= 0.2 * all && below <= 0.2 * all && 3 * below <= near &&
         depth_ratio >= 1.4 && columns >= 4;
}

bool RoadSupport::is_certain() const {
  return is_road() && near >= 0.6 * all && below <= 0.05 * all && depth_ratio >= 2 && columns >= 7 &&
         nearest >= ground_samples_min / 2 && nearest >= 0.8 * nearest_all;
}

RoadSupport support_of(const Rig& rig, const std::vector<GroundSample>& samples, const RoadPlane& plane) {
  constexpr double nearest_share{0.6};  // relative to the largest expected disparity of a sample
  constexpr double below_share{0.1};    // relative to the expected disparity: roads are not flat
  constexpr int bins{1024};
  const double largest_px{
      std::max({plane.disparity(0, rig.height_px), plane.disparity(rig.width_px, rig.height_px), 1.0})};
  double nearest_px{0};
  for (const GroundSample& sample : samples) nearest_px = std::max(nearest_px, plane.disparity(sample.u, sample.v));
  std::array<int, bins> by_disparity{};
  std::array<int, columns> by_column{};
  RoadSupport support;
  for (const GroundSample& sample : samples) {
    const double expected_px{plane.disparity(sample.u, sample.v)};
    if (expected_px < expected_min_px) continue;
    const double r{sample.disparity - expected_px};
    ++support.all;
    support.below += r < -1 - below_share * expected_px ? 1 : 0;
    const bool is_nearest{expected_px >= nearest_share * nearest_px};
    support.nearest_all += is_nearest ? 1 : 0;
    if (std::abs(r) >= 1) continue;
    ++support.near;
    support.nearest += is_nearest ? 1 : 0;
    ++by_disparity[static_cast<std::size_t>(std::clamp(clamped_to_int(expected_px / largest_px * bins), 0, bins - 1))];
    ++by_column[static_cast<std::size_t>(
        std::clamp(static_cast<int>(sample.u) * columns / rig.width_px, 0, columns - 1))];
  }
  const auto percentile = [&](double share) {
    int below{0};
    std::size_t bin{0};
    while (bin + 1 < by_disparity.size() && (below += by_disparity[bin]) < share * support.near) ++bin;
    return static_cast<double>(bin) + 0.5;
  };
  if (support.near > 0) support.depth_ratio = percentile(0.9) / percentile(0.1);
  for (const int count : by_column) support.columns += 100 * count >= 3 * support.near && count > 0 ? 1 : 0;
  return support;
}

std::optional<Ground> refine_extrinsics(const Rig& rig, double turned_rad, const std::vector<GroundSample>& samples,
                                        const Ground& start) {
  const AnyExtrinsics any{any_extrinsics(rig, turned_rad)};
  RoadPlane plane{road_plane(rig, start)};
  const Matrix3 covariance{wide_covariance(rig, start)};
  for (int round{0}; round < 2; ++round) {  // first_ground_row depends on the plane
    if (refine(from_row(samples, first_ground_row(rig, plane)), covariance, plane) == 0) return std::nullopt;
  }
  const Ground found{ground_of(rig, plane)};
  if (!is_within_gates(any.rig, any.gates, found) || !support_of(rig, samples, plane).is_road()) return std::nullopt;
  return found;
}

std::optional<Ground> search_extrinsics(const Rig& rig, double turned_rad, const std::vector<GroundSample>& samples) {
  if (static_cast<int>(samples.size()) < ground_samples_min) return std::nullopt;
  const AnyExtrinsics any{any_extrinsics(rig, turned_rad)};
  // 1 px is too wide for planes whose disparity grows slowly from row to row; fast ones are matched poorly by upright
  // windows and need it.
  for (const double inlier_px : {0.5, 1.0}) {
    RoadPlane plane{0, 0, 0, rig.cx_px, rig.cy_px};
    if (!find_plane(any.rig, any.gates, samples, plane, {rounds, inlier_px})) continue;
    const std::optional<Ground> found{refine_extrinsics(rig, turned_rad, samples, ground_of(rig, plane))};
    if (found) return found;
  }
  return std::nullopt;
}

Ground seen_from(const Ground& ground, double angle_rad) {
  // the unit vector to the ground in the camera frame, turned about its x axis
  const double x{std::cos(ground.pitch_rad) * std::sin(ground.roll_rad)};
  const double y{std::cos(ground.pitch_rad) * std::cos(ground.roll_rad)};
  const double z{std::sin(ground.pitch_rad)};
  const double turned_y{y * std::cos(angle_rad) - z * std::sin(angle_rad)};
  const double turned_z{y * std::sin(angle_rad) + z * std::cos(angle_rad)};
  Ground seen{ground};
  seen.pitch_rad = std::asin(turned_z);
  seen.roll_rad = std::atan2(x, turned_y);
  return seen;
}

ExtrinsicsSearch::ExtrinsicsSearch(const Rig& level_rig, const GroundConfig& config, double turned_rad, bool is_given)
    : rig_{level_rig}, config_{config}, turned_rad_{turned_rad}, is_given_{is_given} {}

bool ExtrinsicsSearch::is_established() const {
  return fitting_ >= frames_to_confirm;
}

bool ExtrinsicsSearch::is_wanted(bool is_lost, double dt_s) {
  if (!config_.estimate) return false;
  lost_s_ = is_lost ? lost_s_ + dt_s : 0;
  is_better_ = is_better_ && is_lost;
  return !is_established() || (is_given_ ? is_lost : lost_s_ >= lost_max_s);
}

std::optional<Ground> ExtrinsicsSearch::look(const std::vector<GroundSample>& samples, const Ground& used,
                                             bool is_rejected) {
  const std::optional<Ground> candidate{search_extrinsics(rig_, turned_rad_, samples)};
  const bool is_outside{candidate && !is_within_gates(rig_, config_, *candidate)};
  if (is_rejected) return is_given_ && !is_outside ? std::nullopt : candidate;
  if (is_outside) {
    const RoadSupport here{support_of(rig_, samples, road_plane(rig_, used))};
    const RoadSupport there{support_of(rig_, samples, road_plane(rig_, *candidate))};
    const bool is_confirmed{is_given_ && here.is_road()};  // a slope or stairs ahead may have more samples
    if (!is_confirmed && 4 * there.near > 5 * here.near) return candidate;
  }
  // the frame's ground plane is the one in use
  if (!candidate) return std::nullopt;
  ++fitting_;
  agreeing_ = 0;
  return std::nullopt;
}

std::optional<Ground> ExtrinsicsSearch::find_slope(const std::vector<GroundSample>& samples, Point2 place) {
  constexpr double length_of_height{10};
  if (!is_given_) return std::nullopt;
  if (!is_on_slope_) slope_from_ = place;
  is_on_slope_ = true;
  const double travelled_m{std::hypot(place.x - slope_from_.x, place.y - slope_from_.y)};
  if (travelled_m > length_of_height * rig_.camera_height_m) return std::nullopt;
  const std::optional<Ground> seen{search_extrinsics(rig_, turned_rad_, samples)};
  return seen && is_slope_ahead(rig_, *seen) ? seen : std::nullopt;
}

bool ExtrinsicsSearch::may_replace(const std::vector<GroundSample>& samples, const Ground& used,
                                   const Ground& candidate, Point2 place) {
  constexpr double travel_of_height{4};  // distance over which the plane must hold, in heights of the camera
  if (is_given_) return false;
  if (!is_established()) return true;
  const bool explains_all{explains_nearest(rig_, samples, road_plane(rig_, used), road_plane(rig_, candidate))};
  if (!explains_all || !is_better_ || !are_alike(candidate, better_)) {
    is_better_ = explains_all;
    better_ = candidate;
    better_from_ = place;
    return false;
  }
  const double travelled_m{std::hypot(place.x - better_from_.x, place.y - better_from_.y)};
  return travelled_m >= travel_of_height * candidate.height_m;
}

bool ExtrinsicsSearch::verify(const std::vector<GroundSample>& samples, const Ground& candidate) {
  const std::optional<Ground> seen{refine_extrinsics(rig_, turned_rad_, samples, candidate)};
  // a narrower plane leaves the roll, and with it the height, undetermined
  if (!seen) return false;
  const RoadSupport support{support_of(rig_, samples, road_plane(rig_, *seen))};
  if (support.columns < columns_to_confirm) return false;
  is_certain_ = agreeing_ == 0 && fitting_ == 0 && support.is_certain();
  if (agreeing_ == 0 || !are_alike(*seen, mean_of(sum_, agreeing_))) {
    agreeing_ = 0;
    sum_ = {0, 0, 0};
  }
  sum_.height_m += seen->height_m;
  sum_.pitch_rad += seen->pitch_rad;
  sum_.roll_rad += seen->roll_rad;
  ++agreeing_;
  return true;
}

void ExtrinsicsSearch::begin_again() {
  agreeing_ = 0;
  is_certain_ = false;
  lost_s_ = 0;
  is_better_ = false;
  is_on_slope_ = false;
}

std::optional<Ground> ExtrinsicsSearch::found() const {
  if (agreeing_ < frames_to_confirm && !is_certain_) return std::nullopt;
  return mean_of(sum_, agreeing_);
}

}  // namespace stereogrid
