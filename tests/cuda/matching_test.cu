// SPDX-License-Identifier: Apache-2.0
//
// Matching on the device equals the reference to the bit: candidates, disparities, labels, confidences.
#include "matching_run.hpp"

#include "matching/checks/external.hpp"

namespace stereogrid::test {
namespace {

constexpr RoadPlane plain_plane{4, 0, 0.2, 20, 15};
constexpr RoadPlane rolled_plane{3.3, 0.07, 0.31, 30, 10};
constexpr RoadPlane falling_plane{-2, -0.11, 0.15, 10, 5};  // mostly behind the camera: negative disparities

// Settings where every test of a match rejects some.
MatchingConfig config_of(int window_px, int disparities) {
  MatchingConfig config;
  config.window_px = window_px;
  config.disparities = disparities;
  config.texture = 3;
  config.uniqueness = 0.05;
  config.left_right_px = 1;
  config.speckle_px = config.road_speckle_px = 4;
  return config;
}

TEST(windows_on_tiny_images) {
  for (const Size size : {Size{1, 1}, Size{1, 9}, Size{9, 1}, Size{7, 5}}) {
    for (const int window_px : {3, 9, 21}) {
      check_equal(noise_pair(size, 61), rolled_plane, config_of(window_px, 16));
    }
  }
}

TEST(windows_of_all_sizes) {
  for (const int window_px : {3, 5, 9, 13, 21}) {
    check_equal(textured_pair({67, 15}, 67), plain_plane, config_of(window_px, 24));
  }
  check_equal(noise_pair({30, 9}, 71), rolled_plane, config_of(41, 20));
}

TEST(windows_on_many_disparities) {
  for (const int disparities : {2, 64, 70, 96, 128, 129, 192, 256}) {
    check_equal(textured_pair({131, 5}, 73), plain_plane, config_of(5, disparities));
    check_equal(noise_pair({70, 5}, 79), rolled_plane, config_of(9, disparities));
  }
  check_equal(noise_pair({9, 5}, 83), plain_plane, config_of(41, 256));
}

// Windows of 9 px with up to 128 disparities are summed in bit slices: 24 columns a word, some rows a block.
TEST(windows_in_slices) {
  for (const Size size : {Size{23, 7}, Size{24, 16}, Size{25, 17}, Size{44, 21}, Size{53, 34}, Size{97, 8}}) {
    for (const int disparities : {31, 33, 64, 65, 127, 128}) {
      check_equal(noise_pair(size, 151), plain_plane, config_of(9, disparities));
    }
  }
  check_equal(textured_pair({171, 139}, 157), plain_plane, config_of(9, 64));
  check_equal(textured_pair({102, 75}, 163), rolled_plane, config_of(9, 100));
  for (const double uniqueness : {0.0, 0.1, 1.0}) {
    MatchingConfig config{config_of(9, 128)};
    config.uniqueness = uniqueness;
    check_equal(textured_pair({53, 22}, 167), falling_plane, config);
    // rivals at the ends of the shifts, and shifts of the same lane
    check_equal(doubled_pair({170, 12}, 0, 3, 173), plain_plane, config);
    check_equal(doubled_pair({170, 12}, 124, 127, 179), plain_plane, config);
  }
}

TEST(windows_with_every_option) {
  for (int option{0}; option < 8; ++option) {
    MatchingConfig config{config_of(7, 24)};
    config.subpixel = option != 0;
    if (option == 1) config.left_right_px = 0;
    if (option == 2) config.uniqueness = 0;
    if (option == 3) config.speckle_px = config.road_speckle_px = 0;
    if (option == 4) config.texture = 20;
    if (option == 5) config.texture = 0;
    if (option == 6) config.left_right_px = 3;
    if (option == 7) config.cost_limit = 0.2;
    check_equal(textured_pair({69, 19}, 89), option % 2 == 0 ? plain_plane : falling_plane, config);
  }
}

TEST(windows_of_the_presets) {
  for (const char* name : {"default", "paper"}) {
    MatchingConfig config{preset(name).matching};
    config.disparities = 64;
    config.speckle_px = config.road_speckle_px = 20;
    check_equal(textured_pair({71, 23}, 97), plain_plane, config);
  }
}

TEST(thin_tops) {
  for (const int disparities : {31, 64, 130}) {
    const MatchingConfig config{config_of(9, disparities)};
    const Pair pair{topped_pair({203, 61}, 30, 24, 181)};
    check_equal(pair, plain_plane, config);
    const ReferenceRun expected{pair, plain_plane, config};
    int found{0};
    for (int u{60}; u < 180; ++u)
      found += expected.matches.obstacle(u, 31) > 23 && expected.matches.obstacle(u, 31) < 25 ? 1 : 0;
    CHECK(found > 90);
  }
}

// Wider than the claims that a row's decision keeps at once.
TEST(windows_on_wide_images) {
  check_equal(noise_pair({8200, 1}, 149), rolled_plane, config_of(3, 8));
}

TEST(blank_images) {
  const Image<std::uint8_t> blank{40, 20, 128};
  check_equal({blank, blank}, plain_plane, config_of(5, 16));
  check_equal({blank, blank}, plain_plane, config_of(9, 100));
}

// One graph serves frames after one another; images and plane lie where it expects them.
TEST(a_graph_follows_its_inputs) {
  for (const MatchingConfig& config : {config_of(9, 33), config_of(5, 33)}) {
    const Pair first{noise_pair({51, 30}, 127)};
    const Pair second{textured_pair({51, 30}, 131)};
    DeviceRun run{{51, 30}, config};
    run.put(first, rolled_plane);
    Graph graph;
    graph.capture(run.cuda(), [&] { run.match_all(); });
    graph.launch(run.cuda());
    run.check_matches(ReferenceRun{first, rolled_plane, config});
    run.put(second, plain_plane);
    graph.launch(run.cuda());
    run.check_matches(ReferenceRun{second, plain_plane, config});
  }
}

// Labels in patches of every shape: the smaller the share of blank pixels, the longer the winding ways.
TEST(speckles) {
  for (const Size size : {Size{1, 1}, Size{1, 40}, Size{67, 1}, Size{133, 37}}) {
    for (const int blank_percent : {5, 40, 55}) {
      for (const int speckle_px : {0, 2, 5, 60, 1000}) check_speckles(size, blank_percent, speckle_px);
    }
  }
}

TEST(given_disparities) {
  Rig rig{.width_px = 67, .height_px = 45, .focal_px = 90, .cx_px = 32.5, .cy_px = 12.25, .baseline_m = 0.4};
  Ground ground{1.5, 0.02, -0.01};
  check_given(rig, ground);
  ground.height_sigma_m = 0.05;
  ground.pitch_sigma_rad = 0.01;
  ground.roll_sigma_rad = 0.02;
  check_given(rig, ground);
}

}  // namespace
}  // namespace stereogrid::test
