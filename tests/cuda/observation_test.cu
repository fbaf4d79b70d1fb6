// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "backend/reference.hpp"
#include "check.hpp"
#include "fusion/cuda.hpp"
#include "fusion/fusion.hpp"
#include "images.hpp"
#include "observation/projection/cuda.hpp"
#include "observation/rays/cuda.hpp"
#include "observation/rays/rays.hpp"
#include "observation/u_disparity/cuda.hpp"
#include "obstacles/segmentation/cuda.hpp"

namespace stereogrid::test {
namespace {

void check_projection(const Rig& rig, const Image<float>& occupancy, const GridInVehicle& grid) {
  Cuda cuda;
  Reference reference;
  const BinGeometry bins{rig};
  const DeviceImage<float> plane{on_device(cuda, occupancy)};
  const DeviceBuffer<GridInVehicle> place{one_on_device(cuda, grid)};
  ProjectionWorkspace unused{occupancy.width(), occupancy.height()};
  Image<float> expected{grid.grid.nx, grid.grid.ny};
  project(reference, occupancy.view(), bins, grid, unused, expected.view());
  ProjectionOnDevice space{occupancy.width(), occupancy.height()};
  DeviceImage<float> cells{grid.grid.nx, grid.grid.ny};
  find_largest(cuda, plane.view(), space);
  project(cuda, plane.view(), bins, place.data(), space, cells.view());
  CHECK_EQUAL(differences(on_host(cuda, cells), expected), 0);
}

TEST(cells_are_those_of_the_reference) {
  Random random{21};
  for (int round{0}; round < 12; ++round) {
    const int width{random.whole(1, 90)};
    const Rig rig{width, 60, random.between(40, 300), random.between(-5, width + 5.0), 30, random.between(0.1, 0.6)};
    const GridGeometry grid{random.between(-5, 5), random.between(-10, 0), random.between(0.1, 0.7),
                            random.whole(1, 40), random.whole(1, 40)};
    const Pose2 pose{random.between(-3, 6), random.between(-3, 3), round % 3 == 0 ? 0.0 : random.between(-3.1, 3.1)};
    check_projection(rig, random.image(width, random.whole(2, 40), 0, 1), grid_in_vehicle(grid, pose));
  }
}

TEST(cells_in_special_headings) {
  Random random{23};
  const Rig rig{101, 60, 100, 50, 30, 0.5};
  const Image<float> occupancy{random.image(101, 30, 0, 1)};
  for (const double yaw : {0.0, 1e-12, 1e-5, -2e-3, 0.7853981633974483, 1.5707963267948966, 1.57, 3.1}) {
    check_projection(rig, occupancy, grid_in_vehicle({-6, -6, 0.5, 24, 25}, {0.25, -0.1, yaw}));
  }
}

TEST(other_grids_are_fused_as_by_the_reference) {
  Random random{25};
  const Image<float> stereo{random.image(83, 71, 0, 1)};
  const GridInVehicle grid{grid_in_vehicle({-4, -8, 0.2, 83, 71}, {1, -2, 0.3})};
  const std::vector<ObservedGrid> two{{{-3, -5, 0.3, 40, 50}, random.image(40, 50, 0, 1), random.image(40, 50, 0, 1)},
                                      {{2, 1, 0.11, 61, 33}, random.image(61, 33, 0, 1), {}}};
  Cuda cuda;
  Reference reference;
  const DeviceBuffer<GridInVehicle> place{one_on_device(cuda, grid)};
  OtherGridsOnDevice others;
  const FusionConfig config{0.9};
  for (const std::size_t count : {1u, 0u, 2u}) {
    const std::span<const ObservedGrid> given{two.data(), count};
    Image<float> expected{stereo};
    fuse(reference, given, grid, config, expected.view());
    others.take(cuda, given);
    DeviceImage<float> cells{on_device(cuda, stereo)};
    fuse(cuda, others, place.data(), config, cells.view());
    CHECK_EQUAL(differences(on_host(cuda, cells), expected), 0);
    CHECK_EQUAL(differences(expected, stereo) > 0, count > 0);
  }
}

TEST(rays_are_those_of_the_reference) {
  Random random{31};
  for (int round{0}; round < 8; ++round) {
    const int width{random.whole(1, 300)};
    const int height{random.whole(1, 70)};
    const int disparities{random.whole(2, 60)};
    const Rig rig{width, height, random.between(40, 300), width / 2.0, random.between(0, 40), random.between(0.1, 0.6)};
    const Ground ground{random.between(0.3, 3), random.between(-0.1, 0.1), random.between(-0.2, 0.2), true};
    Matches matches{width, height};
    for (int v{0}; v < height; ++v) {
      for (int u{0}; u < width; ++u) {
        const float d{static_cast<float>(random.between(0.1, disparities + 3.0))};
        if (random.happens(0.6)) matches.obstacle(u, v) = ambiguous_px;
        if (random.happens(0.3)) (random.happens(0.5) ? matches.road : matches.obstacle)(u, v) = d;
      }
    }
    UDisparityConfig config;
    config.follow_roll = round % 2 == 0;
    Reference reference;
    const bool has_relief{round % 3 == 0};
    RayWorkspace expected{width, height, disparities, has_relief};
    Image<std::int16_t> relief{2 * disparities, relief_sectors(width)};
    for (std::int16_t& rows : relief) rows = static_cast<std::int16_t>(random.between(-height, height));
    if (has_relief) expected.relief = {std::as_const(relief).view()};
    count_rays(reference, matches, rig, ground, config, expected);
    Cuda cuda;
    const DeviceImage<float> obstacle{on_device(cuda, matches.obstacle)};
    const DeviceImage<float> road{on_device(cuda, matches.road)};
    const DeviceBuffer<Ground> plane{one_on_device(cuda, ground)};
    RaysOnDevice space{width, height, disparities, has_relief};
    if (has_relief) upload(cuda, relief.data(), relief.size(), space.relief.data());
    for (int frame{0}; frame < 2; ++frame) {  // the second must not see the first
      begin_rays(cuda, rig, plane.data(), config, space);
      count_rays(cuda, {obstacle.view(), road.view()}, space);
    }
    std::vector<PackedRays> sums(space.sums.size());
    download(cuda, space.sums.data(), sums.size(), sums.data());
    cuda.synchronize();
    CHECK(std::equal(sums.begin(), sums.end(), expected.sums.begin(), expected.sums.end()));

    const GridInVehicle grid{grid_in_vehicle({random.between(-5, 5), -4, 0.3, 37, 29},
                                             {random.between(-3, 6), 1, random.between(-3.1, 3.1)})};
    const DeviceBuffer<GridInVehicle> place{one_on_device(cuda, grid)};
    expected.blur_px = static_cast<float>(random.between(0, 0.6));
    const DeviceBuffer<float> blur_px{one_on_device(cuda, expected.blur_px)};
    Image<float> cells{37, 29};
    project_rays(reference, expected, BinGeometry{rig}, grid, cells.view());
    DeviceImage<float> found{37, 29};
    project_rays(cuda, space, BinGeometry{rig}, place.data(), blur_px.data(), found.view());
    CHECK_EQUAL(differences(on_host(cuda, found), cells), 0);
  }
}

// Upright surfaces with noise, holes and ambiguous pixels.
Image<float> random_surfaces(int width, int height, int disparities, Random& random) {
  Image<float> obstacle{width, height};
  for (int surface{0}; surface < 20; ++surface) {
    const double disparity_px{random.whole(1, 8) * disparities / 7.5};
    const int first_u{random.whole(-5, width)};
    const int first_v{random.whole(-5, height)};
    for (int v{std::max(first_v, 0)}; v < std::min(first_v + 40, height); ++v) {
      for (int u{std::max(first_u, 0)}; u < std::min(first_u + 30, width); ++u)
        obstacle(u, v) = static_cast<float>(disparity_px + random.between(-0.2, 0.2));
    }
  }
  for (float& d : obstacle) {
    if (random.happens(0.1)) d = random.happens(0.2) ? ambiguous_px : 0;
  }
  return obstacle;
}

std::vector<ColumnNode> by_bin(std::span<const ColumnNode> nodes) {
  std::vector<ColumnNode> sorted{nodes.begin(), nodes.end()};
  std::sort(sorted.begin(), sorted.end(),
            [](const ColumnNode& a, const ColumnNode& b) { return a.bin != b.bin ? a.bin < b.bin : a.u < b.u; });
  return sorted;
}

TEST(nodes_of_obstacles_are_those_of_the_cpu) {
  Random random{37};
  std::size_t found{0};
  for (int round{0}; round < 50; ++round) {
    const int width{round == 0 ? 1 : random.whole(1, 150)};
    const int height{random.whole(1, 150)};
    const int disparities{round == 1 ? 256 : random.whole(2, 60)};
    const Rig rig{
        width, height, random.between(40, 300), width / 2.0, random.between(0, 0.5 * height), random.between(0.3, 0.6)};
    const Ground ground{random.between(1, 3), random.between(-0.1, 0.1), random.between(-0.2, 0.2), true};
    const Image<float> obstacle{random_surfaces(width, height, disparities, random)};
    Image<std::int16_t> rows{round % 2 == 0 ? 2 * disparities : 0, relief_sectors(width)};
    for (std::int16_t& raised : rows) raised = static_cast<std::int16_t>(random.between(-9, 9));
    ColumnCounter counter{rig, {}, disparities};
    const std::span<const ColumnNode> expected{counter.find(obstacle.view(), ground, {std::as_const(rows).view()},
                                                            [](int count, auto work) { work(0, count); })};
    Cuda cuda;
    const DeviceImage<float> image{on_device(cuda, obstacle)};
    const DeviceImage<std::int16_t> raised{on_device(cuda, rows)};
    ColumnsOnDevice columns{cuda, rig, {}, disparities};
    columns.put(cuda, ground);
    for (int frame{0}; frame < 2; ++frame) columns.count(cuda, image.view(), {raised.view()});
    cuda.synchronize();
    CHECK(by_bin(columns.nodes()) == by_bin(expected));
    found += expected.size();
  }
  CHECK(found > 4000);
}

struct Scene {
  Rig rig;
  Ground ground;
  Matches matches;
  int disparities;
};

// Disparities anywhere, some beyond the bins; no pixel has both.
Scene random_scene(int width, int height, int disparities, const Ground& ground, Random& random) {
  Scene scene{{width, height, 0.6 * width, 0.5 * width, 0.4 * height, 0.5, ground.height_m, 0, 0},
              ground,
              Matches{width, height},
              disparities};
  for (int v{0}; v < height; ++v) {
    for (int u{0}; u < width; ++u) {
      if (random.happens(0.3)) continue;
      const float d{static_cast<float>(random.between(0.4, disparities + 2.0))};
      (random.happens(0.5) ? scene.matches.road : scene.matches.obstacle)(u, v) = d;
      scene.matches.confidence(u, v) = random.happens(0.1) ? 0.0f : static_cast<float>(random.between(0, 1));
    }
  }
  return scene;
}

// A road with boxes on it, at whole disparities.
Scene street_scene(const Ground& ground, Random& random) {
  Scene scene{random_scene(163, 92, 40, ground, random)};
  const RoadPlane plane{road_plane(scene.rig, ground)};
  scene.matches.obstacle.fill(0);
  for (int v{0}; v < 92; ++v) {
    for (int u{0}; u < 163; ++u) {
      const double d{plane.disparity(u, v)};
      const bool is_box{u / 20 % 2 == 0 && d < 3.0 + u / 20.0 && v > 25};
      scene.matches.road(u, v) = !is_box && d > 1 ? static_cast<float>(d) : 0.0f;
      if (is_box) scene.matches.obstacle(u, v) = 3.0f + static_cast<float>(u / 20);
    }
  }
  return scene;
}

StageImages counted(const Scene& scene, const UDisparityTables& tables) {
  const int width{scene.rig.width_px};
  StageImages stages;
  stages.possible.resize(static_cast<std::size_t>(scene.disparities));
  stages.visible = stages.observed = Image<std::uint16_t>{width, scene.disparities};
  stages.visibility = stages.obstacle_confidence = stages.road_confidence = Image<float>{width, scene.disparities};
  stages.occupancy = stages.occupancy_smooth = stages.visibility;
  UDisparityWorkspace space{width, scene.rig.height_px, scene.disparities, 1};
  Reference reference;
  count(reference, scene.matches, scene.rig, scene.ground, tables, space, stages);
  return stages;
}

BinConfig of_preset(std::string_view name) {
  const Config config{preset(name)};
  return {config.u_disparity, config.paper};
}

void check_equal(const Scene& scene, const BinConfig& config, int window_px) {
  const UDisparityTables tables{config, scene.rig.height_px, window_px};
  const StageImages expected{counted(scene, tables)};
  Cuda cuda;
  const DeviceImage<float> obstacle{on_device(cuda, scene.matches.obstacle)};
  const DeviceImage<float> road{on_device(cuda, scene.matches.road)};
  const DeviceBuffer<Ground> ground{one_on_device(cuda, scene.ground)};
  UDisparityOnDevice space{cuda, tables, scene.rig.width_px, scene.rig.height_px, scene.disparities};
  for (int frame{0}; frame < 2; ++frame) {  // the second must not see the first
    count(cuda, {obstacle.view(), road.view()}, scene.rig, ground.data(), space);
  }
  std::vector<int> possible(expected.possible.size());
  download(cuda, space.possible.data(), possible.size(), possible.data());
  cuda.synchronize();
  CHECK(possible == expected.possible);
  CHECK_EQUAL(differences(on_host(cuda, space.visible), expected.visible), 0);
  CHECK_EQUAL(differences(on_host(cuda, space.observed), expected.observed), 0);
  CHECK_EQUAL(differences(on_host(cuda, space.visibility), expected.visibility), 0);
  CHECK_EQUAL(differences(on_host(cuda, space.obstacle_confidence), expected.obstacle_confidence), 0);
  CHECK_EQUAL(differences(on_host(cuda, space.road_confidence), expected.road_confidence), 0);
  CHECK_EQUAL(differences(on_host(cuda, space.occupancy), expected.occupancy), 0);
  CHECK_EQUAL(differences(on_host(cuda, space.occupancy_smooth), expected.occupancy_smooth), 0);
}

TEST(counts_and_probabilities_are_those_of_the_reference) {
  Random random{3};
  const Ground tilted{1.4, 0.03, -0.06};
  for (const std::string_view name : {"default", "paper"}) {
    check_equal(random_scene(97, 61, 23, tilted, random), of_preset(name), 9);
    check_equal(random_scene(33, 140, 64, {1.65, -0.02, 0.1}, random), of_preset(name), 21);
    check_equal(street_scene({1.65, 0, 0}, random), of_preset(name), 9);
    check_equal(street_scene(tilted, random), of_preset(name), 9);
  }
}

TEST(counts_of_odd_sizes) {
  Random random{5};
  for (const int width : {1, 7, 31, 32, 65}) {
    check_equal(random_scene(width, random.whole(1, 70), random.whole(2, 50), {1.5, 0.01, 0.05}, random), {}, 5);
  }
}

// Seen under obstacles lower than the camera, rays leave the bins again.
TEST(counts_of_rays_that_leave) {
  Random random{7};
  BinConfig config;
  config.obstacle_height_m = 0.6;
  config.obstacle_min_height_m = 0.2;
  for (const RoadRays rays : {RoadRays::none, RoadRays::visible}) {
    config.road_rays = rays;
    check_equal(random_scene(70, 120, 40, {1.5, 0, 0.08}, random), config, 5);
    check_equal(street_scene({1.5, 0.01, -0.05}, random), config, 5);
  }
}

TEST(smoothing_with_other_widths) {
  Random random{15};
  BinConfig config;
  config.sigma_column = 4;
  config.sigma_disparity = 2.2;
  check_equal(random_scene(41, 50, 37, {1.5, 0, 0}, random), config, 5);
  config.sigma_column = config.sigma_disparity = 0;
  check_equal(random_scene(41, 50, 37, {1.5, 0, 0}, random), config, 5);
}

TEST(counts_that_no_word_holds_are_refused) {
  Cuda cuda;
  const auto throws = [&](int height, int disparities) {
    try {
      const UDisparityOnDevice space{cuda, UDisparityTables{{}, 8, 5}, 8, height, disparities};
    } catch (const ConfigError&) {
      return true;
    }
    return false;
  };
  CHECK(!throws(65535, 256));
  CHECK(throws(65536, 256));
  CHECK(throws(100, 257));
}

}  // namespace
}  // namespace stereogrid::test
