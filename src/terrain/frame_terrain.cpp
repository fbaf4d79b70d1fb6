// SPDX-License-Identifier: Apache-2.0
#include "terrain/frame_terrain.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <utility>

#include "geometry/window.hpp"

namespace stereogrid {
namespace {

TerrainLimits limits_of(const Config& config) {
  const auto tangent = [](double degrees) { return static_cast<float>(std::tan(degrees * std::numbers::pi / 180)); };
  const VehicleConfig& vehicle{config.vehicle};
  return {static_cast<float>(vehicle.step_max_m), tangent(vehicle.slope_max_deg), static_cast<float>(vehicle.height_m),
          static_cast<float>(config.u_disparity.obstacle_min_height_m), tangent(vehicle.drop_slope_deg)};
}

/// Rows of a ditch's far wall that are needed to find it (5).
constexpr double ditch_rows{6};
/// Smallest drop that is found, in smallest drops that a jump of one pixel shows (4).
constexpr double found_drops{3};
/// Maximum number of cells of low obstacles, more than both kerbs of a street; excess cells make none.
constexpr std::size_t low_cells_max{4096};

template <class T>
void fill_rows(Image<T>& image, int begin, int end, T value) {
  std::fill_n(image.row(begin), static_cast<std::size_t>(end - begin) * static_cast<std::size_t>(image.width()), value);
}

void clear_rows(FrameResult& result, int begin, int end) {
  fill_rows(result.elevation_m, begin, end, std::numeric_limits<float>::quiet_NaN());
  fill_rows(result.elevation_sigma_m, begin, end, std::numeric_limits<float>::quiet_NaN());
  fill_rows(result.terrain, begin, end, TerrainClass::unknown);
}

// bound_cell() changes none of sixteen cells without bounds.
bool stay(const CellWitness* witnesses, const float* observed, const float* occupancy) {
  if (!are_alike(witnesses)) return false;
  if (witnesses->allows_free()) return witnesses->kind() != Witness::memory;
  return *witnesses == CellWitness{} &&
         !any_of_group(0, [&](int i) { return (observed[i] < 0.5f) | (occupancy[i] < 0.5f); });
}

}  // namespace

void bound_grids(const GridBounds<Host>& bounds, FrameResult& result) {
  for (int iy{0}; iy < bounds.vehicle.height; ++iy) {
    const float* const age_s{result.vehicle.age_s.row(iy)};
    float* const observed{result.observed.row(iy)};
    float* const occupancy{result.vehicle.occupancy.row(iy)};
    CellWitness* const witness{result.witness.row(iy)};
    for_cells(bounds.vehicle.row(iy), bounds.vehicle.width, [&](int begin, int end, std::uint8_t bits) {
      if (bits == 0 && end - begin == group_cells && stay(witness + begin, observed + begin, occupancy + begin)) return;
      for (int ix{begin}; ix < end; ++ix) bound_cell(bits, age_s[ix], observed[ix], occupancy[ix], witness[ix]);
    });
  }
  for (int iy{0}; iy < bounds.window.height; ++iy) {
    const float* const age_s{result.world.age_s.row(iy)};
    float* const occupancy{result.world.occupancy.row(iy)};
    for_cells(bounds.window.row(iy), bounds.window.width, [&](int begin, int end, std::uint8_t bits) {
      const auto apply = [&](std::uint8_t to_all) {
        for (int ix{begin}; ix < end; ++ix) occupancy[ix] = bounded(occupancy[ix], to_all, age_s[ix]);
      };
      if (bits == 0) return;
      bits == bound_unknown ? apply(bound_unknown) : apply(bits);  // a constant for most cells, as in apply_rules()
    });
  }
}

FrameTerrain::FrameTerrain(const Rig& level_rig, const Config& config, const GridGeometry& vehicle_grid,
                           int window_cells)
    : estimates_ground_{config.ground.estimate},
      vehicle_grid_{vehicle_grid},
      vehicle_{config.vehicle},
      terrain_{level_rig, limits_of(config), rings_of(config), config.matching.disparities},
      low_obstacles_{LowModel{level_rig, limits_of(config), config.grid.cell_size_m, window_cells,
                              config.matching.window_px, config.matching.disparities}},
      witness_{config.vehicle.ground_memory_s, window_cells},
      elevation_{config.grid.cell_size_m, window_cells},
      vehicle_rules_{vehicle_grid.nx, vehicle_grid.ny},
      window_rules_{window_cells, window_cells},
      vehicle_bounds_{vehicle_grid.nx, vehicle_grid.ny},
      window_bounds_{window_cells, window_cells} {
  edges_.reserve(static_cast<std::size_t>(level_rig.width_px / sector_px + 1));
  low_cells_.reserve(low_cells_max);
}

void FrameTerrain::clear_vehicle(int begin, int end, FrameResult& result) {
  clear_rows(result, begin, end);
  fill_rows(vehicle_rules_, begin, end, CellRule::ground_not_seen);
}

void FrameTerrain::write_vehicle(int ix, int iy, const CellGround& ground, FrameResult& result) {
  result.elevation_m(ix, iy) = ground.elevation_m;
  result.elevation_sigma_m(ix, iy) = ground.sigma_m;
  result.terrain(ix, iy) = ground.kind;
  vehicle_rules_(ix, iy) = rule_of(ground.kind);
}

void FrameTerrain::clear_window(int begin, int end) {
  fill_rows(window_rules_, begin, end, CellRule::ground_not_seen);
  for (int iy{begin}; iy < end; ++iy) elevation_.begin_row(iy);
}

void FrameTerrain::write_window(int ix, int iy, const CellGround& ground) {
  window_rules_(ix, iy) = rule_of(ground.kind);
  elevation_.see(ix, iy, ground.elevation_m, ground.sigma_m);
}

void FrameTerrain::set_ground(std::span<const GroundCell> cells, FrameResult& result) {
  clear_vehicle(0, vehicle_grid_.ny, result);
  clear_window(0, place_.window.ny);
  for (const auto& [grid, cell, ground] : cells) {
    if (grid == 0) {
      write_vehicle(cell % vehicle_grid_.nx, cell / vehicle_grid_.nx, ground, result);
    } else {
      write_window(cell % place_.window.nx, cell / place_.window.nx, ground);
    }
  }
}

void FrameTerrain::mark_low_obstacles(std::span<const LowCell> low, FrameResult& result) {
  low_obstacles_.see(low);
  const CellsWithin cells{vehicle_grid_, place_.window_cells};
  low_obstacles_.for_high([&](int x, int y) {
    cells.for_cells(x, y, [&](int ix, int iy) {
      if (mark_obstacle(vehicle_rules_(ix, iy))) result.terrain(ix, iy) = TerrainClass::obstacle;
    });
  });
}

void FrameTerrain::move(const TerrainPlace& place) {
  place_ = place;
  GridGeometry before{place.window};
  before.x_min_m = std::exchange(window_x_m_, place.window.x_min_m);
  before.y_min_m = std::exchange(window_y_m_, place.window.y_min_m);
  const Scroll scroll{scroll_between(before, place.window)};
  low_obstacles_.move(scroll);
  witness_.move(scroll, place.dt_s);
  elevation_.move(scroll);
}

void FrameTerrain::find_nothing(const TerrainPlace& place) {
  move(place);
  low_obstacles_.see({});
  edges_.clear();
  vehicle_rules_.fill(CellRule::ground_not_seen);
  clear_window(0, window_rules_.height());
}

void FrameTerrain::merge(std::span<const FrameTerrain* const> seen) {
  if (std::ranges::find(seen, this) == seen.end()) {
    vehicle_rules_.fill(CellRule::ground_not_seen);
    window_rules_.fill(CellRule::ground_not_seen);
  }
  const auto add = [](const Image<CellRule>& from, Image<CellRule>& to) {
    std::ranges::transform(from, to, to.begin(), [](CellRule one, CellRule other) { return combined(other, one); });
  };
  for (const FrameTerrain* const other : seen) {
    if (other == this) continue;
    add(other->vehicle_rules_, vehicle_rules_);
    add(other->window_rules_, window_rules_);
  }
}

void FrameTerrain::bound_cells(std::span<const FrameTerrain* const> seen,
                               const std::function<bool(Point2)>& claims_free, FrameResult& result) {
  const bool is_usable{!seen.empty()};
  find_witnesses(is_usable, claims_free, result);
  if (is_usable) see_ground(seen);
  if (claims_free) see_claims(is_usable, claims_free);
  std::ranges::transform(vehicle_rules_, vehicle_bounds_.begin(),
                         [is_usable](CellRule rule) { return is_usable ? bound_of(rule) : std::uint8_t{0}; });
  witness_.bound(window_bounds_);
  add_hazards(seen);
}

void FrameTerrain::remember_elevation(std::span<const FrameTerrain* const> seen, FrameResult& result) {
  const bool is_own_seen{std::ranges::find(seen, this) != seen.end()};
  for (int iy{0}; iy < window_rules_.height() && !is_own_seen; ++iy) elevation_.begin_row(iy);
  for (const FrameTerrain* const other : seen) {
    if (other != this) elevation_.see(other->elevation_);
  }
  if (!seen.empty()) elevation_.add();
  elevation_.write(result.world_elevation_m, result.world_elevation_sigma_m);
}

// Stopping takes v·t + v²/(2a). The age of the camera's last frame is a part of t.
void FrameTerrain::limit_speed(bool is_usable, double since_s, FrameResult& result) {
  age_s_ = is_usable ? 0 : age_s_ + since_s;
  const TerrainCamera& camera{terrain_.camera()};
  const double step_m{vehicle_.step_max_m};
  struct Range {
    double end_m;
    SpeedReason reason;
  };
  Range range{std::min(
      {Range{terrain_.checked_m(), SpeedReason::noise},
       Range{std::sqrt(camera.focal_px * crossed_ditch * step_m * camera.height_m / ditch_rows), SpeedReason::ditches},
       Range{camera.focal_baseline_pxm * step_m / (found_drops * camera.height_m + step_m), SpeedReason::drops},
       Range{camera.height_m / std::tan(vehicle_.drop_slope_deg * std::numbers::pi / 180), SpeedReason::descents}},
      [](const Range& a, const Range& b) { return a.end_m < b.end_m; })};
  const bool is_known{!std::isinf(age_s_)};
  if (!is_known) range = {0, SpeedReason::frame};
  const double reaction_mps{vehicle_.deceleration_mps2 * (vehicle_.reaction_s + (is_known ? age_s_ : 0))};
  result.speed_limit_mps =
      std::sqrt(reaction_mps * reaction_mps + 2 * vehicle_.deceleration_mps2 * range.end_m) - reaction_mps;
  result.speed_limit_reason = range.reason;
}

// Cells without ground keep their edge. Hidden cells do not: some of them are seen to be ground from nearer by.
void FrameTerrain::drop_witnesses(int begin, int end) {
  for (int iy{begin}; iy < end; ++iy) {
    for_cells(window_rules_.row(iy), window_rules_.width(), [&](int first, int last, CellRule rule) {
      if (rule == CellRule::ground_not_seen) return;
      if (rule == CellRule::as_observed) return witness_.drop_edges(iy, first, last);
      rule == CellRule::edge ? witness_.see_edge(iy, first, last) : witness_.drop(iy, first, last);
    });
  }
}

// From afar the matcher's window smears ground over a pit without texture. A frame that is nearer by a cell and that
// would see ground there, but does not, ends the memory of it.
void FrameTerrain::drop_unconfirmed(std::span<const FrameTerrain* const> seen, int begin, int end) {
  const auto cell_m = static_cast<float>(place_.window.cell_size_m);
  witness_.for_seen(begin, end, [&](int ix, int iy) {
    if (window_rules_(ix, iy) != CellRule::ground_not_seen || distance_to(ix, iy) + cell_m > witness_.from_m(ix, iy))
      return;
    if (std::ranges::any_of(seen, [&](const FrameTerrain* one) {
          return one->terrain_.sees_no_ground_at(one->place_.window_in_camera.centre(ix, iy), cell_m / 2);
        }))
      witness_.drop(iy, ix, ix + 1);
  });
}

float FrameTerrain::distance_to(int ix, int iy) const {
  const Point2 at{place_.window_cells.centre(ix, iy)};
  return static_cast<float>(std::sqrt(at.x * at.x + at.y * at.y));
}

// Rules of the window are without low obstacles. Behind a crest, stones pass for ground of a plane that is not
// measured.
void FrameTerrain::see_ground(std::span<const FrameTerrain* const> seen) {
  for (const FrameTerrain* const one : seen) {
    for (int iy{0}; iy < window_rules_.height() && one->is_measured_; ++iy) {
      for_cells(one->window_rules_.row(iy), window_rules_.width(), [&](int begin, int end, CellRule rule) {
        if (rule != CellRule::as_observed) return;
        for (int ix{begin}; ix < end; ++ix) {
          if (window_rules_(ix, iy) == CellRule::as_observed) witness_.see(ix, iy, distance_to(ix, iy));
        }
      });
    }
  }
  for (const FrameTerrain* const one : seen) {
    one->low_obstacles_.for_high([&](int x, int y) {
      if (!witness_.is_edge(x, y)) witness_.drop(y, x, x + 1);
    });
  }
}

// Cells below ½ have a witness. Without branches, for vectors.
void FrameTerrain::classify(FrameResult& result) const {
  std::ranges::transform(result.world.occupancy, result.world_terrain.begin(), [](float p) {
    return static_cast<TerrainClass>(static_cast<int>(p >= ruled_obstacle) * static_cast<int>(TerrainClass::obstacle) +
                                     static_cast<int>(p < 0.5f) * static_cast<int>(TerrainClass::drivable));
  });
  witness_.for_edges([&](int ix, int iy) { result.world_terrain(ix, iy) = TerrainClass::drop; });
}

// Edges, obstacles and hidden ground are no claim's. Cameras that see nothing contradict none.
void FrameTerrain::see_claims(bool is_usable, const std::function<bool(Point2)>& claims_free) {
  for (int iy{0}; iy < window_rules_.height(); ++iy) {
    for (int ix{0}; ix < window_rules_.width(); ++ix) {
      const CellRule rule{is_usable ? window_rules_(ix, iy) : CellRule::ground_not_seen};
      if (witness_.is_edge(ix, iy) || (rule != CellRule::ground_not_seen && rule != CellRule::as_observed)) continue;
      if (claims_free(place_.window_cells.centre(ix, iy))) witness_.see(ix, iy, 0);
    }
  }
}

void FrameTerrain::find_witnesses(bool is_usable, const std::function<bool(Point2)>& claims_free,
                                  FrameResult& result) const {
  const GridGeometry& window{place_.window};
  const CellPlaces places{
      grid_in_vehicle(vehicle_grid_, place_.world_from_vehicle), {window.x_min_m, window.y_min_m}, window.cell_size_m};
  for (int iy{0}; iy < vehicle_grid_.ny; ++iy) {
    CellWitness* const witnesses{result.witness.row(iy)};
    for_cells(vehicle_rules_.row(iy), vehicle_grid_.nx, [&](int begin, int end, CellRule rule) {
      if (!is_usable) rule = CellRule::ground_not_seen;
      const bool is_seen{rule == CellRule::as_observed};
      std::fill(witnesses + begin, witnesses + end, is_seen ? CellWitness::of(Witness::ground) : CellWitness{});
      if (rule == CellRule::ground_not_seen) {
        int x[group_cells];  // cells of the window, in a loop of their own, which becomes vectors
        int y[group_cells];
        for (int i{0}; i < end - begin; ++i) {
          x[i] = static_cast<int>(places.x_of(begin + i, iy));
          y[i] = static_cast<int>(places.y_of(begin + i, iy));
        }
        for (int i{0}; i < end - begin; ++i) {
          if (witness_.has(x[i], y[i]))  // by an earlier frame
            witnesses[begin + i] = CellWitness::of(Witness::memory, witness_.age_s(x[i], y[i]));
        }
      }
      if (!claims_free || is_seen) return;
      for (int ix{begin}; ix < end; ++ix)
        if (claims_free(vehicle_grid_.centre(ix, iy))) witnesses[ix] = CellWitness::of(Witness::source);
    });
  }
}

// Edges and low obstacles are few: each one bounds its cell and the cells of the vehicle's grid whose centres lie in
// it.
auto FrameTerrain::hazard() {
  return [this, cells = CellsWithin{vehicle_grid_, place_.window_cells}](int x, int y) {
    window_bounds_(x, y) |= bound_hazard;
    cells.for_cells(x, y, [&](int ix, int iy) { vehicle_bounds_(ix, iy) |= bound_hazard; });
  };
}

void FrameTerrain::add_hazards(std::span<const FrameTerrain* const> seen) {
  for (const FrameTerrain* const one : seen) low_obstacles_.remember(one->low_obstacles_);
  const auto add = hazard();
  witness_.for_edges(add);
  low_cells_.clear();
  low_obstacles_.memory().for_obstacles([&](int x, int y, const HeightMemory::Mean& mean) {
    add(x, y);
    if (!mean.is_sure || low_cells_.size() == low_cells_max) return;
    low_cells_.push_back({x, y, low_obstacles_.height_m(mean.height), mean.frames, false});
  });
  const auto place_of = [](const LowObstacleCell& cell) { return std::pair{cell.iy, cell.ix}; };
  const auto see = [&](int x, int y) {
    if ((window_bounds_(x, y) & bound_hazard) == 0) return;
    const auto at{std::ranges::lower_bound(low_cells_, std::pair{y, x}, {}, place_of)};
    if (at != low_cells_.end() && at->ix == x && at->iy == y) at->is_seen = true;
  };
  for (const FrameTerrain* const one : seen) {
    one->low_obstacles_.for_high(add);
    one->low_obstacles_.for_seen(see);
  }
}

GridBounds<Host> FrameTerrain::add_bars(std::span<const FrameTerrain* const> seen, View<const float> filtered) {
  for (const FrameTerrain* const one : seen) low_obstacles_.remember_bars(one->low_obstacles_, filtered);
  low_obstacles_.memory().for_bars(hazard());
  return {std::as_const(vehicle_bounds_).view(), std::as_const(window_bounds_).view()};
}

void FrameTerrain::clear(FrameResult& result) {
  clear_rows(result, 0, result.terrain.height());
}

}  // namespace stereogrid
