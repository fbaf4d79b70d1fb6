// SPDX-License-Identifier: Apache-2.0
//
// Frame pipeline on the GPU against the reference back end.
#include <latch>
#include <thread>

#include "geometry/composed.hpp"
#include "side_by_side.hpp"

namespace stereogrid::test {
namespace {

/// Cameras that each see a street of their own, in directions that overlap.
std::vector<Rig> rigs_around(std::size_t count) {
  std::vector<Rig> rigs(count, small_rig());
  for (std::size_t i{0}; i < count; ++i) {
    rigs[i].camera_x_m = 0.3 * static_cast<double>(i);
    rigs[i].camera_yaw_rad = 0.2 * static_cast<double>(i);
  }
  return rigs;
}

Config config_around() {
  Config config{small_config()};
  config.grid.rear_m = 3;
  return config;
}

/// A frame pipeline of several cameras, and its last result.
struct RunnerAround {
  RunnerAround(const std::vector<Rig>& all_rigs, bool is_on_gpu, const Config& of_all = config_around())
      : config{of_all}, rigs{all_rigs}, frames{config, cpu, setups(is_on_gpu)}, result{empty_result(config, rigs[0])} {
    result.cameras.assign(rigs.size(), result);
  }

  std::vector<CameraSetup> setups(bool is_on_gpu) {
    std::vector<CameraSetup> all;
    for (const Rig& rig : rigs) {
      const StagesOptions options{.filters = all.empty()};
      all.push_back({config, rig,
                     is_on_gpu ? std::make_unique<CudaStages>(config, rig, 0, options)
                               : reference_stages(config, rig, cpu, options)});
    }
    return all;
  }

  /// `seen`: of the cameras, without images where there is none.
  void run(const std::vector<StereoFrame>& seen, const Pose2& world_from_vehicle, double dt_s) {
    std::vector<LevelFrame> level;
    std::vector<CameraView> views;
    for (std::size_t i{0}; i < rigs.size(); ++i) {
      begin_camera(config, result.cameras[i]);
      if (seen[i].left.empty()) continue;
      const Pose2 place{composed(world_from_vehicle, camera_place(rigs[i]))};
      level.push_back(
          {seen[i].left.view(), seen[i].right.view(), seen[i].disparity.view(), place, dt_s, static_cast<int>(i)});
      views.push_back({place, 0.65, 0.65, 4, 50});
    }
    result.status.clear();
    result.warnings.clear();
    frames.process({level, world_from_vehicle, dt_s, seen[0].other_grids, views}, result);
  }

