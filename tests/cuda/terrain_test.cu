// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>
#include <span>
#include <vector>

#include "check.hpp"
#include "geometry/road_plane.hpp"
#include "images.hpp"
#include "terrain/cuda.hpp"
#include "terrain/low_obstacles.hpp"

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
         a.is_high == b.is_high && a.is_beside_tall == b.is_beside_tall;
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

// Compares bits: unknown elevations are NaN.
template <class T>
bool is_same_memory(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

bool is_same(const PolarCell& a, const PolarCell& b) {
  return is_same_memory(a.elevation_m, b.elevation_m) && a.slope == b.slope && a.kind == b.kind &&
         a.is_firm == b.is_firm;
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
      find_trenches(cuda, terrain);
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

}  // namespace
}  // namespace stereogrid::test
