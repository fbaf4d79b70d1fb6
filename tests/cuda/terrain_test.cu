// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
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

}  // namespace
}  // namespace stereogrid::test
