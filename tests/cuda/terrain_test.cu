// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <span>
#include <vector>

#include "check.hpp"
#include "geometry/road_plane.hpp"
#include "images.hpp"
#include "terrain/cuda.hpp"
#include "terrain/low_obstacles.hpp"
#include "terrain/relief.hpp"

namespace stereogrid::test {
namespace {

struct Surfaces {
  Image<float> obstacle;
  Image<float> road;
};

// A noisy plane with stones, tall objects, holes and wrong matches.
Surfaces stony_plane(const Rig& rig, const Ground& ground, Random& random) {
  Surfaces view{{rig.width_px, rig.height_px}, {rig.width_px, rig.height_px}};
  const RoadPlane plane{road_plane(rig, ground)};
  for (int v{0}; v < rig.height_px; ++v) {
    for (int u{0}; u < rig.width_px; ++u) {
      const double d{plane.disparity(u, v) + random.between(-0.1, 0.1)};
      if (d > 0.3 && random.happens(0.85)) view.road(u, v) = static_cast<float>(d);
      if (random.happens(0.01)) view.obstacle(u, v) = static_cast<float>(random.between(0.1, 90));
    }
  }
  for (int object{0}; object < 40; ++object) {
    const int first_u{random.whole(-5, rig.width_px)};
    const int foot_v{random.whole(rig.height_px / 4, rig.height_px)};
    const int rows{random.whole(1, object % 8 == 0 ? 60 : 10)};
    const double d{plane.disparity(first_u, foot_v) + random.between(0, 1)};
    if (d <= 0) continue;
    const int end_u{std::min(first_u + random.whole(2, 30), rig.width_px)};
    for (int v{std::max(foot_v - rows, 0)}; v < std::min(foot_v, rig.height_px); ++v) {
      for (int u{std::max(first_u, 0)}; u < end_u; ++u) {
        view.road(u, v) = 0;
        view.obstacle(u, v) = static_cast<float>(d);
      }
    }
  }
  return view;
}

bool is_before(const LowCell& a, const LowCell& b) {
  return a.iy != b.iy ? a.iy < b.iy : a.ix < b.ix;
}

std::vector<LowCell> by_place(std::span<const LowCell> cells) {
  std::vector<LowCell> sorted{cells.begin(), cells.end()};
  std::sort(sorted.begin(), sorted.end(), is_before);
  return sorted;
}

bool is_same(const LowCell& a, const LowCell& b) {
  return a.ix == b.ix && a.iy == b.iy && a.height == b.height && a.noise_m == b.noise_m && a.count == b.count &&
         a.is_high == b.is_high && a.is_tall == b.is_tall && a.is_beside_tall == b.is_beside_tall;
}

struct Found {
  std::ptrdiff_t cells{0};
  std::ptrdiff_t high{0};
  std::ptrdiff_t beside_tall{0};