  Cpu cpu{1};
  Config config;
  std::vector<Rig> rigs;
  FramePipeline frames;
  FrameResult result;
};

void compare_cameras(const FrameResult& gpu, const FrameResult& law) {
  compare_grids(gpu, law);
  CHECK(gpu.status == law.status);
  CHECK(gpu.warnings == law.warnings);
  for (std::size_t i{0}; i < law.cameras.size(); ++i) {
    compare(gpu.cameras[i].stages, law.cameras[i].stages);
    compare(gpu.cameras[i].ground, law.cameras[i].ground);
    CHECK_EQUAL(differences(gpu.cameras[i].observed, law.cameras[i].observed), 0);
    CHECK_EQUAL(differences(gpu.cameras[i].terrain, law.cameras[i].terrain), 0);
    CHECK_EQUAL(gpu.cameras[i].road_density, law.cameras[i].road_density);
    CHECK(gpu.cameras[i].status == law.cameras[i].status);
  }
}

/// Cells that all cameras have observed.
int cells_of_all(const FrameResult& result) {
  int cells{0};
  for (std::size_t cell{0}; cell < result.observed.size(); ++cell) {
    const auto sees = [&](const FrameResult& camera) { return camera.observed.data()[cell] != 0.5f; };
    cells += std::ranges::all_of(result.cameras, sees) ? 1 : 0;
  }
  return cells;
}

// Frames without some cameras, the one with the filter among them, and with unusable ones; a state saved before them.
void check_cameras(std::size_t count) {
  const std::vector<Rig> rigs{rigs_around(count)};
  const Street street{small_rig()};
  Random random{6};
  RunnerAround gpu{rigs, true};
  RunnerAround law{rigs, false};
  RunnerAround loaded{rigs, true};
  for (int index{0}; index < 7; ++index) {
    std::vector<StereoFrame> seen;
    for (std::size_t i{0}; i < count; ++i) seen.push_back(street.frame(index + 2 * static_cast<int>(i)));
    const bool is_first_missing{index == 0 || index == 4 || index == 5};
    if (is_first_missing) seen[0].left = {};
    if (index == 3 || index == 4) seen[1].right.fill(3);
    if (index == 3 || index == 5) seen[0].other_grids.push_back({{0, -4, 0.8, 12, 10}, random.image(12, 10, 0, 1), {}});
    for (RunnerAround* runner : {&gpu, &law, &loaded}) {
      if (index == 6) runner->frames.reset();
    }
    const double dt_s{index == 0 || index == 6 ? 0 : 0.1};
    const Pose2 place{0.5 * index, 0.1, 0.02 * index};
    gpu.run(seen, place, dt_s);
    law.run(seen, place, dt_s);
    compare_cameras(gpu.result, law.result);
    compare_on_device(gpu.frames, gpu.result);
    CHECK_EQUAL(gpu.result.cameras[0].has_images, !is_first_missing);
    CHECK_EQUAL(gpu.result.cameras[1].status.empty(), index != 3 && index != 4);
    CHECK(index != 2 || cells_of_all(gpu.result) > 5);
    CHECK(index != 2 || !gpu.result.obstacles.empty());
    CHECK(gpu.result.timing_ms.filter > 0 && gpu.result.timing_ms.match > 0);
    if (index > 2) {
      loaded.run(seen, place, dt_s);
      CHECK_EQUAL(differences(loaded.result.world.occupancy, gpu.result.world.occupancy), 0);
      CHECK_EQUAL(differences(loaded.result.world.velocity_x, gpu.result.world.velocity_x), 0);
    }
    if (index != 2) continue;
    StateWriter saved;
    gpu.frames.exchange(saved);
    StateReader state{saved.bytes()};
    loaded.frames.exchange(state);
    CHECK(state.fits());
  }
}

TEST(two_cameras_equal_the_reference) {
  check_cameras(2);
}

TEST(four_cameras_equal_the_reference) {
  check_cameras(4);
}

TEST(further_cameras_have_no_filter) {
  CudaStages with{config_around(), small_rig()};
  CudaStages without{config_around(), small_rig(), 0, {.filters = false}};
  CHECK(3 * without.memory_use().device_bytes < 2 * with.memory_use().device_bytes);
}

void check_drive(const Config& config) {
  const Street street{small_rig()};
  Pair pair{config, small_rig()};
  for (int index{0}; index < 4; ++index) pair.run(street.frame(index));
  const FrameResult& result{pair.law.result};
  CHECK(result.ground.estimated);
  CHECK(result.obstacle_density > 0.1 && result.road_density > 0.1);
  CHECK(!result.obstacles.empty());
}

TEST(a_drive_equals_the_reference) {
  check_drive(small_config());
}

TEST(the_paper_preset_equals_the_reference) {
  Config config{preset("paper")};
  config.grid = {10, 8, 0.5};
  config.matching.disparities = 16;
  config.matching.window_px = 11;
  config.filter.speeds_mps = {1.25};
  const Street street{small_rig()};
  Pair pair{config, small_rig()};
  pair.is_equal_to_the_bit = false;
  for (int index{0}; index < 2; ++index) pair.run(street.frame(index));
}

// No pixel is on the lattice of matches that the host reads.
TEST(images_of_a_few_pixels_equal_the_reference) {
  Rig rig{small_rig()};
  rig.cx_px -= (rig.width_px - 17) / 2.0;
  rig.cy_px -= (rig.height_px - 17) / 2.0;
  rig.width_px = rig.height_px = 17;
  const Street street{rig};
  Pair pair{small_config(), rig};
  for (int index{0}; index < 3; ++index) pair.run(street.frame(index));
}

TEST(one_is_constructed_while_another_thread_records_a_graph) {
  const Street street{small_rig()};
  Runner alone{std::make_unique<CudaStages>(small_config(), small_rig()), small_config(), small_rig()};
  for (int index{0}; index < 2; ++index) alone.run(street.frame(index), 0.1 * index);
  std::latch recording{1};
  std::latch done{1};
  std::string error_text;
  std::thread other{[&] {
    recording.wait();
    error_text = error_text_of([&] {
      Runner beside{std::make_unique<CudaStages>(small_config(), small_rig()), small_config(), small_rig()};
      beside.run(street.frame(0), 0);
      beside.run(street.frame(1), 0.1);
      compare_grids(beside.result, alone.result);
    });
    done.count_down();
  }};
  Cuda cuda;
  Graph graph;
  DeviceBuffer<float> numbers{4};
  graph.capture(cuda, [&] {
    clear(cuda, numbers.data(), numbers.size());
    recording.count_down();
    done.wait();
  });
  other.join();
  CHECK_EQUAL(error_text, "");
  graph.launch(cuda);
  cuda.synchronize();
}

void check_external(const Config& config) {
  const Street street{small_rig()};
  Runner matcher{law_stages(config, small_rig()), config, small_rig()};
  Pair pair{config, small_rig()};
  Random random{5};
  for (int index{0}; index < 3; ++index) {
    StereoFrame frame{street.frame(index)};
    matcher.run(frame, index == 0 ? 0 : 0.1);
    frame.right = {};
    frame.disparity = matcher.result.stages.obstacle_disparity;
    for (std::size_t i{0}; i < frame.disparity.size(); ++i) {
      frame.disparity.data()[i] += matcher.result.stages.road_disparity.data()[i];
    }
    if (index != 1) frame.other_grids.push_back({{0, -4, 0.8, 12, 10}, random.image(12, 10, 0, 1), {}});
    pair.run(frame);
  }
}

TEST(given_disparities_and_another_grid) {
  check_external(small_config());
}

// The local ground splits disparities and finds obstacles with either projection.
TEST(external_disparities_with_bins) {
  Config config{small_config()};
  config.projection.model = ProjectionModel::bins;
  check_external(config);
}

TEST(a_drive_without_terrain_equals_the_reference) {
  Config config{small_config()};
  config.ground.model = GroundModel::plane;
  check_drive(config);
}

// Disparities of stones on the ground before the camera.
Image<float> stones(Random& random) {
  constexpr double half_m{0.25};
  constexpr double height_m{0.2};
  const Rig rig{small_rig()};
  Image<float> disparity{rig.width_px, rig.height_px};
  for (int v{static_cast<int>(rig.cy_px) + 5}; v < rig.height_px; ++v) {
    for (int u{0}; u < rig.width_px; ++u) {
      const double down{(v - rig.cy_px) / rig.focal_px};
      const double left{(rig.cx_px - u) / rig.focal_px};
      double x_m{rig.camera_height_m / down};
      for (const Point2 stone : {Point2{6, -1}, Point2{5, 1}, Point2{4.5, -0.8}, Point2{4, 0.5}}) {
        const double up_m{rig.camera_height_m - down * stone.x};
        if (std::abs(left * stone.x - stone.y) < half_m && up_m >= 0 && up_m < height_m) x_m = stone.x;
      }
      disparity(u, v) = static_cast<float>(rig.focal_px * rig.baseline_m / x_m + random.between(-0.1, 0.1));
    }
  }
  return disparity;
}

int obstacle_cells(const FrameResult& result) {
  return static_cast<int>(std::ranges::count(result.terrain, TerrainClass::obstacle));
}

StereoFrame stony_frame(int index, Random& random) {
  StereoFrame frame{Street{small_rig()}.frame(index)};
  frame.right = {};
  frame.disparity = stones(random);
  return frame;
}

Config stony_config(double cell_m) {
  Config config{config_around()};
  config.grid.cell_size_m = cell_m;
  config.matching.disparities = 24;
  return config;
}

// With rejected frames: one without disparities, and one of equal images.
TEST(low_obstacles_equal_the_reference) {
  for (const double cell_m : {0.25, 0.2}) {
    Pair pair{stony_config(cell_m), small_rig()};
    Random random{8};
    for (int index{0}; index < 7; ++index) {
      StereoFrame frame{stony_frame(index, random)};
      if (index == 2) frame.disparity.fill(0);
      if (index == 4) {
        frame.disparity = {};
        frame.right = frame.left;
      }
      pair.run(frame);
      const bool is_usable{index != 2 && index != 4};
      CHECK_EQUAL(pair.law.result.status.empty(), is_usable);
      CHECK_EQUAL(obstacle_cells(pair.law.result) > 5, is_usable);
    }
  }
}

TEST(low_obstacles_of_two_cameras_equal_the_reference) {
  const std::vector<Rig> rigs{rigs_around(2)};
  RunnerAround gpu{rigs, true, stony_config(0.25)};
  RunnerAround law{rigs, false, stony_config(0.25)};
  Random random{9};
  for (int index{0}; index < 5; ++index) {
    std::vector<StereoFrame> seen{stony_frame(index, random), stony_frame(index, random)};
    if (index == 2) seen[1].left = {};
    if (index == 3) seen[0].left = {};
    for (RunnerAround* runner : {&gpu, &law}) runner->run(seen, {0.1 * index, 0, 0}, index == 0 ? 0 : 0.1);
    compare_cameras(gpu.result, law.result);
    compare_on_device(gpu.frames, gpu.result);
    CHECK_EQUAL(obstacle_cells(law.result.cameras[0]) > 5, index != 3);
    CHECK_EQUAL(obstacle_cells(law.result.cameras[1]) > 5, index != 2);
  }
}

TEST(masked_pixels_have_no_disparity) {
  Image<std::uint8_t> mask{width, height, 255};
  for (int v{60}; v < 70; ++v) {
    for (int u{v}; u < width; ++u) mask(u, v) = 0;
  }
  for (const bool is_given : {false, true}) {
    const Street street{small_rig()};
    Pair pair{small_config(), small_rig(), PixelMask{mask, LevelMapping{small_rig()}}};
    for (int index{0}; index < 4; ++index) {
      StereoFrame frame{street.frame(index)};
      if (is_given) {
        frame.right = {};
        frame.disparity = Image<float>{width, height, 7};
      }
      pair.run(frame);
      const StageImages& stages{pair.gpu.result.stages};
      CHECK_EQUAL(stages.obstacle_disparity(65, 65) + stages.road_disparity(65, 65), 0);
      CHECK_EQUAL(stages.match_confidence(80, 60), 0);
      CHECK(pair.gpu.result.obstacle_density + pair.gpu.result.road_density > 0.1);
    }
  }
}

TEST(what_was_saved_goes_on) {
  const Street street{small_rig()};
  Pair pair{small_config(), small_rig()};
  for (int index{0}; index < 3; ++index) pair.run(street.frame(index));
  StateWriter saved;
  pair.gpu.frames.exchange(saved);
  Pair other{small_config(), small_rig()};
  other.run(street.frame(0));
  StateReader state{saved.bytes()};
  other.gpu.frames.exchange(state);
  CHECK(state.fits());
  for (int index{3}; index < 5; ++index) {
    pair.run(street.frame(index));
    other.gpu.run(street.frame(index), 0.1);
    CHECK_EQUAL(differences(pair.gpu.result.world.occupancy, other.gpu.result.world.occupancy), 0);
    CHECK_EQUAL(differences(pair.gpu.result.world.velocity_x, other.gpu.result.world.velocity_x), 0);
    compare(pair.gpu.result.ground, other.gpu.result.ground);
    CHECK_EQUAL(pair.gpu.result.obstacles.size(), other.gpu.result.obstacles.size());
  }
}

// A frame's state lies where none has been before: what it does not write is as the constructor left it.
TEST(states_saved_after_the_same_frame_are_equal) {
  const Street street{small_rig()};
  StateWriter states[2];
  for (StateWriter& state : states) {
    Runner runner{std::make_unique<CudaStages>(small_config(), small_rig()), small_config(), small_rig()};
    runner.run(street.frame(0), 0);
    runner.frames.exchange(state);
  }
  CHECK(states[0].bytes() == states[1].bytes());
}

#if !defined(__CUDACC__)
TEST(kernels_are_loaded_at_construction) {
  const Street street{small_rig()};
  for (const char* name : {"default", "robot", "paper"}) {
    Config config{small_config()};
    config.filter.model = preset(name).filter.model;
    config.ground.model = preset(name).ground.model;
    config.projection.model = preset(name).projection.model;
    emulator::unload_kernels();
    Image<std::uint8_t> mask{width, height, 255};
    mask(5, 5) = 0;
    const StagesOptions options{.mask = PixelMask{mask, LevelMapping{small_rig()}}};
    Runner runner{std::make_unique<CudaStages>(config, small_rig(), 0, options), config, small_rig()};
    for (int index{0}; index < 3; ++index) {
      StereoFrame frame{street.frame(index)};
      if (index == 2) {
        frame.right = {};
        frame.disparity = Image<float>{width, height, 7};
        frame.other_grids.push_back({{0, -4, 0.8, 12, 10}, Image<float>{12, 10, 0.7f}, {}});
      }
      runner.run(frame, 0.1 * index);
    }
    CHECK_EQUAL(emulator::kernels_loaded_late(), 0);
  }
}
#endif

// As measurements of single kernels have it.
TEST(without_graphs_the_grids_are_the_same) {
  struct Count final : LaunchWatch {
    void begin(cudaStream_t, const void* kernel) override { begun += kernel != nullptr ? 1 : 0; }
    void end(cudaStream_t) override { CHECK_EQUAL(++ended, begun); }
    int begun{0};
    int ended{0};
  } count;
  const Street street{small_rig()};
  auto stages = std::make_unique<CudaStages>(small_config(), small_rig());
  stages->go_without_graphs(count);
  Runner without{std::move(stages), small_config(), small_rig()};
  Runner with{std::make_unique<CudaStages>(small_config(), small_rig()), small_config(), small_rig()};
  for (int index{0}; index < 3; ++index) {
    const int before{count.ended};
    without.run(street.frame(index), index == 0 ? 0 : 0.1);
    with.run(street.frame(index), index == 0 ? 0 : 0.1);
    compare_grids(without.result, with.result);
    CHECK(count.ended > before + 20);
  }
}

TEST(without_stages_the_grids_are_the_same) {
  const Street street{small_rig()};
  const StagesOptions without_images{.stage_images = false};
  Runner gpu{std::make_unique<CudaStages>(small_config(), small_rig(), 0, without_images), small_config(), small_rig()};
  Runner law{law_stages(small_config(), small_rig()), small_config(), small_rig()};
  for (int index{0}; index < 2; ++index) {
    const double dt_s{0.1 * index};
    gpu.run(street.frame(index), dt_s);
    law.run(street.frame(index), dt_s);
    compare_grids(gpu.result, law.result);
  }
  for (const float d : gpu.result.stages.obstacle_disparity) CHECK_EQUAL(d, 0);
}

TEST(memory_is_what_has_been_allocated) {
  const Config config{small_config()};
  const CudaBytes before{cuda_bytes_allocated()};
  CudaStages stages{config, small_rig()};
  const CudaBytes allocated{cuda_bytes_allocated() - before};
  CHECK_EQUAL(stages.memory_use().device_bytes, allocated.device);
  const auto cells = static_cast<std::size_t>(Window{vehicle_grid_of(config.grid)}.cells());
  const std::size_t states{2 * cells * cells * velocity_lattice(config.filter).size() * sizeof(float)};
  CHECK(allocated.device > states);
  CHECK(stages.memory_use().host_bytes > allocated.pinned + 3 * width * height * sizeof(float));
  const Street street{small_rig()};
  Runner runner{std::make_unique<CudaStages>(config, small_rig()), config, small_rig()};
  const CudaBytes at_start{cuda_bytes_allocated()};
  for (int index{0}; index < 2; ++index) runner.run(street.frame(index), 0.1 * index);
  CHECK_EQUAL((cuda_bytes_allocated() - at_start).device, std::size_t{0});
  CHECK_EQUAL((cuda_bytes_allocated() - at_start).pinned, std::size_t{0});
}

}  // namespace
}  // namespace stereogrid::test
