// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "outlines.hpp"
#include "stereogrid/evaluation/obstacles.hpp"
#include "totals.hpp"

namespace stereogrid::evaluation {
namespace {

constexpr double found_from{0.5};  // share of a thing's seen points
constexpr double part_from{0.1};
constexpr double seems_to_move_above_mps{1};
constexpr double near_a_mover_m{1.5};
constexpr double cell_reach_m{0.4};

/// No larger than this, an obstacle is a thing's own.
double own_area_max_m2(const Thing& thing) {
  return 2 * thing.area_m2 + 2;
}

double share(std::size_t part, std::size_t whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : ObstacleSummary::nothing;
}

/// Between the two values beside it.
double interpolated_quantile(std::vector<double> values, double share) {
  if (values.empty()) return ObstacleSummary::nothing;
  std::ranges::sort(values);
  const double place{share * static_cast<double>(values.size() - 1)};
  const auto below{static_cast<std::size_t>(place)};
  const double above{values[std::min(below + 1, values.size() - 1)]};
  return std::lerp(values[below], above, place - std::floor(place));
}

double median(const std::vector<double>& values) {
  return interpolated_quantile(values, 0.5);
}

double distance_between(Point2 a, Point2 b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

Point2 centre_of(const Obstacle& obstacle) {
  return {obstacle.x_m, obstacle.y_m};
}

double speed_of(const Obstacle& obstacle) {
  return std::hypot(obstacle.vx_mps, obstacle.vy_mps);
}

}  // namespace

struct ObstacleScores::Candidate {
  const Obstacle* obstacle;
  std::vector<Point2> outline;
  bool closed;
  double area_m2;  // closed outlines only
  double y_min_m;  // minimum of the outline
  double y_max_m;