  void add(std::span<const LowCell> more) {
    cells += static_cast<std::ptrdiff_t>(more.size());
    high += std::count_if(more.begin(), more.end(), [](const LowCell& one) { return one.is_high; });
    beside_tall += std::count_if(more.begin(), more.end(), [](const LowCell& one) { return one.is_beside_tall; });
  }
};

TEST(low_obstacles_are_those_of_the_cpu) {
  Random random{41};
  Found all;
  for (int round{0}; round < 30; ++round) {
    const int width{round == 0 ? 1 : random.whole(40, 250)};
    const int height{random.whole(20, 120)};
    const int disparities{random.whole(2, 96)};
    const int window_cells{random.whole(20, 90)};
    const double cell_m{round % 3 == 0 ? 0.2 : random.between(0.05, 0.5)};
    const Rig rig{width, height, random.between(80, 300), width / 2.0, random.between(0, 0.4 * height), 0.3};
    const Ground ground{random.between(0.3, 1.8), random.between(-0.05, 0.1), random.between(-0.1, 0.1)};
    const double step_m{random.between(0.03, 0.15)};
    const TerrainLimits limits{static_cast<float>(step_m), 0.35f, static_cast<float>(random.between(0.5, 3)),
                               static_cast<float>(2 * step_m), 0.1f};
    LowModel model{rig, limits, cell_m, window_cells, 9, disparities};
    LowObstacleFinder finder{rig, window_cells};
    LowObstaclesOnDevice on_gpu{rig, window_cells, disparities};
    Cuda cuda;
    for (int frame{0}; frame < 3; ++frame) {  // none must see the one before; the second has blank images
      const Surfaces view{frame == 1 ? Surfaces{{width, height}, {width, height}} : stony_plane(rig, ground, random)};
      const double side_m{window_cells * cell_m};
      const GridGeometry grid{random.between(-0.4, 0.1) * side_m, random.between(-0.8, -0.2) * side_m, cell_m,
                              window_cells, window_cells};
      const double yaw_rad{round % 4 == 0 ? random.between(-3.1, 3.1) : random.between(-0.3, 0.3)};
      const Pose2 pose{random.between(-1, 1), random.between(-1, 1), yaw_rad};
      model.begin(TerrainCamera{rig, ground}, grid_in_vehicle(grid, pose),
                  round == 1 ? 0.0f : static_cast<float>(random.between(1, 30)));
      std::vector<float> noise_px(static_cast<std::size_t>(Rings::last_place(disparities)) + 1);
      for (float& one : noise_px) one = static_cast<float>(random.between(0.05, 0.3));
      const std::span<const LowCell> expected{finder.find(view.obstacle.view(), view.road.view(), model, noise_px,
                                                          [](int count, auto work) { work(0, count); })};
      const DeviceImage<float> obstacle{on_device(cuda, view.obstacle)};
      const DeviceImage<float> road{on_device(cuda, view.road)};
      on_gpu.put(model, noise_px);
      on_gpu.find(cuda, obstacle.view(), road.view());
      cuda.synchronize();
      const std::vector<LowCell> found{by_place(on_gpu.found())};
      const std::vector<LowCell> wanted{by_place(expected)};
      CHECK(std::equal(found.begin(), found.end(), wanted.begin(), wanted.end(), is_same));
      CHECK(frame != 1 || found.empty());
      all.add(found);
    }
  }
  CHECK(all.cells > 3000);
  CHECK(all.high > 100);
  CHECK(all.beside_tall > 500);
}

/// A box on the ground, or a hole in it.
struct Block {
  double x_m;
  double left_m;
  double length_m;
  double width_m;
  double z_m;
};

// A slope from some range on, with ditches, steps, boxes and holes, the smear of a matcher, noise and wrong matches.
Image<float> random_terrain(const Rig& rig, const Ground& ground, int window, Random& random) {
  std::vector<Block> blocks(static_cast<std::size_t>(random.whole(0, 5)));
  for (Block& one : blocks) {
    const bool is_wide{random.happens(0.5)};
    one = {random.between(1.5, 7), is_wide ? -20 : random.between(-3, 2), random.between(0.2, 1.5),
           is_wide ? random.between(17, 40) : random.between(0.2, 3), random.between(-0.8, 0.8)};
  }
  const double foot_m{random.between(1, 9)};
  const double slope{random.happens(0.5) ? random.between(-0.3, 0.3) : 0};
  const double noise_px{random.between(0, 0.3)};
  const auto height = [&](double x, double y) {
    double z{slope * std::max(x - foot_m, 0.0)};
    for (const Block& one : blocks) {
      if (x >= one.x_m && x < one.x_m + one.length_m && y >= one.left_m && y < one.left_m + one.width_m) z = one.z_m;
    }
    return z;
  };
  Image<float> disparity{rig.width_px, rig.height_px};
  std::vector<double> exact(static_cast<std::size_t>(rig.height_px + window));  // with some rows below the image
  for (int u{0}; u < rig.width_px; ++u) {
    double x{0.3};
    for (int row{static_cast<int>(exact.size()) - 1}; row >= 0; --row) {
      const double tangent{(row - window / 2 - rig.cy_px) / rig.focal_px};
      while (x < 25 && ground.height_m - tangent * x > height(x, x * (rig.cx_px - u) / rig.focal_px)) x += 0.02;
      exact[static_cast<std::size_t>(row)] = rig.focal_px * rig.baseline_m / x;
    }
    for (int v{0}; v < rig.height_px; ++v) {
      const double d{std::accumulate(exact.begin() + v, exact.begin() + v + window, 0.0) / window};
      const double there{random.happens(0.01) ? random.between(1, 99) : d + random.between(-noise_px, noise_px)};
      if (d > 4 && random.happens(0.9)) disparity(u, v) = static_cast<float>(there);
    }
  }
  return disparity;
}

bool is_same(float a, float b) {
  return a == b || (std::isnan(a) && std::isnan(b));
}
bool is_same(const PolarCell& a, const PolarCell& b) {
  return is_same(a.elevation_m, b.elevation_m) && a.slope == b.slope && a.kind == b.kind && a.is_firm == b.is_firm;
}

TEST(walks_are_those_of_the_cpu) {
  Random random{59};
  std::array<int, 5> kinds{};
  int edges{0};
  int extended{0};
  for (int round{0}; round < 24; ++round) {
    const int width{round == 0 ? 7 : random.whole(40, 600)};
    const Rig rig{width, random.whole(60, 200), 200, random.between(0, width), random.between(5, 30), 0.4};
    const Ground ground{random.between(0.4, 1.2), 0, 0, true};
    const double step_m{random.between(0.03, 0.15)};
    const TerrainLimits limits{static_cast<float>(step_m), 0.36f, static_cast<float>(random.between(0.3, 1.2)),
                               static_cast<float>(2 * step_m), static_cast<float>(random.between(0.05, 0.12))};
    const int window{2 * random.whole(1, 5) + 1};
    Rings rings{static_cast<float>(random.between(0.05, 0.3)), 20, 100};
    SectorWalks on_cpu{rig, rings.capacity(), window};
    Cuda cuda;
    TerrainOnDevice terrain{cuda, rig, window, rings};
    for (int frame{0}; frame < 2; ++frame) {  // the second must not see the first
      const TerrainCamera camera{rig, ground};
      rings.place(camera, static_cast<float>(random.between(0.5, 3)));
      const WalkFrame input{{camera, limits, rig.width_px, rig.height_px}, rings, {0.01f, 0.02f}};
      const Image<float> obstacle{random_terrain(rig, ground, window, random)};
      const Image<float> road{rig.width_px, rig.height_px};
      const auto in_order = [](int count, const auto& work) { work(0, count); };
      const float* const sigma_px{on_cpu.begin(input, obstacle.view(), road.view(), in_order)};
      const WalkedGround<Host> expected{on_cpu.find(in_order)};
      const DeviceImage<float> obstacle_there{on_device(cuda, obstacle)};
      const DeviceImage<float> road_there{on_device(cuda, road)};
      find_medians(cuda, obstacle_there.view(), road_there.view(), terrain);
      begin_walk(cuda, input, terrain);
      find_trenches(cuda, input.ground, terrain);
      find_walk(cuda, terrain);
      cuda.synchronize();
      const WalkedGround<Host> walked{terrain.on_host()};
      CHECK(std::equal(sigma_px, sigma_px + rings.count(), walked.sigma_px));
      for (int sector{0}; sector < walked.cells.height; ++sector) {
        for (int ring{0}; ring < rings.count(); ++ring) {
          CHECK(is_same(walked.cells(ring, sector), expected.cells(ring, sector)));
          ++kinds[static_cast<std::size_t>(walked.cells(ring, sector).kind)];
        }
        const SectorWalk& one{walked.walks(sector, 0)};
        const SectorWalk& reference{expected.walks(sector, 0)};
        CHECK(one.end == reference.end && one.end_fall_m == reference.end_fall_m && one.lost == reference.lost);
        CHECK(one.trench == reference.trench && one.state.is_blocked == reference.state.is_blocked);
        edges += one.end != no_ring ? 1 : 0;
        extended += one.trench && one.trench->is_sure ? 1 : 0;
      }
    }
  }
  for (const int count : kinds) CHECK(count > 200);
  CHECK(edges > 100);
  CHECK(extended > 20);
}

// Patches of ground, obstacles, edges and unknown cells over a wavy surface.
Image<PolarCell> random_ground(const RingTable& rings, int sectors, Random& random) {
  Image<PolarCell> cells{rings.count(), sectors};
  const double wave_m{random.happens(0.3) ? 0 : random.between(0, 1)};
  const double noise_m{random.between(0, 0.15)};
  const double unknown{random.between(0, 0.5)};
  for (int sector{0}; sector < sectors; ++sector) {
    for (int ring{0}; ring < rings.count(); ++ring) {
      if (random.happens(unknown)) continue;
      const double z{wave_m * std::sin(0.2 * rings.middle_m(ring) + 0.03 * sector) + random.between(-noise_m, noise_m)};
      cells(ring, sector) = {static_cast<float>(z), static_cast<float>(random.between(-0.2, 0.2)),
                             TerrainClass::drivable, random.happens(0.95)};
    }
  }
  for (int patch{0}; patch < 12; ++patch) {
    const auto kind = static_cast<TerrainClass>(random.whole(0, 4));
    const int first{random.whole(0, sectors - 1)};
    const int at{random.whole(0, rings.count())};
    for (int sector{first}; sector < std::min(first + 9, sectors); ++sector) {
      for (int ring{at}; ring < std::min(at + 3, rings.count()); ++ring) {
        const bool is_seen{kind != TerrainClass::unknown && kind != TerrainClass::hidden};
        cells(ring, sector) = PolarCell{};
        cells(ring, sector).kind = kind;
        if (is_seen) cells(ring, sector).elevation_m = static_cast<float>(random.between(-0.5, 1));
      }
    }
  }
  return cells;
}

// (grid, cell, ground) of the cells with ground, by place.
std::vector<GroundCell> read_by_plain_loops(const GroundFrame<Host>& frame) {
  std::vector<GroundCell> cells;
  for (int g{0}; g < 2; ++g) {
    const GroundGrid& grid{frame.grids[static_cast<std::size_t>(g)]};
    for (int cell{0}; cell < grid.width * grid.height; ++cell) {
      const float x{grid.places.x_of(cell % grid.width, cell / grid.width)};
      const float y{grid.places.y_of(cell % grid.width, cell / grid.width)};
      const PolarPlace at{polar_place(frame.geometry, x, y)};
      const int ring{frame.ground.ring_of(at)};
      if (ring == no_ring) continue;
      const RingPart part{frame.ground.part_of(ring, at.first, at.last)};
      if (part.has_ground()) cells.push_back({g, cell, frame.ground.ground_at(x, part)});
    }
  }
  return cells;
}

std::vector<LowCell> random_low_cells(int window, Random& random) {
  std::vector<LowCell> cells(static_cast<std::size_t>(random.whole(0, 40)));
  for (LowCell& cell : cells) {
    cell.ix = static_cast<std::uint16_t>(random.whole(0, window - 1));
    cell.iy = static_cast<std::uint16_t>(random.whole(0, window - 1));
    cell.is_high = random.happens(0.7);
  }
  return cells;
}

// Rules of the vehicle's grid and of the window.
std::array<std::vector<CellRule>, 2> rules_of(const GroundFrame<Host>& frame, const std::vector<LowCell>& low,
                                              const std::vector<GroundCell>& cells) {
  std::array<std::vector<CellRule>, 2> rules;
  for (std::size_t g{0}; g < 2; ++g)
    rules[g].resize(static_cast<std::size_t>(frame.grids[g].width * frame.grids[g].height), CellRule::ground_not_seen);
  for (const GroundCell& one : cells)
    rules[static_cast<std::size_t>(one.grid)][static_cast<std::size_t>(one.cell)] = rule_of(one.ground.kind);
  for (const LowCell& one : low) {
    const auto mark = [&](int ix, int iy) {
      mark_obstacle(rules[0][static_cast<std::size_t>(iy * frame.grids[0].width + ix)]);
    };
    if (one.is_high) frame.within.for_cells(one.ix, one.iy, mark);
  }
  return rules;
}

int differing(Cuda& cuda, const CellRule* on_device, const std::vector<CellRule>& expected) {
  std::vector<CellRule> found(expected.size());
  download(cuda, on_device, found.size(), found.data());
  cuda.synchronize();
  int different{0};
  for (std::size_t i{0}; i < found.size(); ++i) different += found[i] == expected[i] ? 0 : 1;
  return different;
}

bool is_same(const GroundCell& a, const GroundCell& b) {
  return a.grid == b.grid && a.cell == b.cell && a.ground.kind == b.ground.kind &&
         is_same(a.ground.elevation_m, b.ground.elevation_m) && is_same(a.ground.sigma_m, b.ground.sigma_m);
}

template <class T>
DeviceBuffer<T> buffer_on_device(Cuda& cuda, const T* host, int size) {
  DeviceBuffer<T> result{static_cast<std::size_t>(size)};
  upload(cuda, host, result.size(), result.data());
  cuda.synchronize();
  return result;
}

TEST(relief_and_cells_are_those_of_the_cpu) {
  Random random{53};
  std::size_t with_ground{0};
  int raised{0};
  for (int round{0}; round < 40; ++round) {
    const Rig rig{round == 0 ? 5 : random.whole(8, 700),
                  random.whole(40, 300),
                  random.between(80, 500),
                  random.between(2, 350),
                  20,
                  random.between(0.1, 0.5)};
    const int disparities{random.whole(2, 96)};
    const Ground ground{random.between(0.3, 1.8), random.between(-0.05, 0.1), random.between(-0.1, 0.1)};
    const TerrainCamera camera{rig, ground};
    const TerrainLimits limits{static_cast<float>(random.between(0.03, 0.2)), 0.35f,
                               static_cast<float>(random.between(0.3, 2.5)), 0.2f, 0.1f};
    const double cell_m{random.between(0.1, 0.4)};
    Rings rings{static_cast<float>(cell_m), static_cast<float>(random.between(2, 30)), disparities};
    const int sectors{terrain_sectors(rig.width_px)};
    TerrainRelief relief{sectors, rings.capacity(), disparities, rig.height_px};
    const int across{random.whole(1, 50)};
    const int window{random.whole(1, 60)};
    const GridGeometry vehicle_grid{random.between(-3, 3), -0.5 * across * cell_m, cell_m, across, across};
    GroundOnDevice on_gpu{rig, rings.capacity(), vehicle_grid, window};
    Cuda cuda;
    DeviceImage<std::int16_t> rows{disparities * relief_bins_per_px, sectors};
    for (int frame{0}; frame < 2; ++frame) {  // the second one must not see the first
      rings.place(camera, frame == 1 && round == 1 ? 1e6f : static_cast<float>(random.between(0.3, 4)));
      std::vector<float> sigma_px(static_cast<std::size_t>(rings.count()));
      std::vector<float> plane_sigma_m(sigma_px.size());
      for (float& one : sigma_px) one = static_cast<float>(random.between(0.05, 0.5));
      for (float& one : plane_sigma_m) one = static_cast<float>(random.between(0, 0.1));
      const Image<PolarCell> cells{random_ground(rings, sectors, random)};
      const FirstGround prior{static_cast<float>(random.between(-0.2, 0.2)),
                              static_cast<float>(random.between(-0.1, 0.1))};
      relief.begin(camera, limits, rings, sigma_px.data(), prior);
      for (int sector{0}; sector < sectors; ++sector) relief.profile(sector, cells.row(sector));
      relief.count_level();
      for (int sector{0}; sector < sectors; ++sector) relief.fill(sector, cells.row(sector));
      const GridGeometry window_grid{random.between(-3, 3), -0.5 * window * cell_m, cell_m, window, window};
      const auto placed = [&](const GridGeometry& grid) {
        const Pose2 pose{random.between(-1, 1), random.between(-1, 1), random.between(-0.6, 0.6)};
        return grid_in_vehicle(grid, pose);
      };
      const auto grid_of = [](const GridInVehicle& grid) {
        return GroundGrid{{grid, {0, 0}, 1}, grid.grid.nx, grid.grid.ny};
      };
      const GridInVehicle window_cells{placed(window_grid)};
      const PolarGeometry geometry{camera.focal_px,
                                   camera.focal_baseline_pxm,
                                   static_cast<float>(rig.cx_px) + 0.5f,
                                   static_cast<float>(rig.width_px),
                                   sectors - 1,
                                   static_cast<float>(cell_m / 2),
                                   static_cast<float>(rings.places()),
                                   Rings::places_per_px};
      const GroundFrame<Host> input{relief.model(),
                                    {camera, rings, sigma_px.data(), plane_sigma_m.data(), cells.view()},
                                    geometry,
                                    {grid_of(placed(vehicle_grid)), grid_of(window_cells)},
                                    {vehicle_grid, window_cells}};
      const std::vector<LowCell> low{random_low_cells(window, random)};
      const DeviceBuffer<int> low_count{one_on_device(cuda, static_cast<int>(low.size()))};
      PinnedBuffer<LowCell> low_cells{low.size() + 1};
      std::copy(low.begin(), low.end(), low_cells.data());

      const DeviceImage<PolarCell> cells_there{on_device(cuda, cells)};
      const DeviceBuffer<float> borders_m{buffer_on_device(cuda, rings.borders_m, rings.count() + 1)};
      const DeviceBuffer<std::int16_t> ring_at{buffer_on_device(cuda, rings.ring_at, rings.places() + 1)};
      const DeviceBuffer<float> noise_px{buffer_on_device(cuda, sigma_px.data(), rings.count())};
      on_gpu.put(input, {rings.count(), rings.places(), borders_m.data(), ring_at.data()},
                 {cells_there.view(), {}, noise_px.data()});
      on_gpu.find(cuda, {low_count.data(), low_cells.data()}, rows.view());
      cuda.synchronize();
      const Image<std::int16_t> found_rows{on_host(cuda, rows)};
      const View<const std::int16_t> expected_rows{relief.view().rows};
      CHECK(std::equal(found_rows.begin(), found_rows.end(), expected_rows.data));
      raised += static_cast<int>(std::count_if(found_rows.begin(), found_rows.end(), [](int one) { return one != 0; }));
      std::vector<GroundCell> found{on_gpu.found().begin(), on_gpu.found().end()};
      std::sort(found.begin(), found.end(), [](const GroundCell& a, const GroundCell& b) {
        return a.grid != b.grid ? a.grid < b.grid : a.cell < b.cell;
      });
      const std::vector<GroundCell> expected{read_by_plain_loops(input)};
      CHECK(std::equal(found.begin(), found.end(), expected.begin(), expected.end(),
                       [](const GroundCell& a, const GroundCell& b) { return is_same(a, b); }));
      with_ground += found.size();
      const std::array<std::vector<CellRule>, 2> rules{rules_of(input, low, expected)};
      CHECK_EQUAL(differing(cuda, on_gpu.vehicle_rules(), rules[0]), 0);
      CHECK_EQUAL(differing(cuda, on_gpu.window_rules(), rules[1]), 0);
    }
  }
  CHECK(with_ground > 10000);
  CHECK(raised > 10000);
}

}  // namespace
}  // namespace stereogrid::test
