// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "render/render.hpp"
#include "truth/truth.hpp"

namespace stereogrid::scenes {
namespace {

constexpr double smallest_overlap_m2{1e-9};

/// A world point in the vehicle frame, seen from above.
Point2 from_above(const Frame3& vehicle, Vector3 world) {
  const Vector3 local{vehicle.into(world)};
  return {local.x, local.y};
}

/// Calls visit(ix, iy, overlap in m²) for every cell that a polygon of the vehicle frame overlaps.
template <class Visit>
void for_cells_under(const Polygon& polygon, const GridGeometry& grid, Visit visit) {
  if (polygon.empty()) return;
  Point2 low{polygon.front()};
  Point2 high{polygon.front()};
  for (const Point2 p : polygon) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
  const double s{grid.cell_size_m};
  const auto cell = [s](double offset, int cells) {
    return static_cast<int>(std::clamp(std::floor(offset / s), -1.0, static_cast<double>(cells)));
  };
  const int last_x{std::min(cell(high.x - grid.x_min_m, grid.nx), grid.nx - 1)};
  const int last_y{std::min(cell(high.y - grid.y_min_m, grid.ny), grid.ny - 1)};
  for (int iy{std::max(cell(low.y - grid.y_min_m, grid.ny), 0)}; iy <= last_y; ++iy) {
    for (int ix{std::max(cell(low.x - grid.x_min_m, grid.nx), 0)}; ix <= last_x; ++ix) {
      const Point2 corner{grid.x_min_m + ix * s, grid.y_min_m + iy * s};
      const double overlap{area_within(polygon, corner, {corner.x + s, corner.y + s})};
      if (overlap > smallest_overlap_m2) visit(ix, iy, overlap);
    }
  }
}

Polygon into_vehicle(const Moment& moment, Polygon polygon) {
  for (Point2& p : polygon) {
    p = from_above(moment.vehicle, {p.x, p.y, moment.world.ground.height_at(p.x, p.y)});
  }
  return polygon;
}

void fill_footprints(const Moment& moment, const TruthGrid& grid, FrameTruth& truth) {
  Image<double> largest{grid.geometry.nx, grid.geometry.ny};
  for (const TruthObject& object : truth.objects) {
    for_cells_under(into_vehicle(moment, object.footprint), grid.geometry, [&](int ix, int iy, double overlap) {
      truth.occupied(ix, iy) = 1;
      if (overlap <= largest(ix, iy)) return;
      largest(ix, iy) = overlap;
      truth.owner(ix, iy) = static_cast<std::int32_t>(object.id);
    });
  }
}

struct LowPart {
  const PlacedPart* placed;
  double top_m;
};

std::vector<LowPart> low_parts(const std::vector<PlacedPart>& parts) {
  std::vector<LowPart> low;
  for (const PlacedPart& placed : parts) {
    if (placed.body->label == TruthLabel::low) low.push_back({&placed, placed.centre.z + placed.part->solid.half.z});
  }
  return low;
}

void fill_low(const std::vector<LowPart>& low, const Moment& moment, const TruthGrid& grid, FrameTruth& truth) {
  for (const LowPart& part : low) {
    Polygon polygon{outline(part.placed->part->solid, -1e9, 1e9)};
    const Direction heading{part.placed->heading};
    for (Point2& p : polygon) {
      p = {part.placed->centre.x + heading.cosine * p.x - heading.sine * p.y,
           part.placed->centre.y + heading.sine * p.x + heading.cosine * p.y};
    }
    for_cells_under(into_vehicle(moment, std::move(polygon)), grid.geometry,
                    [&](int ix, int iy, double) { truth.low(ix, iy) = 1; });
  }
}

double ground_height(const std::vector<LowPart>& low, const HeightField& ground, Vector3 world) {
  double height{ground.height_at(world.x, world.y)};
  for (const LowPart& part : low) {
    const Vector3 centre{part.placed->centre};
    const Vector3 half{part.placed->part->solid.half};
    const Vector3 local{turned_into(*part.placed, {world.x - centre.x, world.y - centre.y, 0})};
    if (std::abs(local.x) <= half.x && std::abs(local.y) <= half.y) height = std::max(height, part.top_m);
  }
  return height;
}

/// Number of the cell's 3 × 3 ground points that a left camera sees.
int seen_ground_points(const Moment& moment, const std::vector<LowPart>& low, Point2 corner, double cell_size_m) {
  int seen{0};
  for (int i{0}; i < 9; ++i) {
    const double x{corner.x + cell_size_m * (2 * (i % 3) + 1) / 6};
    const double y{corner.y + cell_size_m * (2 * (i / 3) + 1) / 6};
    const Vector3 world{on_ground(moment, {x, y})};
    if (in_view(moment, {world.x, world.y, ground_height(low, moment.world.ground, world)})) ++seen;
  }
  return seen;
}

void fill_free_points(const Moment& moment, const std::vector<LowPart>& low, const TruthGrid& grid, FrameTruth& truth) {
  const GridGeometry& g{grid.geometry};
  for_rows(g.ny, [&](int iy) {
    for (int ix{0}; ix < g.nx; ++ix) {
      const Point2 corner{g.x_min_m + ix * g.cell_size_m, g.y_min_m + iy * g.cell_size_m};
      truth.free_points(ix, iy) = static_cast<std::uint8_t>(seen_ground_points(moment, low, corner, g.cell_size_m));
    }
  });
}

/// Surface point of a hit, slightly inside its body, so that a face on a cell's border counts for the cell behind it.
Vector3 surface_point(const Moment& moment, const Caster& caster, const Hit& hit, int u, int v) {
  constexpr double hair_m{1e-4};
  const PlacedPart& placed{moment.parts[static_cast<std::size_t>(hit.part)]};
  const Direction heading{placed.heading};
  const Vector3 normal{heading.cosine * hit.normal.x - heading.sine * hit.normal.y,
                       heading.sine * hit.normal.x + heading.cosine * hit.normal.y, hit.normal.z};
  const Camera& camera{caster.camera()};
  return camera.position + hit.depth * camera.ray(u, v) - hair_m * normal;
}

using Votes = std::map<std::int32_t, std::int32_t>;

/// Counts a camera's pixels of obstacles by cell and object.
void count_pixels(const Moment& moment, const Caster& caster, const TruthGrid& grid, std::vector<Votes>& votes) {
  const GridGeometry& g{grid.geometry};
  for (int v{0}; v < caster.camera().height_px; ++v) {
    for (int u{0}; u < caster.camera().width_px; ++u) {
      const Hit hit{caster.trace(u, v)};
      if (hit.part < 0) continue;
      const Body& body{*moment.parts[static_cast<std::size_t>(hit.part)].body};
      if (body.label != TruthLabel::obstacle) continue;
      const Vector3 point{surface_point(moment, caster, hit, u, v)};
      const double height_m{point.z - moment.world.ground.height_at(point.x, point.y)};
      if (height_m < grid.height_min_m || height_m > grid.height_max_m) continue;
      const Point2 at{from_above(moment.vehicle, point)};
      const double ix{std::floor((at.x - g.x_min_m) / g.cell_size_m)};
      const double iy{std::floor((at.y - g.y_min_m) / g.cell_size_m)};
      if (ix < 0 || iy < 0 || ix >= g.nx || iy >= g.ny) continue;
      ++votes[static_cast<std::size_t>(iy) * static_cast<std::size_t>(g.nx) + static_cast<std::size_t>(ix)][body.id];
    }
  }
}

/// Pixels of obstacles of all left cameras by cell and object.
std::vector<Votes> count_pixels(const Moment& moment, const TruthGrid& grid) {
  std::vector<Votes> votes(static_cast<std::size_t>(grid.geometry.nx) * static_cast<std::size_t>(grid.geometry.ny));
  count_pixels(moment, moment.left, grid, votes);
  for (const Caster* const other : moment.other_lefts) count_pixels(moment, *other, grid, votes);
  return votes;
}

void fill_seen(const std::vector<Votes>& votes, FrameTruth& truth) {
  for (std::size_t i{0}; i < votes.size(); ++i) {
    const auto most = std::max_element(votes[i].begin(), votes[i].end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
    if (most == votes[i].end()) continue;
    for (const auto& [id, count] : votes[i]) truth.pixels.data()[i] += count;
    truth.seen_object.data()[i] = most->first;
    truth.owner.data()[i] = most->first;  // the object with most seen pixels owns the cell
    truth.occupied.data()[i] = 1;
  }
}

void conclude(FrameTruth& truth) {
  for (std::size_t i{0}; i < truth.state.size(); ++i) {
    TruthCell state{TruthCell::hidden};
    if (truth.pixels.data()[i] > 0) {
      state = TruthCell::seen_occupied;
    } else if (truth.occupied.data()[i] == 0 && truth.free_points.data()[i] >= 5) {
      state = TruthCell::seen_free;
    }
    truth.state.data()[i] = static_cast<std::uint8_t>(state);
    if (truth.owner.data()[i] == 0) continue;
    const TruthObject& owner{truth.objects[static_cast<std::size_t>(truth.owner.data()[i]) - 1]};
    truth.velocity_x.data()[i] = static_cast<float>(owner.vx_mps);
    truth.velocity_y.data()[i] = static_cast<float>(owner.vy_mps);
  }
}

}  // namespace

Vector3 on_ground(const Moment& moment, Point2 place) {
  constexpr int steps{12};  // each divides the error by the cotangent of tilt times slope
  const HeightField& ground{moment.world.ground};
  Vector3 local{place.x, place.y, 0};
  Vector3 world{moment.vehicle.back(local)};
  if (ground.is_flat()) return world;
  for (int i{0}; i < steps; ++i) {
    const double above_m{world.z - ground.height_at(world.x, world.y)};
    if (above_m == 0) break;
    local.z -= above_m / moment.vehicle.up.z;
    world = moment.vehicle.back(local);
  }
  return world;
}

void fill_cells(const Moment& moment, const TruthGrid& grid, FrameTruth& truth) {
  const int nx{grid.geometry.nx};
  const int ny{grid.geometry.ny};
  truth.state = {nx, ny};
  truth.occupied = {nx, ny};
  truth.owner = {nx, ny};
  truth.pixels = {nx, ny};
  truth.seen_object = {nx, ny};
  truth.free_points = {nx, ny};
  truth.low = {nx, ny};
  truth.velocity_x = {nx, ny};
  truth.velocity_y = {nx, ny};
  const std::vector<LowPart> low{low_parts(moment.parts)};
  fill_footprints(moment, grid, truth);
  fill_low(low, moment, grid, truth);
  fill_free_points(moment, low, grid, truth);
  fill_seen(count_pixels(moment, grid), truth);
  conclude(truth);
}

}  // namespace stereogrid::scenes