  [[nodiscard]] bool holds_cell(Point2 cell) const {
    return cell.y >= y_min_m && cell.y <= y_max_m && holds(outline, cell);
  }
  [[nodiscard]] bool may_be_own_of(const Thing& thing) const { return closed && area_m2 <= own_area_max_m2(thing); }
  /// True if its centre and part of the seen points lie on the thing.
  [[nodiscard]] bool lies_on(const Thing& thing, double held) const {
    return closed && held >= part_from && distance_m(thing.footprint, centre_of(*obstacle)) <= thing.reach_m;
  }
  /// True if the covered area is seen to be free, where it is seen.
  [[nodiscard]] bool covers_free_ground(const ObstacleTruth& truth) const {
    const auto held{[this](Point2 cell) { return holds_cell(cell); }};
    const auto free{std::ranges::count_if(truth.free, held)};
    return free > 0 && free >= std::ranges::count_if(truth.occupied, held);
  }
};

ObstacleScores::Candidates ObstacleScores::candidates_of(std::span<const Obstacle> reported) {
  Candidates candidates;
  for (const Obstacle& o : reported) {
    if (!o.confirmed || o.kind == ObstacleKind::drop) continue;  // terrain scores edges
    const bool closed{o.kind == ObstacleKind::object};
    std::vector<Point2> outline{o.outline.begin(), o.outline.end()};
    if (outline.empty()) outline = corners_of({o.x_m, o.y_m, o.yaw_rad}, o.length_m, o.width_m);
    const auto [least, most]{std::ranges::minmax(outline, {}, &Point2::y)};
    const double area{closed ? area_of(outline) : 0};
    candidates.push_back({&o, std::move(outline), closed, area, least.y, most.y});
  }
  return candidates;
}

void ObstacleScores::add(const ObstacleTruth& truth, std::span<const Obstacle> reported,
                         std::span<const Point2> moving_cells) {
  const Candidates candidates{candidates_of(reported)};
  ++counts_.frames;
  add_cells(truth, candidates);
  add_outlines(candidates);
  add_motion(truth, candidates);
  add_moving_cells(moving_cells, candidates);
  Shares shares;
  for (const Thing& thing : truth.things) {
    for (const Candidate& c : candidates) {
      shares.push_back(share_near(c.outline, c.closed, thing.seen, thing.reach_m));
    }
    add_thing(thing, std::span{shares}.last(candidates.size()), candidates);
  }
  add_merged(truth, shares, candidates);
  add_tracks(truth, shares, candidates);
}

void ObstacleScores::add_cells(const ObstacleTruth& truth, const Candidates& candidates) {
  const auto is_covered = [&](Point2 cell) {
    return std::ranges::any_of(candidates, [cell](const Candidate& c) { return c.closed && c.holds_cell(cell); });
  };
  counts_.has_cell_truth = counts_.has_cell_truth || truth.has_cell_truth;
  counts_.free += truth.free.size();
  counts_.covered += static_cast<std::size_t>(std::ranges::count_if(truth.free, is_covered));
  for (const Candidate& c : candidates) {
    if (c.closed) areas_m2_.push_back(c.area_m2);
  }
}

void ObstacleScores::add_outlines(const Candidates& candidates) {
  for (const Candidate& c : candidates) {
    const OutlineShape shape{shape_of(c.outline, c.closed)};
    ++counts_.outlines;
    counts_.corners += shape.corners;
    counts_.turns += shape.turns;
    outlines_m_ += shape.length_m;
  }
}

// Over the rays that meet both outline and footprint.
void ObstacleScores::add_near_side(const Thing& thing, const Candidate& candidate, double sigma_per_m2) {
  constexpr int rays{16};
  const Slopes found{slopes_of(candidate.outline)};
  const Slopes known{slopes_of(thing.footprint)};
  const double least{std::max(found.least, known.least)};
  const double most{std::min(found.most, known.most)};
  for (int i{0}; i < rays && least < most; ++i) {
    const double slope{std::lerp(least, most, (i + 0.5) / rays)};
    const double true_m{nearest_on_ray(thing.footprint, slope)};
    const double found_m{nearest_on_ray(candidate.outline, slope)};
    if (!std::isfinite(true_m) || !std::isfinite(found_m)) continue;
    ++counts_.rays;
    near_sigmas_ += std::abs(found_m - true_m) / (sigma_per_m2 * true_m * true_m);
  }
}

void ObstacleScores::add_moving_cells(std::span<const Point2> cells, const Candidates& candidates) {
  counts_.moving_cells += cells.size();
  for (const Point2 cell : cells) {
    bool moves{false};
    bool stands{false};
    for (const Candidate& c : candidates) {
      if (is_near(c.outline, c.closed, cell, cell_reach_m)) (c.obstacle->moving ? moves : stands) = true;
    }
    if (stands && !moves) ++counts_.moving_cells_standing;
  }
}

void ObstacleScores::add_motion(const ObstacleTruth& truth, const Candidates& candidates) {
  for (const Candidate& c : candidates) {
    if (!c.obstacle->moving && speed_of(*c.obstacle) <= seems_to_move_above_mps) continue;
    const auto is_near_it = [&c](const ObstacleTruth::Circle& mover) {
      return distance_between(centre_of(*c.obstacle), mover.centre) < mover.radius_m + near_a_mover_m;
    };
    ++counts_.moving;
    if (std::ranges::none_of(truth.movers, is_near_it)) ++counts_.moving_wrong;
  }
}

void ObstacleScores::add_thing(const Thing& thing, std::span<const double> shares, const Candidates& candidates) {
  const Candidate* best{nullptr};
  double most{0};
  bool closed{false};
  bool open{false};
  std::size_t parts{0};
  for (std::size_t i{0}; i < candidates.size(); ++i) {
    const Candidate& c{candidates[i]};
    if (shares[i] >= found_from) (c.closed ? closed : open) = true;
    if (c.lies_on(thing, shares[i])) ++parts;
    if (!c.may_be_own_of(thing) || shares[i] <= most) continue;
    most = shares[i];
    best = &c;
  }
  ObstacleSummary::Kind& kind{by_kind_[thing.kind]};
  ++kind.things;
  ++counts_.things;
  if (closed || open) ++counts_.found;
  if (open && !closed) ++counts_.in_extended;
  if (parts >= 2) ++counts_.split;
  if (most < found_from) return;
  ++kind.separate;
  ++counts_.separate;
  if (!thing.velocity_mps) return;
  const Point2 velocity{best->obstacle->vx_mps, best->obstacle->vy_mps};
  errors_.velocity_mps.push_back(distance_between(velocity, *thing.velocity_mps));
}

void ObstacleScores::add_merged(const ObstacleTruth& truth, const Shares& shares, const Candidates& candidates) {
  std::vector<bool> merged(truth.things.size());
  for (std::size_t j{0}; j < candidates.size(); ++j) {
    std::vector<std::size_t> held;
    for (std::size_t i{0}; i < truth.things.size(); ++i) {
      if (candidates[j].closed && shares[i * candidates.size() + j] >= found_from) held.push_back(i);
    }
    if (held.size() < 2) continue;
    for (const std::size_t i : held) merged[i] = true;
  }
  counts_.merged += static_cast<std::size_t>(std::ranges::count(merged, true));
}

void ObstacleScores::add_tracks(const ObstacleTruth& truth, const Shares& shares, const Candidates& candidates) {
  TrackingFrame frame;
  std::vector<bool> on_a_thing(candidates.size());
  for (std::size_t i{0}; i < truth.things.size(); ++i) {
    const Thing& thing{truth.things[i]};
    frame.objects.push_back(thing.id);
    for (std::size_t j{0}; j < candidates.size(); ++j) {
      const Candidate& c{candidates[j]};
      const double held{shares[i * candidates.size() + j]};
      const bool fits{c.may_be_own_of(thing) && held >= found_from};
      frame.distances.push_back(fits ? distance_between(centre_of(*c.obstacle), thing.centre)
                                     : TrackingFrame::no_match);
      if (fits || c.lies_on(thing, held)) on_a_thing[j] = true;
    }
  }
  for (std::size_t j{0}; j < candidates.size(); ++j) {
    const Candidate& c{candidates[j]};
    const bool is_false{on_a_thing[j] || (c.closed && c.covers_free_ground(truth))};
    frame.hypotheses.push_back({c.obstacle->id, !is_false});
  }
  for (const TrackingScores::Match& match : tracking_.add(frame)) {
    const Thing& thing{truth.things[match.object]};
    add_errors(thing, candidates[match.hypothesis]);
    if (truth.sigma_per_m2 > 0) add_near_side(thing, candidates[match.hypothesis], truth.sigma_per_m2);
  }
}

void ObstacleScores::add_errors(const Thing& thing, const Candidate& candidate) {
  const Obstacle& o{*candidate.obstacle};
  errors_.centre_m.push_back(distance_between(centre_of(o), thing.centre));
  errors_.nearest_edge_m.push_back(std::abs(distance_m(candidate.outline, {}) - distance_m(thing.footprint, {})));
  // the heading of static things is that of the longer side
  const auto [shorter, longer]{std::minmax(thing.length_m, thing.width_m)};
  errors_.length_m.push_back(std::abs(std::max(o.length_m, o.width_m) - longer));
  errors_.width_m.push_back(std::abs(std::min(o.length_m, o.width_m) - shorter));
  if (!thing.velocity_mps) return;
  const Point2 velocity{*thing.velocity_mps};
  errors_.speed_mps.push_back(std::abs(speed_of(o) - std::hypot(velocity.x, velocity.y)));
  if (!o.moving) return;
  const double error{std::remainder(o.yaw_rad - std::atan2(velocity.y, velocity.x), 2 * std::numbers::pi)};
  errors_.heading_deg.push_back(std::abs(error) * 180 / std::numbers::pi);
}

ObstacleSummary ObstacleScores::summary() const {
  ObstacleSummary s;
  s.frames = counts_.frames;
  s.things = counts_.things;
  s.separate = share(counts_.separate, counts_.things);
  s.by_kind = by_kind_;
  s.found = share(counts_.found, counts_.things);
  s.in_extended = share(counts_.in_extended, counts_.things);
  s.merged = share(counts_.merged, counts_.things);
  s.split = share(counts_.split, counts_.things);
  s.free_cells = counts_.free;
  s.free_covered = share(counts_.covered, counts_.free);
  s.moving = counts_.moving;
  s.moving_wrong = share(counts_.moving_wrong, counts_.moving);
  s.moving_cells = counts_.moving_cells;
  s.moving_cells_standing = share(counts_.moving_cells_standing, counts_.moving_cells);
  s.speed_error_mps = median(errors_.velocity_mps);
  s.area_median_m2 = median(areas_m2_);
  s.area_p90_m2 = interpolated_quantile(areas_m2_, 0.9);
  s.corners = share(counts_.corners, counts_.outlines);
  if (outlines_m_ > 0) s.turns_per_m = static_cast<double>(counts_.turns) / outlines_m_;
  if (counts_.rays > 0) s.near_side_sigmas = near_sigmas_ / static_cast<double>(counts_.rays);
  s.has_complete_truth = counts_.has_cell_truth;
  s.tracking = tracking_.summary();
  s.centre_error_m = median(errors_.centre_m);
  s.nearest_edge_error_m = median(errors_.nearest_edge_m);
  s.length_error_m = median(errors_.length_m);
  s.width_error_m = median(errors_.width_m);
  s.movers = errors_.speed_mps.size();
  s.mover_speed_error_mps = median(errors_.speed_mps);
  s.headings = errors_.heading_deg.size();
  s.heading_error_deg = median(errors_.heading_deg);
  return s;
}

}  // namespace stereogrid::evaluation
