// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "render/render.hpp"
#include "truth/truth.hpp"

namespace stereogrid::scenes {
namespace {

constexpr double slope_max{0.36397};  // tan 20°
constexpr int per_cell{3};            ///< samples of a cell in each direction
constexpr CellIndex neighbours[]{{1, 0}, {-1, 0}, {0, 1}, {0, -1}};

enum class Mark : std::uint8_t { none, drop, rise };

/// Ground of a grid at 3 × 3 samples per cell: heights, bodies, visible and reached samples.
class Samples {
 public:
  Samples(const Moment& moment, const TruthGrid& grid);

  [[nodiscard]] bool contains(CellIndex at) const {
    return at.ix >= 0 && at.iy >= 0 && at.ix < height_m.width() && at.iy < height_m.height();
  }
  [[nodiscard]] bool is_reached(CellIndex at) const { return reached(at.ix, at.iy) != 0; }
  [[nodiscard]] double height(CellIndex at) const { return height_m(at.ix, at.iy); }
  /// Step from a sample that is reached to its neighbour that is not. `step_m`: up or down.
  [[nodiscard]] Mark between(CellIndex from, CellIndex to, double& step_m) const;

  Image<double> height_m;  ///< over the vehicle frame's plane
  Image<std::uint8_t> blocked;
  Image<std::uint8_t> seen;
  Image<std::uint8_t> reached;

 private:
  void fill_row(const Moment& moment, const TruthGrid& grid, int iy);
  void reach(const Moment& moment);
  [[nodiscard]] bool is_passable(CellIndex from, CellIndex to) const;
  [[nodiscard]] bool is_steep(CellIndex at) const;
  [[nodiscard]] double slope(CellIndex at, CellIndex along) const;

