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
constexpr float slope_memory_m{0.8f};
constexpr float ground_share{0.25f};

class Walk {
 public:
  Walk(const WalkInput& input, int sector, PolarCell* cells, SectorWalk& walk)
      : in_{input}, sector_{sector}, rows_{input.samples.rows(sector)}, cells_{cells}, walk_{walk} {}

  void run(const WalkState& start, int first_ring, bool is_first_sweep) {
    state_ = start;
    takes_over_ = !is_first_sweep;
    for (ring_ = first_ring; ring_ < in_.rings.count(); ++ring_) {
      begin_m_ = in_.rings.begin_m(ring_);
      end_m_ = in_.rings.end_m(ring_);
      x_ = in_.rings.middle_m(ring_);
      sigma_px_ = in_.sigma_px[ring_];
      cells_[ring_] = PolarCell{};
      step();
    }
    note_lost();
  }

 private:
  void step();
  void step_lost();
  bool take_over();
  void meet_gap(int row, float z, float tolerance);
  void end_at(const Gap& gap);
  void set_ground(float z);
  [[nodiscard]] float widest_gap() const;
  void fill_missing(float z);
  void set_obstacle(const RingSamples& samples);
  void note_lost();
  void miss();
  [[nodiscard]] RingSamples gather(float z, float slope, float tolerance) const;
  [[nodiscard]] bool has_ground(const RingSamples& samples, float z, float slope) const;
  [[nodiscard]] bool has_obstacle(const RingSamples& samples, float z, float slope) const;
  [[nodiscard]] int row_through(float z_near, float z_far) const;
  [[nodiscard]] float predicted_rows(float z, float slope) const;
  [[nodiscard]] bool is_judged() const { return ring_ < in_.judged_rings; }
  [[nodiscard]] float sigma(float z, float slope) const {
    return in_.camera.height_sigma(in_.camera.height_m - z, slope, x_, sigma_px_);
  }

  const WalkInput& in_;
  int sector_;
  SectorRows rows_;
  PolarCell* cells_;
  SectorWalk& walk_;
  WalkState state_{};
  bool takes_over_{false};
  bool is_lost_noted_{false};

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
  const float lowest_above{std::max(step, 2.5f * sigma(z, slope))};
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

// First row, upwards, of those that show the expected ground in this ring, if half of them look behind it.
int Walk::row_through(float z_near, float z_far) const {
  const float height{in_.camera.height_m};
  const auto row_at = [&](float z, float x) {
    return ((height - z) / x - rows_.tangent_at_row_0) / rows_.tangent_per_v;
  };
  const int lowest{std::min(static_cast<int>(std::floor(row_at(z_near, begin_m_))), rows_.end_row - 1)};
  const int highest{std::max(static_cast<int>(std::ceil(row_at(z_far, end_m_))), rows_.first_row)};
  const float behind_m{end_m_ + 2.5f * in_.camera.range_sigma(x_, sigma_px_)};
  const float below{std::min(z_near, z_far)};
  int valid{0};
  int through{0};
  int first{no_row};
  for (int v{lowest}; v >= highest; --v) {
    if (!(rows_.disparity[v] > 0)) continue;
    ++valid;
    if (rows_.x[v] < behind_m || rows_.z[v] > below) continue;
    ++through;
    if (first == no_row) first = v;
  }
  return 2 * through >= valid ? first : no_row;
}

void Walk::set_ground(float z) {
  const float dx{x_ - state_.x};
  if (dx < widest_gap()) fill_missing(z);
  const float measured{std::clamp((z - state_.z) / std::max(dx, 1e-3f), -in_.limits.slope, in_.limits.slope)};
  state_.slope += (measured - state_.slope) * dx / (dx + slope_memory_m);
  state_.x = x_;
  state_.z = z;
  state_.missing = 0;
  cells_[ring_] = {z, state_.slope, TerrainClass::drivable};
}

void Walk::set_obstacle(const RingSamples& samples) {
  cells_[ring_] = {std::max(samples.top, state_.z), 0, TerrainClass::obstacle};
  note_lost();
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
    cells_[ring] = {state_.z + share * (z - state_.z), state_.slope, TerrainClass::drivable};
  }
}

// Remembers the state before the ground is lost for the first time: later sweeps begin there.
void Walk::note_lost() {
  if (is_lost_noted_ || takes_over_) return;
  is_lost_noted_ = true;
  walk_.first_lost = ring_;
  walk_.at_first_lost = state_;
}

void Walk::miss() {
  ++state_.missing;
  const float gap{x_ - state_.x};
  if (gap < std::max(reconnect_share * x_, widest_gap())) return;
  note_lost();
  state_.is_alive = false;
}

// Continues from the ground of two neighbours (three behind an edge) of the sweep before.
bool Walk::take_over() {
  if (!takes_over_) return false;
  float sum{0};
  float slopes{0};
  int count{0};
  for (const int offset : {-2, -1, 1, 2}) {
    const int beside{sector_ + offset};
    if (beside < 0 || beside >= in_.before.height) continue;
    const PolarCell& cell{in_.before(ring_, beside)};
    if (!cell.is_ground()) continue;
    sum += cell.elevation_m;
    slopes += cell.slope;
    ++count;
  }
  if (count < (walk_.end == no_ring ? 2 : 3)) return false;
  const float z{sum / static_cast<float>(count)};
  const float slope{slopes / static_cast<float>(count)};
  const float across_m{1.5f * sector_px * x_ / in_.camera.focal_px};
  const RingSamples samples{gather(z, slope, std::max(in_.limits.step_m, in_.limits.slope * across_m))};
  if (!has_ground(samples, z, slope) || (is_judged() && has_obstacle(samples, z, slope))) return false;
  state_ = {x_, samples.ground_z / static_cast<float>(samples.ground), slope, 0, 0, true, false};
  cells_[ring_] = {state_.z, slope, TerrainClass::drivable};
  return true;
}

// Rays that pass through the plane of the ground contradict it.
void Walk::step_lost() {
  if (take_over()) return;
  if (walk_.end != no_ring) {
    cells_[ring_].kind = TerrainClass::hidden;
  } else if (!state_.is_blocked && is_judged() && row_through(0, 0) != no_row) {
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
  if (gap.kind == GapKind::bridge) {
    cells_[ring_] = {state_.z, state_.slope, TerrainClass::drivable};
    state_ = {gap.landing_x, gap.landing_z, std::abs(gap.slope) < in_.limits.slope ? gap.slope : 0.0f, gap.landing_x, 0,
              true,          false};
    return;
  }
  note_lost();
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
  if (!state_.is_alive) return step_lost();
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
    const int row{row_through(state_.elevation(begin_m_), state_.elevation(end_m_))};
    if (row != no_row) return meet_gap(row, std::min(z, state_.z), allowed);
  }
  if (has_ground(samples, z, state_.slope)) return set_ground(samples.ground_z / static_cast<float>(samples.ground));
  if (!take_over()) miss();
}

}  // namespace

void walk_sector(const WalkInput& input, int sector, bool is_first_sweep, PolarCell* cells, SectorWalk& walk) {
  Walk steps{input, sector, cells, walk};
  if (is_first_sweep) {
    walk = {};
    // the plane is the prior of what lies before the image
    steps.run({0.5f * input.rings.begin_m(0), 0, 0, 0, 0, true, false}, 0, true);
    return;
  }
  walk.end = no_ring;
  std::copy_n(input.before.row(sector), walk.first_lost, cells);
  steps.run(walk.at_first_lost, walk.first_lost, false);
}

}  // namespace stereogrid
