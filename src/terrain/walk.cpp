// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "terrain/walk.hpp"

#include <algorithm>
#include <cmath>

namespace stereogrid {
namespace {

/// Ground, obstacle and face samples of a ring, relative to an expected elevation.
struct RingSamples {
  int ground{0};
  float ground_z{0};  ///< sum
  int above{0};
  float top{-1e3f};       ///< highest sample of an obstacle
  float face_top{-1e3f};  ///< of upright samples
  float face_bottom{1e3f};
  int face{0};
};

/// Ground found again behind missing samples, at the expected elevation, is the same surface up to here.
constexpr float reconnect_share{0.3f};  ///< of the range
constexpr int common_end_rings{1};      ///< behind the common edge, for its noise
constexpr float slope_memory_m{0.8f};
constexpr float slope_base_rings{4};  ///< distance over which slope_max counts
constexpr float ground_share{0.25f};

class Walk {
 public:
  Walk(const WalkInput& input, int sector, View<PolarCell> cells, SectorWalk& walk)
      : in_{input},
        sector_{sector},
        rows_{input.samples.rows(sector)},
        all_cells_{cells},
        cells_{cells.row(sector)},
        walk_{walk},
        state_{walk.state} {}
  Walk(const Walk&) = delete;
  Walk& operator=(const Walk&) = delete;
  ~Walk() { walk_.state = state_; }

  [[nodiscard]] bool is_alive() const { return state_.is_alive; }
  void enter(int ring) {
    ring_ = ring;
    begin_m_ = in_.rings.begin_m(ring);
    end_m_ = in_.rings.end_m(ring);
    x_ = in_.rings.middle_m(ring);
    sigma_px_ = in_.sigma_px[ring];
  }
  void step();
  void step_lost();
  bool take_over();

 private:
  void meet_gap(int row, float z, float tolerance);
  [[nodiscard]] bool is_within_slope(float z) const;
  void end_at(const Gap& gap);
  void set_ground(float z);
  [[nodiscard]] float widest_gap() const;
  void fill_missing(float z);
  void set_steep(float z);
  void set_obstacle(const RingSamples& samples);
  void miss();
  [[nodiscard]] RingSamples gather(float z, float slope, float tolerance) const;
  [[nodiscard]] bool has_ground(const RingSamples& samples, float z, float slope) const;
  [[nodiscard]] bool has_obstacle(const RingSamples& samples, float z, float slope) const;
  [[nodiscard]] int row_through(float z_near, float z_far, float highest_z) const;
  [[nodiscard]] float predicted_rows(float z, float slope) const;
  /// The right camera does not see the sector's ground in this ring.
  [[nodiscard]] bool is_blind() const {
    return static_cast<float>(sector_ * sector_px) < in_.camera.focal_baseline_pxm / begin_m_ + in_.window_rows / 2;
  }
  [[nodiscard]] bool is_judged() const { return ring_ < in_.judged_rings; }
  [[nodiscard]] float sigma(float z, float slope) const {
    return in_.camera.height_sigma(in_.camera.height_m - z, slope, x_, sigma_px_);
  }

  const WalkInput& in_;
  int sector_;
  SectorRows rows_;
  View<PolarCell> all_cells_;
  PolarCell* cells_;  ///< of the sector
  SectorWalk& walk_;
  WalkState state_;

