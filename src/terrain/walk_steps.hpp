// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "terrain/settle.hpp"
#include "terrain/walk.hpp"

namespace stereogrid {

/// The steps of one sector's walk.
class Walk {
 public:
  /// Longest gap behind which ground at the expected elevation is the same surface, relative to the range.
  static constexpr float reconnect_share{0.3f};
  static constexpr float slope_memory_m{0.8f};
  static constexpr float far_px{14};            ///< wrong matches look like edges more often at smaller disparities
  static constexpr float lone_obstacle_px{10};  ///< the same for obstacles in two sectors
  // Chosen on slopes of 15° to 25° and random layouts, seeds 401 to 440.
  static constexpr float steep_sigmas{0.5f};    ///< by which a rise exceeds steps and slopes: a ring has several rows
  static constexpr int steep_confirmations{3};  ///< number of the four neighbours that must confirm that

  STEREOGRID_HD Walk(const WalkInput& input, int sector, View<PolarCell> cells, SectorWalk& walk)
      : in_{input},
        sector_{sector},
        rows_{input.rows[sector]},
        all_cells_{cells},
        cells_{cells.row(sector)},
        walk_{walk},
        state_{walk.state},
        view_{input, rows_, 0} {}
  Walk(const Walk&) = delete;
  Walk& operator=(const Walk&) = delete;
  STEREOGRID_HD ~Walk() { walk_.state = state_; }

  [[nodiscard]] STEREOGRID_HD bool is_alive() const { return state_.is_alive; }
  STEREOGRID_HD void enter(int ring) {
    ring_ = ring;
    view_ = RingView{in_, rows_, ring};
  }
  STEREOGRID_HD void step();
  STEREOGRID_HD void step_lost();
  STEREOGRID_HD bool take_over(View<const SectorWalk> walks);

