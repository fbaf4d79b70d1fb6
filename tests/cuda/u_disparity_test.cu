// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <string_view>

#include "backend/reference.hpp"
#include "check.hpp"
#include "images.hpp"
#include "observation/u_disparity/cuda.hpp"

namespace stereogrid::test {
namespace {

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