  // of a ring
  int ring_{0};
  float begin_m_{0};
  float end_m_{0};
  float x_{0};
  float sigma_px_{0};
};

float Walk::predicted_rows(float z, float slope) const {
  const float half_m{0.5f * slope * (end_m_ - begin_m_)};
  const float h{in_.camera.height_m - z};
  return ((h + half_m) / begin_m_ - (h - half_m) / end_m_) / in_.camera.tangent_per_v;
}

RingSamples Walk::gather(float z, float slope, float tolerance) const {
  RingSamples found;
  const float step{in_.limits.step_m};
  const float like_slope{2 * in_.limits.slope * in_.camera.range_sigma(x_, sigma_px_)};  // (6)
  const float lowest_above{std::max({step, 2.5f * sigma(z, slope), like_slope})};
  for (int v{rows_.first[ring_]}; v != no_row; v = rows_.next[v]) {
    const float on_surface{rows_.z[v] - slope * (rows_.x[v] - x_)};
    const float over{on_surface - z};
    const bool is_upright{rows_.upright[v] != 0};
    if (std::abs(over) < tolerance && !(is_upright && over > 0.3f * step)) {
      ++found.ground;
      found.ground_z += on_surface;
    }
    if (over > in_.limits.height_m) continue;
    if (over > lowest_above) {
      ++found.above;
      found.top = std::max(found.top, rows_.z[v]);
    }
    if (!is_upright) continue;
    ++found.face;
    found.face_top = std::max(found.face_top, over);
    found.face_bottom = std::min(found.face_bottom, over);
  }
  return found;
}

bool Walk::has_ground(const RingSamples& samples, float z, float slope) const {
  return samples.ground > 0 && static_cast<float>(samples.ground) >= ground_share * predicted_rows(z, slope);
}

// A face of two thirds of a step, or a level top, has so many rows; 30 % of them are an obstacle.
bool Walk::has_obstacle(const RingSamples& samples, float z, float slope) const {
  const float step{in_.limits.step_m};
  const float face_rows{step * 2 / 3 / (x_ * in_.camera.tangent_per_v)};
  const float top_rows{(in_.camera.height_m - z - step) * (end_m_ - begin_m_) / (x_ * x_ * in_.camera.tangent_per_v)};
  const float fewest{std::max(2.0f, 0.3f * std::min(face_rows, std::max(top_rows, 0.0f)))};
  if (static_cast<float>(samples.above) >= fewest) return true;
  const float noise{sigma(z, slope)};
  return samples.face >= 4 && samples.face_top > std::max(0.85f * step, 2 * noise) &&
         samples.face_top - samples.face_bottom > std::max(0.75f * step, 2 * noise);
}

// First row, upwards, of those that show the expected ground in this ring, if half of them look behind it, lower than
// `highest_z`.
int Walk::row_through(float z_near, float z_far, float highest_z) const {
  const float height{in_.camera.height_m};
  const auto row_at = [&](float z, float x) {
    return ((height - z) / x - rows_.tangent_at_row_0) / rows_.tangent_per_v;
  };
  const int lowest{std::min(static_cast<int>(std::floor(row_at(z_near, begin_m_))), rows_.end_row - 1)};
  const int highest{std::max(static_cast<int>(std::ceil(row_at(z_far, end_m_))), rows_.first_row)};
  const float behind_m{end_m_ + 2.5f * in_.camera.range_sigma(x_, sigma_px_)};
  int valid{0};
  int through{0};
  int first{no_row};
  for (int v{lowest}; v >= highest; --v) {
    if (!(rows_.disparity[v] > 0)) continue;
    ++valid;
    if (rows_.x[v] < behind_m || rows_.z[v] > highest_z) continue;
    ++through;
    if (first == no_row) first = v;
  }
  return 2 * through >= valid ? first : no_row;
}

// Elevation that is reached from the ground some cells nearer by a slope or a step within the limits.
bool Walk::is_within_slope(float z) const {
  const float base_m{slope_base_rings * (end_m_ - begin_m_)};
  int ring{ring_ - 1};
  while (ring >= 0 && (!cells_[ring].is_ground() || in_.rings.middle_m(ring) > x_ - base_m)) --ring;
  if (ring < 0) return true;
  const float most{std::max(in_.limits.step_m, in_.limits.slope * (x_ - in_.rings.middle_m(ring)))};
  return z - cells_[ring].elevation_m < most + 2 * sigma(z, state_.slope);
}

void Walk::set_ground(float z) {
  const float dx{x_ - state_.x};
  const bool is_continued{dx < widest_gap()};
  if (is_continued) fill_missing(z);
  state_.is_firm = state_.is_firm && is_continued && std::abs(z - state_.elevation(x_)) < 0.5f * in_.limits.step_m;
  const float measured{std::clamp((z - state_.z) / std::max(dx, 1e-3f), -in_.limits.slope, in_.limits.slope)};
  state_.slope += (measured - state_.slope) * dx / (dx + slope_memory_m);
  state_.x = x_;
  state_.z = z;
  state_.missing = 0;
  cells_[ring_] = {z, state_.slope, TerrainClass::drivable, state_.is_firm};
}

// Too steep: an obstacle from where it rises.
void Walk::set_steep(float z) {
  const float base_m{slope_base_rings * (end_m_ - begin_m_)};
  for (int ring{ring_ - 1}; ring >= 0 && in_.rings.middle_m(ring) > x_ - base_m; --ring) cells_[ring] = PolarCell{};
  RingSamples samples;
  samples.top = z;
  set_obstacle(samples);
}

void Walk::set_obstacle(const RingSamples& samples) {
  cells_[ring_] = {std::max(samples.top, state_.z), 0, TerrainClass::obstacle};
  state_.is_alive = false;
  state_.is_blocked = true;
}

// Distance of two samples on the present surface, and at least two rings.
float Walk::widest_gap() const {
  const float h{in_.camera.height_m - state_.z};
  const float row{in_.camera.row_length(std::max(h + state_.slope * x_, 0.1f * h), x_)};
  return std::max(2.2f * (end_m_ - begin_m_), 1.6f * row);
}

// Ground between two samples that are no farther apart than the camera's sampling.
void Walk::fill_missing(float z) {
  const float dx{x_ - state_.x};
  for (int ring{ring_ - state_.missing}; ring < ring_; ++ring) {
    const float share{(in_.rings.middle_m(ring) - state_.x) / dx};
    cells_[ring] = {state_.z + share * (z - state_.z), state_.slope, TerrainClass::drivable, state_.is_firm};
  }
}

void Walk::miss() {
  ++state_.missing;
  const float gap{x_ - state_.x};
  if (gap < std::max(reconnect_share * x_, widest_gap())) return;
  state_.is_alive = false;
}

// Continues from the ground of two neighbours; behind an edge, not within its smear.
bool Walk::take_over() {
  if (walk_.end != no_ring && ring_ <= walk_.end_seen + 1) return false;
  float sum{0};
  float slopes{0};
  int count{0};
  for (const int offset : {-2, -1, 1, 2}) {
    const int beside{sector_ + offset};
    if (beside < 0 || beside >= all_cells_.height) continue;
    const PolarCell& cell{all_cells_(ring_, beside)};
    if (!cell.is_ground()) continue;
    sum += cell.elevation_m;
    slopes += cell.slope;
    ++count;
  }
  if (count < 2) return false;
  const float z{sum / static_cast<float>(count)};
  const float slope{slopes / static_cast<float>(count)};
  const float across_m{1.5f * sector_px * x_ / in_.camera.focal_px};
  const float nearest{0.5f * in_.limits.step_m + in_.limits.slope * across_m + sigma(z, slope)};
  const RingSamples samples{gather(z, slope, nearest)};
  if (!has_ground(samples, z, slope) || (is_judged() && has_obstacle(samples, z, slope))) return false;
  state_ = {x_, samples.ground_z / static_cast<float>(samples.ground), slope, 0, 0, true, false, false};
  cells_[ring_] = {state_.z, slope, TerrainClass::drivable};
  return true;
}

// Rays that pass through the plane of the ground contradict it.
void Walk::step_lost() {
  if (is_blind() || take_over()) return;
  if (walk_.end != no_ring) {
    cells_[ring_].kind = TerrainClass::hidden;
  } else if (!state_.is_blocked && is_judged() && row_through(0, 0, -in_.limits.step_m) != no_row) {
    cells_[ring_].kind = TerrainClass::hidden;
  }
}

void Walk::meet_gap(int row, float z, float tolerance) {
  const auto beside = [&](int offset) {
    return in_.samples.rows(std::clamp(sector_ + offset, 0, in_.samples.sectors() - 1));
  };
  const Gap gap{
      classify_gap(in_.camera, in_.limits, {beside(-1), rows_, beside(1)}, {row, z, sigma_px_, in_.window_rows})};
  if (gap.kind == GapKind::descent) {
    state_.slope = gap.slope;
    const float sloped{state_.elevation(x_)};
    const RingSamples samples{gather(sloped, gap.slope, tolerance)};
    if (has_ground(samples, sloped, gap.slope))
      return set_ground(samples.ground_z / static_cast<float>(samples.ground));
    return miss();
  }
  if (gap.kind == GapKind::none) return miss();
  if (gap.kind == GapKind::bridge) {
    cells_[ring_] = {state_.z, state_.slope, TerrainClass::drivable};
    const float slope{std::abs(gap.slope) < in_.limits.slope ? gap.slope : 0.0f};
    state_ = {gap.landing_x, gap.landing_z, slope, gap.landing_x, 0, true, false, false};
    return;
  }
  end_at(gap);
  cells_[ring_].kind = TerrainClass::hidden;
  state_.is_alive = false;
}

// The nearest edge of a sector counts.
void Walk::end_at(const Gap& gap) {
  if (walk_.end != no_ring) return;
  walk_.end = ring_;
  while (walk_.end > 0 && in_.rings.begin_m(walk_.end) > gap.mark_x) --walk_.end;
  walk_.end_seen = ring_;
  walk_.end_kind = gap.kind;
}

void Walk::step() {
  if (is_blind()) {
    state_.x = x_;
    return;
  }
  if (x_ < state_.reached) {
    cells_[ring_] = {state_.z, state_.slope, TerrainClass::drivable};
    return;
  }
  const float z{state_.elevation(x_)};
  const float allowed{std::max(in_.limits.step_m, 0.7f * in_.limits.slope * (x_ - state_.x)) +
                      1.25f * sigma(z, state_.slope)};
  const RingSamples samples{gather(z, state_.slope, allowed)};
  if (is_judged() && has_obstacle(samples, z, state_.slope)) return set_obstacle(samples);
  if (is_judged()) {
    const float z_near{state_.elevation(begin_m_)};
    const float z_far{state_.elevation(end_m_)};
    const int row{row_through(z_near, z_far, std::min(z_near, z_far))};
    if (row != no_row) return meet_gap(row, std::min(z, state_.z), allowed);
  }
  if (has_ground(samples, z, state_.slope)) {
    const float found{samples.ground_z / static_cast<float>(samples.ground)};
    return is_within_slope(found) ? set_ground(found) : set_steep(found);
  }
  miss();
}

void end_at_common(const WalkInput& input, int sector, View<PolarCell> cells, SectorWalk& walk) {
  const int last{walk.common_end + common_end_rings};
  if (walk.common_end == no_ring || walk.lost <= last || walk.end != no_ring) return;
  std::fill(cells.row(sector) + last, cells.row(sector) + input.rings.count(), PolarCell{});
  cells(last, sector).kind = TerrainClass::hidden;
  walk.lost = walk.end = walk.end_seen = last;
  walk.state.is_alive = false;
}

}  // namespace

void walk_sector(const WalkInput& input, int sector, View<PolarCell> cells, SectorWalk& walk) {
  std::fill_n(cells.row(sector), input.rings.count(), PolarCell{});
  walk = {};
  // the plane is the prior of what lies before the image
  walk.state.x = 0.5f * input.rings.begin_m(0);
  Walk steps{input, sector, cells, walk};
  for (; walk.lost < input.rings.count(); ++walk.lost) {
    steps.enter(walk.lost);
    steps.step();
    if (!steps.is_alive()) return;
  }
}

void spread_ground(const WalkInput& input, View<PolarCell> cells, View<SectorWalk> walks) {
  for (int sector{0}; sector < walks.width; ++sector) end_at_common(input, sector, cells, walks(sector, 0));
  for (int ring{0}; ring < input.rings.count(); ++ring) {
    for (int sector{0}; sector < walks.width; ++sector) {
      SectorWalk& walk{walks(sector, 0)};
      if (walk.lost >= ring) continue;
      Walk steps{input, sector, cells, walk};
      steps.enter(ring);
      steps.is_alive() ? steps.step() : steps.step_lost();
    }
    for (int sector{walks.width - 1}; sector >= 0; --sector) {
      SectorWalk& walk{walks(sector, 0)};
      if (walk.lost > ring || walk.state.is_alive || cells(ring, sector).kind == TerrainClass::obstacle) continue;
      Walk steps{input, sector, cells, walk};
      steps.enter(ring);
      steps.take_over();
    }
  }
}

}  // namespace stereogrid