 private:
  STEREOGRID_HD void meet_gap(int row, float z);
  [[nodiscard]] STEREOGRID_HD std::array<SectorRows, 3> rows_around() const {
    const int last{in_.sectors - 1};
    return {in_.rows[std::max(sector_ - 1, 0)], rows_, in_.rows[std::min(sector_ + 1, last)]};
  }
  STEREOGRID_HD void end_at(GapKind kind, int seen, int landing, float fall_m);
  STEREOGRID_HD bool meet_trench();
  STEREOGRID_HD void set_ground(float z);
  [[nodiscard]] STEREOGRID_HD float widest_gap() const;
  STEREOGRID_HD void fill_missing(float z);
  [[nodiscard]] STEREOGRID_HD bool is_too_steep(float z);
  STEREOGRID_HD void set_obstacle(float top, int confirmations);
  [[nodiscard]] STEREOGRID_HD int confirmations_of(const RingSamples& samples) const;
  STEREOGRID_HD void miss();
  /// The right camera sees too few columns of the sector's ground in this ring.
  [[nodiscard]] STEREOGRID_HD bool is_blind() const {
    return static_cast<float>((sector_ + 1) * sector_px - samples_min) < in_.camera.focal_baseline_pxm / view_.begin_m;
  }
  [[nodiscard]] STEREOGRID_HD int ring_at(float x) const {
    return in_.rings.at_disparity(in_.camera.focal_baseline_pxm / x);
  }
  [[nodiscard]] STEREOGRID_HD bool is_beyond(float disparity_px) const {
    return in_.camera.focal_baseline_pxm < disparity_px * view_.x;
  }
  const WalkInput& in_;
  int sector_;
  const SectorRows& rows_;
  View<PolarCell> all_cells_;
  PolarCell* cells_;  ///< cells of the sector
  SectorWalk& walk_;
  WalkState state_;
  int ring_{0};
  RingView view_;
};

// Neither a step nor a slope leads from the foot to ground at z.
STEREOGRID_HD inline bool Walk::is_too_steep(float z) {
  const float steepest{in_.limits.slope * (view_.x - state_.foot_x)};
  const float rise{z - state_.foot_z};
  if (rise <= steepest) {
    state_.foot_x = view_.x;
    state_.foot_z = z;
    return false;
  }
  return view_.is_checked() &&
         rise > std::max(in_.limits.step_m, steepest) + steep_sigmas * view_.sigma(z, in_.limits.slope);
}

STEREOGRID_HD inline void Walk::set_ground(float z) {
  if (is_too_steep(z)) return set_obstacle(z, steep_confirmations);
  const float dx{view_.x - state_.x};
  const bool is_first{state_.x < in_.rings.begin_m(0)};
  const bool is_continued{is_first || dx < widest_gap()};
  if (is_continued && !is_first) fill_missing(z);
  state_.is_firm = state_.is_firm && is_continued;
  const float measured{std::clamp((z - state_.z) / std::max(dx, 1e-3f), -in_.limits.slope, in_.limits.slope)};
  state_.slope += (measured - state_.slope) * dx / (dx + slope_memory_m);
  state_.x = view_.x;
  state_.z = z;
  state_.missing = 0;
  cells_[ring_] = {z, state_.slope, TerrainClass::drivable, state_.is_firm};
}

STEREOGRID_HD inline void Walk::set_obstacle(float top, int confirmations) {
  cells_[ring_] = {std::max(top, state_.z), 0, TerrainClass::obstacle};
  state_.is_alive = false;
  state_.is_blocked = true;
  walk_.blocked = ring_;
  walk_.foot = std::min(ring_at(state_.foot_x) + 1, ring_);
  walk_.is_block_confirmed = false;
  walk_.block_confirmations = confirmations;
}

// Wrong matches hang in the air, or lie at the image's border.
STEREOGRID_HD inline int Walk::confirmations_of(const RingSamples& samples) const {
  const bool is_on_seen_ground{samples.is_standing && state_.x >= in_.rings.begin_m(0)};
  return !is_on_seen_ground || is_beyond(lone_obstacle_px) ? 2 : is_beyond(far_px) ? 1 : 0;
}

// Distance of two samples on the present surface, and at least two rings.
STEREOGRID_HD inline float Walk::widest_gap() const {
  const float h{in_.camera.height_m - state_.z};
  const float row{in_.camera.row_length(std::max(h + state_.slope * view_.x, 0.1f * h), view_.x)};
  return std::max(2.2f * (view_.end_m - view_.begin_m), 1.6f * row);
}

// Ground between two samples that are no farther apart than the camera's sampling.
STEREOGRID_HD inline void Walk::fill_missing(float z) {
  const float dx{view_.x - state_.x};
  for (int ring{ring_ - state_.missing}; ring < ring_; ++ring) {
    const float share{(in_.rings.middle_m(ring) - state_.x) / dx};
    cells_[ring] = {state_.z + share * (z - state_.z), state_.slope, TerrainClass::drivable, state_.is_firm};
  }
}

STEREOGRID_HD inline void Walk::miss() {
  ++state_.missing;
  const float gap{view_.x - state_.x};
  if (gap < std::max(reconnect_share * view_.x, widest_gap())) return;
  state_.is_alive = false;
}

// Continues from ground in two neighbours; behind an edge, not within its mark. Behind a confirmed
// one nothing is visible before the landing.
STEREOGRID_HD inline bool Walk::take_over(View<const SectorWalk> walks) {
  const bool is_behind_edge{walk_.end != no_ring && ring_ >= walk_.end};
  if (is_blind() || (is_behind_edge && ring_ <= walk_.end_seen + 1)) return false;
  if (is_behind_edge && ring_ <= walk_.landing && is_end_confirmed(sector_, walks)) return false;
  float sum{0};
  float slopes{0};
  int count{0};
  for (const int offset : {-2, -1, 1, 2}) {
    const int beside{sector_ + offset};
    if (beside < 0 || beside >= all_cells_.height || !all_cells_(ring_, beside).is_ground()) continue;
    sum += all_cells_(ring_, beside).elevation_m;
    slopes += all_cells_(ring_, beside).slope;
    ++count;
  }
  if (count < 2) return false;
  const float z{sum / static_cast<float>(count)};
  const float slope{slopes / static_cast<float>(count)};
  const float across_m{1.5f * sector_px * view_.x / in_.camera.focal_px};
  const float nearest{in_.limits.slope * across_m + 1.25f * view_.sigma(z, slope)};
  const RingSamples samples{view_.gather(z, slope, nearest)};
  if (!view_.has_ground(samples, z, slope) || (view_.is_checked() && view_.has_obstacle(samples, z))) return false;
  const float ground_z{samples.ground_z / static_cast<float>(samples.ground)};
  state_ = {view_.x, ground_z, slope, 0, 0, true, false, false, 0, view_.x, ground_z};
  return true;
}

STEREOGRID_HD inline void Walk::step_lost() {
  if (walk_.end != no_ring && ring_ >= walk_.end) cells_[ring_].kind = TerrainClass::hidden;
}

STEREOGRID_HD inline void Walk::meet_gap(int row, float z) {
  const Gap gap{classify_gap(in_.camera, in_.limits, rows_around(),
                             {row, state_.x, z, std::max(state_.slope, 0.0f), view_.sigma_px, in_.window_rows})};
  if (gap.kind == GapKind::none) return miss();
  // bridges without ground between them are one fall
  const float before_z{state_.x > state_.reached ? state_.z : state_.before_z};
  if (gap.kind == GapKind::bridge && before_z - gap.landing_z < in_.limits.step_m + 2 * view_.sigma(z, state_.slope)) {
    cells_[ring_] = {state_.z, state_.slope, TerrainClass::drivable};
    const float slope{std::abs(gap.slope) < in_.limits.slope ? gap.slope : 0.0f};
    state_ = {gap.landing_x, gap.landing_z, slope,         gap.landing_x, 0, true, false,
              false,         before_z,      gap.landing_x, gap.landing_z};
    return;
  }
  end_at(gap.kind, ring_, ring_at(gap.landing_x), std::max(state_.z - gap.landing_z, 0.0f));
}

STEREOGRID_HD inline bool Walk::meet_trench() {
  const std::optional<Trench>& trench{walk_.trench};
  if (!trench || ring_ != ring_at(trench->edge_x) || !view_.is_checked()) return false;
  const int wall{std::max(ring_at(trench->wall_x), ring_)};
  end_at(GapKind::drop, wall, wall, trench->fall_m);
  return true;
}

// The nearest edge of a sector counts. `seen`: last ring of the mark. `landing`: ring of the first visible surface
// behind it.
STEREOGRID_HD inline void Walk::end_at(GapKind kind, int seen, int landing, float fall_m) {
  cells_[ring_].kind = TerrainClass::hidden;
  state_.is_alive = false;
  if (walk_.end != no_ring) return;
  walk_.end = ring_;
  walk_.end_seen = seen;
  walk_.landing = landing;
  // the surface before the image may have any height
  walk_.end_kind = state_.x < in_.rings.begin_m(0) ? GapKind::unknown : kind;
  walk_.end_fall_m = fall_m;
  walk_.end_confirmations = is_beyond(far_px) ? 4 : 3;
}

STEREOGRID_HD inline void Walk::step() {
  if (is_blind()) {  // there may be an edge before the first visible ground
    state_.is_alive = false;
    return;
  }
  if (meet_trench()) return;
  if (view_.x < state_.reached) {
    cells_[ring_] = {state_.z, state_.slope, TerrainClass::drivable};
    return;
  }
  const float z{state_.elevation(view_.x)};
  const float allowed{std::max(in_.limits.step_m, 0.7f * in_.limits.slope * (view_.x - state_.x)) +
                      1.25f * view_.sigma(z, state_.slope)};
  const RingSamples samples{view_.gather(z, state_.slope, allowed)};
  if (view_.is_checked() && view_.has_obstacle(samples, z)) return set_obstacle(samples.top, confirmations_of(samples));
  if (view_.is_checked()) {
    const float z_near{state_.elevation(view_.begin_m)};
    const float z_far{state_.elevation(view_.end_m)};
    const int row{view_.row_through(z_near, z_far)};
    if (row != no_row) return meet_gap(row, std::min(z, state_.z));
  }
  view_.has_ground(samples, z, state_.slope) ? set_ground(samples.ground_z / static_cast<float>(samples.ground))
                                             : miss();
}

/// Walks along one sector from the vehicle outwards, until it loses the ground. `trench`: the sector's.
STEREOGRID_HD inline void walk_sector(const WalkInput& input, int sector, const std::optional<Trench>& trench,
                                      View<PolarCell> cells, SectorWalk& walk) {
  PolarCell* const of_sector{cells.row(sector)};
  for (int ring{0}; ring < input.rings.count(); ++ring) of_sector[ring] = PolarCell{};
  walk = {};
  walk.trench = trench;
  walk.state.x = 0.5f * input.rings.begin_m(0);
  walk.state.z = input.prior.elevation(walk.state.x);
  walk.state.slope = input.prior.slope;
  walk.state.foot_x = walk.state.x;
  walk.state.foot_z = walk.state.z;
  Walk steps{input, sector, cells, walk};
  for (; walk.lost < input.rings.count(); ++walk.lost) {
    steps.enter(walk.lost);
    steps.step();
    if (!steps.is_alive()) return;
  }
}

/// Steps of a sector in a ring behind the one in which it lost the ground, before take_over().
STEREOGRID_HD inline void step_on(const WalkInput& input, int sector, int ring, View<PolarCell> cells,
                                  SectorWalk& walk) {
  if (walk.lost >= ring) return;
  Walk steps{input, sector, cells, walk};
  steps.enter(ring);
  steps.is_alive() ? steps.step() : steps.step_lost();
}

/// Lets a sector that has lost the ground continue from the ground that neighbours have in the ring. Its own cell waits
/// for settle_taken(), so that the order of sectors does not matter. False: it has none to continue from.
STEREOGRID_HD inline bool take_over(const WalkInput& input, int sector, int ring, View<PolarCell> cells,
                                    View<SectorWalk> walks) {
  SectorWalk& walk{walks(sector, 0)};
  if (walk.lost > ring || walk.state.is_alive || cells(ring, sector).kind == TerrainClass::obstacle) return false;
  Walk steps{input, sector, cells, walk};
  steps.enter(ring);
  walk.has_taken = steps.take_over(walks);
  return walk.has_taken;
}

STEREOGRID_HD inline void settle_taken(int sector, int ring, View<PolarCell> cells, SectorWalk& walk) {
  if (walk.has_taken) cells(ring, sector) = {walk.state.z, walk.state.slope, TerrainClass::drivable};
  walk.has_taken = false;
}

}  // namespace stereogrid
