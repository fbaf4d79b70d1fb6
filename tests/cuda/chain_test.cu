// SPDX-License-Identifier: Apache-2.0
//
// Frame pipeline on the GPU against the reference back end.
#include <latch>
#include <thread>

#include "side_by_side.hpp"

namespace stereogrid::test {
namespace {

void check_drive(const Config& config) {
  const Street street{small_rig()};
  Pair pair{config, small_rig()};
  for (int index{0}; index < 4; ++index) pair.run(street.frame(index));
  const FrameResult& result{pair.law.result};
  CHECK(result.ground.estimated);
  CHECK(result.obstacle_density > 0.1 && result.road_density > 0.1);
  CHECK(!result.obstacles.empty());
}

TEST(a_drive_with_correlation_equals_the_reference) {
  check_drive(small_config());
}

TEST(a_drive_with_semi_global_matching_equals_the_reference) {
  Config config{small_config()};
  config.matching.method = MatchingMethod::semi_global;
  check_drive(config);
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

// The camera is pitched more than the road hypothesis reaches: the frame is searched and matched again.
// The pause after a search that failed is counted in frames, found ones too, on every back end.
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

TEST(given_disparities_and_another_grid) {
  const Street street{small_rig()};
  Config config{small_config()};
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
    for (const MatchingMethod method : {MatchingMethod::correlation, MatchingMethod::semi_global}) {
      Config config{small_config()};
      config.filter.model = preset(name).filter.model;
      config.ground.model = preset(name).ground.model;
      config.projection.model = preset(name).projection.model;
      config.matching.method = method;
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