  double spacing_m_;
  double step_max_m_;
};

/// True if a body stands there, between the step that a vehicle climbs and its height.
bool is_blocked(const Moment& moment, const TruthGrid& grid, Vector3 ground) {
  return std::ranges::any_of(moment.parts, [&](const PlacedPart& placed) {
    if (placed.body->label != TruthLabel::obstacle) return false;
    const Vector3 local{turned_into(placed, ground - placed.centre)};
    Column column;
    if (!column_at(placed.part->solid, local.x, local.y, column)) return false;
    return column.high - local.z > grid.height_min_m && column.low - local.z < grid.height_max_m;
  });
}

Samples::Samples(const Moment& moment, const TruthGrid& grid)
    : height_m{per_cell * grid.geometry.nx, per_cell * grid.geometry.ny},
      blocked{height_m.width(), height_m.height()},
      seen{height_m.width(), height_m.height()},
      reached{height_m.width(), height_m.height()},
      spacing_m_{grid.geometry.cell_size_m / per_cell},
      step_max_m_{grid.height_min_m} {
  for_rows(height_m.height(), [&](int iy) { fill_row(moment, grid, iy); });
  reach(moment);
}

void Samples::fill_row(const Moment& moment, const TruthGrid& grid, int iy) {
  for (int ix{0}; ix < height_m.width(); ++ix) {
    const Point2 place{grid.geometry.x_min_m + (ix + 0.5) * spacing_m_,
                       grid.geometry.y_min_m + (iy + 0.5) * spacing_m_};
    const Vector3 world{on_ground(moment, place)};
    height_m(ix, iy) = moment.vehicle.into(world).z;
    blocked(ix, iy) = is_blocked(moment, grid, world) ? 1 : 0;
    seen(ix, iy) = in_view(moment, world) ? 1 : 0;
  }
}

/// Slope over a cell along an axis, where the ground rises or falls on both sides of a sample; 0: it does not.
double Samples::slope(CellIndex at, CellIndex along) const {
  const CellIndex next{at.ix + per_cell * along.ix, at.iy + per_cell * along.iy};
  const CellIndex last{at.ix - per_cell * along.ix, at.iy - per_cell * along.iy};
  if (!contains(next) || !contains(last)) return 0;
  const double ahead{height(next) - height(at)};
  const double behind{height(at) - height(last)};
  return ahead * behind > 0 ? std::min(std::abs(ahead), std::abs(behind)) / (per_cell * spacing_m_) : 0;
}

bool Samples::is_steep(CellIndex at) const {
  const double x{slope(at, {1, 0})};
  const double y{slope(at, {0, 1})};
  return x * x + y * y > slope_max * slope_max;
}

bool Samples::is_passable(CellIndex from, CellIndex to) const {
  return std::abs(height(to) - height(from)) <= step_max_m_ + slope_max * spacing_m_ && blocked(to.ix, to.iy) == 0 &&
         !is_steep(to);
}

/// Floods from below the vehicle.
void Samples::reach(const Moment& moment) {
  constexpr int seeds{2 * per_cell};
  const double track_m{moment.world.wheels.half_track_m};
  std::vector<CellIndex> front;
  for (int iy{0}; iy < height_m.height(); ++iy) {
    const double y{(iy + 0.5 - height_m.height() / 2.0) * spacing_m_};
    for (int ix{0}; ix < seeds && std::abs(y) < track_m; ++ix) {
      if (blocked(ix, iy) != 0) continue;
      reached(ix, iy) = 1;
      front.push_back({ix, iy});
    }
  }
  while (!front.empty()) {
    const CellIndex from{front.back()};
    front.pop_back();
    for (const CellIndex step : neighbours) {
      const CellIndex to{from.ix + step.ix, from.iy + step.iy};
      if (!contains(to) || is_reached(to) || !is_passable(from, to)) continue;
      reached(to.ix, to.iy) = 1;
      front.push_back(to);
    }
  }
}

Mark Samples::between(CellIndex from, CellIndex to, double& step_m) const {
  step_m = height(to) - height(from);
  if (blocked(to.ix, to.iy) != 0) return Mark::rise;
  if (std::abs(step_m) > step_max_m_) return step_m < 0 ? Mark::drop : Mark::rise;
  // too steep: the way on from there decides
  CellIndex on{to};
  for (int i{0}; i < per_cell; ++i) {
    const CellIndex next{on.ix + to.ix - from.ix, on.iy + to.iy - from.iy};
    if (contains(next)) on = next;
  }
  step_m = height(on) - height(from);
  return step_m < 0 ? Mark::drop : Mark::rise;
}

/// Edges and steps that bound the reached ground, if they are seen and face the vehicle.
struct Boundary {
  Image<std::uint8_t> mark;
  Image<float> step_m;
};

/// True if the ground that ends at a sample in a direction is seen. A slope that is too steep begins up to a cell
/// before.
bool is_rim_seen(const Samples& samples, CellIndex at, CellIndex direction) {
  for (int i{0}; i <= per_cell; ++i) {
    const CellIndex before{at.ix - i * direction.ix, at.iy - i * direction.iy};
    if (!samples.contains(before) || !samples.is_reached(before)) return false;
    if (samples.seen(before.ix, before.iy) != 0) return true;
  }
  return false;
}

/// True if the line of sight crosses a line at a sample, in the direction of its normal, at 15° or more. Edges along
/// the line of sight are hardly visible in the image.
bool is_faced(const Samples& samples, CellIndex at, CellIndex normal) {
  constexpr double sine_min{0.26};
  const double x{at.ix + 0.5};
  const double y{at.iy + 0.5 - samples.height_m.height() / 2.0};
  return normal.ix * x + normal.iy * y > sine_min * std::sqrt(x * x + y * y);
}

Boundary boundary_of(const Samples& samples) {
  Boundary boundary{{samples.height_m.width(), samples.height_m.height()},
                    {samples.height_m.width(), samples.height_m.height()}};
  for (int iy{0}; iy < samples.height_m.height(); ++iy) {
    for (int ix{0}; ix < samples.height_m.width(); ++ix) {
      if (samples.reached(ix, iy) == 0) continue;
      for (const CellIndex step : neighbours) {
        const CellIndex to{ix + step.ix, iy + step.iy};
        if (!samples.contains(to) || samples.is_reached(to) || samples.blocked(to.ix, to.iy) != 0) continue;
        if (!is_faced(samples, {ix, iy}, step)) continue;
        double step_m{0};
        const Mark mark{samples.between({ix, iy}, to, step_m)};
        if (!is_rim_seen(samples, {ix, iy}, step) && (mark == Mark::drop || samples.seen(to.ix, to.iy) == 0)) continue;
        boundary.mark(to.ix, to.iy) = static_cast<std::uint8_t>(mark);
        boundary.step_m(to.ix, to.iy) = static_cast<float>(step_m);
      }
    }
  }
  return boundary;
}

/// True if a drop bounds the reached ground on the way from the vehicle to an unreached sample.
bool is_behind_a_drop(const Samples& samples, CellIndex to) {
  const CellIndex start{0, samples.height_m.height() / 2};
  const int steps{2 * std::max(std::abs(to.ix - start.ix), std::abs(to.iy - start.iy))};
  const auto on_the_way = [&](int step) {
    const double share{static_cast<double>(step) / steps};
    return CellIndex{static_cast<int>(start.ix + share * (to.ix - start.ix) + 0.5),
                     static_cast<int>(start.iy + share * (to.iy - start.iy) + 0.5)};
  };
  for (int step{steps}; step > 0; --step) {
    const CellIndex from{on_the_way(step - 1)};
    if (!samples.is_reached(from)) continue;
    double ignored{0};
    return samples.between(from, on_the_way(step), ignored) == Mark::drop;
  }
  return false;
}

struct CellCounts {
  int reached{0};
  int seen{0};
  int drops{0};
  int rises{0};
  float step_m{0};  ///< the largest one
};

CellCounts count(const Samples& samples, const Boundary& boundary, int cell_x, int cell_y) {
  CellCounts counts;
  for (int iy{per_cell * cell_y}; iy < per_cell * (cell_y + 1); ++iy) {
    for (int ix{per_cell * cell_x}; ix < per_cell * (cell_x + 1); ++ix) {
      counts.reached += samples.reached(ix, iy);
      counts.seen += samples.seen(ix, iy);
      counts.drops += boundary.mark(ix, iy) == static_cast<std::uint8_t>(Mark::drop) ? 1 : 0;
      counts.rises += boundary.mark(ix, iy) == static_cast<std::uint8_t>(Mark::rise) ? 1 : 0;
      const float step_m{boundary.step_m(ix, iy)};
      if (std::abs(step_m) > std::abs(counts.step_m)) counts.step_m = step_m;
    }
  }
  return counts;
}

/// True if a place of the vehicle frame is in the columns of an image.
bool is_in_columns(const Moment& moment, Point2 place) {
  const Vector3 point{on_ground(moment, place)};
  const auto has = [point](const Camera& camera) {
    const Projection at{project(camera, point)};
    return at.depth > 0 && at.u >= 0 && at.u <= camera.width_px - 1;
  };
  return has(moment.left.camera()) ||
         std::ranges::any_of(moment.other_lefts, [&](const Caster* caster) { return has(caster->camera()); });
}

TerrainCell class_of(const CellCounts& counts, bool has_pixels) {
  constexpr int all{per_cell * per_cell};
  if (has_pixels) return TerrainCell::obstacle;
  if (counts.drops > 0) return TerrainCell::drop;
  if (counts.rises > 0) return TerrainCell::obstacle;
  return counts.reached == all && 2 * counts.seen > all ? TerrainCell::drivable : TerrainCell::hidden;
}

TruthCell state_of(TerrainCell cell) {
  if (cell == TerrainCell::drivable) return TruthCell::seen_free;
  return cell == TerrainCell::obstacle || cell == TerrainCell::drop ? TruthCell::seen_occupied : TruthCell::hidden;
}

}  // namespace

void fill_terrain(const Moment& moment, const TruthGrid& grid, FrameTruth& truth) {
  const Samples samples{moment, grid};
  const Boundary boundary{boundary_of(samples)};
  const GridGeometry& g{grid.geometry};
  truth.terrain = {g.nx, g.ny};
  truth.elevation_m = {g.nx, g.ny};
  truth.step_m = {g.nx, g.ny};
  for (int iy{0}; iy < g.ny; ++iy) {
    for (int ix{0}; ix < g.nx; ++ix) {
      const CellIndex centre{per_cell * ix + 1, per_cell * iy + 1};
      const CellCounts counts{count(samples, boundary, ix, iy)};
      TerrainCell cell{class_of(counts, truth.pixels(ix, iy) > 0)};
      const bool is_open{!samples.is_reached(centre) && samples.blocked(centre.ix, centre.iy) == 0};
      if (cell == TerrainCell::hidden && is_open && is_in_columns(moment, g.centre(ix, iy)) &&
          is_behind_a_drop(samples, centre)) {
        cell = TerrainCell::beyond;
      }
      truth.terrain(ix, iy) = static_cast<std::uint8_t>(cell);
      truth.elevation_m(ix, iy) = static_cast<float>(samples.height(centre));
      truth.step_m(ix, iy) = counts.step_m;
      truth.state(ix, iy) = static_cast<std::uint8_t>(state_of(cell));
    }
  }
}

}  // namespace stereogrid::scenes
