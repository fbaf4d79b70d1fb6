// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// The whole way of a frame on the GPU against the reference back end.
#include "pipeline/cuda/stages.hpp"

#include <algorithm>
#include <latch>
#include <memory>
#include <thread>

#include "check.hpp"
#include "images.hpp"
#include "pipeline/frame_processor.hpp"
#include "pipeline/results.hpp"
#include "street.hpp"

namespace stereogrid::test {
namespace {

constexpr int width{125};
constexpr int height{86};

Config small_config() {
  Config config{preset("default")};
  config.grid = {10, 8, 0.5};
  config.matching.disparities = 16;
  config.matching.speckle_px = 20;
  config.filter.velocity_max_mps = 4;
  config.tracking.occupancy_min = 0.6;
  return config;
}

/// A back end, and what it found last.
struct Runner {
  Runner(std::unique_ptr<Stages> stages, const Config& config, const Rig& rig)
      : processor{config, rig, std::move(stages)}, result{empty_result(config, rig)} {}

  void run(const StereoFrame& frame, double dt_s) {
    result.status.clear();
    result.warnings.clear();
    processor.run({frame.left.view(), frame.right.view(), frame.disparity.view(), *frame.world_from_vehicle, dt_s,
                   frame.other_grids},
                  result);
  }

  FrameProcessor processor;
  FrameResult result;
};

void compare(const StageImages& gpu, const StageImages& law) {
  CHECK_EQUAL(differences(gpu.obstacle_disparity, law.obstacle_disparity), 0);
  CHECK_EQUAL(differences(gpu.road_disparity, law.road_disparity), 0);
  CHECK_EQUAL(differences(gpu.match_confidence, law.match_confidence), 0);
  CHECK(gpu.possible == law.possible);
  CHECK_EQUAL(differences(gpu.visible, law.visible), 0);
  CHECK_EQUAL(differences(gpu.observed, law.observed), 0);
  CHECK_EQUAL(differences(gpu.visibility, law.visibility), 0);
  CHECK_EQUAL(differences(gpu.obstacle_confidence, law.obstacle_confidence), 0);
  CHECK_EQUAL(differences(gpu.road_confidence, law.road_confidence), 0);
  CHECK_EQUAL(differences(gpu.occupancy, law.occupancy), 0);
  CHECK_EQUAL(differences(gpu.occupancy_smooth, law.occupancy_smooth), 0);
}

// The ground is summed in another order; what comes of it is rounded before it is used (ground/cuda.hpp).
void compare(const Ground& gpu, const Ground& law) {
  CHECK_EQUAL(gpu.estimated, law.estimated);
  CHECK_NEAR(gpu.height_m, law.height_m, 1e-6);
  CHECK_NEAR(gpu.pitch_rad, law.pitch_rad, 1e-6);
  CHECK_NEAR(gpu.roll_rad, law.roll_rad, 1e-6);
}

// tay2008's sum over all velocities is formed in another order (filter/cuda.hpp); what comes of it is divided by it.
void compare_nearly(const FrameResult& gpu, const FrameResult& law) {
  constexpr double bound{1e-5};
  compare(gpu.stages, law.stages);
  CHECK_EQUAL(differences(gpu.observed, law.observed), 0);
  CHECK_EQUAL(differences(gpu.world.age_s, law.world.age_s), 0);
  CHECK_NEAR(largest_difference(gpu.world.occupancy, law.world.occupancy), 0, bound);
  CHECK_NEAR(largest_difference(gpu.world.velocity_x, law.world.velocity_x), 0, bound);
  CHECK_NEAR(largest_difference(gpu.occupancy, law.occupancy), 0, bound);
  CHECK_EQUAL(gpu.obstacles.size(), law.obstacles.size());
}

void compare_grids(const FrameResult& gpu, const FrameResult& law) {
  CHECK_EQUAL(differences(gpu.observed, law.observed), 0);
  CHECK(gpu.world.geometry == law.world.geometry);
  CHECK_EQUAL(differences(gpu.world.occupancy, law.world.occupancy), 0);
  CHECK_EQUAL(differences(gpu.world.age_s, law.world.age_s), 0);
  CHECK_EQUAL(differences(gpu.world.velocity_x, law.world.velocity_x), 0);
  CHECK_EQUAL(differences(gpu.world.velocity_xy, law.world.velocity_xy), 0);
  CHECK_EQUAL(differences(gpu.occupancy, law.occupancy), 0);
  CHECK_EQUAL(differences(gpu.velocity_y, law.velocity_y), 0);
  CHECK_EQUAL(differences(gpu.moving, law.moving), 0);
  CHECK_EQUAL(differences(gpu.age_s, law.age_s), 0);
  CHECK_EQUAL(gpu.obstacles.size(), law.obstacles.size());
  for (std::size_t i{0}; i < gpu.obstacles.size() && i < law.obstacles.size(); ++i) {
    CHECK_EQUAL(gpu.obstacles[i].id, law.obstacles[i].id);
    CHECK_EQUAL(gpu.obstacles[i].x_m, law.obstacles[i].x_m);
    CHECK_EQUAL(gpu.obstacles[i].vx_mps, law.obstacles[i].vx_mps);
  }
}

void compare(const FrameResult& gpu, const FrameResult& law) {
  compare(gpu.stages, law.stages);
  compare(gpu.ground, law.ground);
  compare_grids(gpu, law);
  CHECK_EQUAL(gpu.obstacle_density, law.obstacle_density);
  CHECK_EQUAL(gpu.road_density, law.road_density);
  CHECK(gpu.status == law.status);
  CHECK(gpu.warnings == law.warnings);
}

/// Both back ends side by side.
class Pair {
 public:
  Pair(const Config& config, const Rig& rig)
      : gpu{std::make_unique<CudaStages>(config, rig), config, rig}, law{reference_stages(config, rig), config, rig} {}

  void run(const StereoFrame& frame) {
    const double dt_s{frame.index == 0 ? 0 : 0.1};
    gpu.run(frame, dt_s);
    law.run(frame, dt_s);
    is_equal_to_the_bit ? compare(gpu.result, law.result) : compare_nearly(gpu.result, law.result);
  }

  Runner gpu;
  Runner law;
  bool is_equal_to_the_bit{true};
};

Rig small_rig() {
  return Street::rig(width, height);
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
  config.filter.velocity_max_mps = 2;
  const Street street{small_rig()};
  Pair pair{config, small_rig()};
  pair.is_equal_to_the_bit = false;
  for (int index{0}; index < 2; ++index) pair.run(street.frame(index));
}

// The camera is pitched more than the road hypothesis reaches: the frame is searched and matched again.
TEST(a_road_that_is_lost_is_found_again) {
  const Street level{small_rig()};
  const Street pitched{small_rig(), 0.07};
  Config config{small_config()};
  config.ground.pitch_gate_deg = 10;
  Pair pair{config, small_rig()};
  pair.run(level.frame(0));
  for (int index{1}; index < 5; ++index) pair.run(pitched.frame(index));
  CHECK(pair.law.result.ground.pitch_rad > 0.03);
}

// The pause after a search that failed is counted in frames, found ones too, on every back end.
TEST(a_search_that_fails_pauses_for_the_same_frames) {
  const Street level{small_rig()};
  const Street unbelievable{small_rig(), 0.25};
  const Street pitched{small_rig(), 0.07};
  Config config{small_config()};
  config.ground.pitch_gate_deg = 6;
  for (const int found_between : {0, 1, 2, 3}) {
    Pair pair{config, small_rig()};
    int index{0};
    pair.run(level.frame(index++));
    pair.run(unbelievable.frame(index++));
    CHECK(!pair.law.result.ground.estimated);
    for (int i{0}; i < found_between; ++i) pair.run(level.frame(index++));
    const int found_at{std::max(3 - found_between, 1)};
    for (int i{1}; i <= 4; ++i) {
      pair.run(pitched.frame(index++));
      CHECK_EQUAL(pair.law.result.ground.pitch_rad > 0.03, i >= found_at);
    }
  }
}

TEST(one_is_constructed_while_another_thread_records_a_graph) {
  const Street street{small_rig()};
  Runner alone{std::make_unique<CudaStages>(small_config(), small_rig()), small_config(), small_rig()};
  for (int index{0}; index < 2; ++index) alone.run(street.frame(index), 0.1 * index);
  std::latch recording{1};
  std::latch done{1};
  std::string complaint;
  std::thread other{[&] {
    recording.wait();
    complaint = complaint_of([&] {
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
  CHECK_EQUAL(complaint, "");
  graph.launch(cuda);
  cuda.synchronize();
}

TEST(rows_that_are_off_are_put_right) {
  const Street street{small_rig()};
  Pair pair{small_config(), small_rig()};
  for (int index{0}; index < 3; ++index) {
    StereoFrame frame{street.frame(index)};
    for (int v{height - 1}; v > 0; --v) std::copy_n(frame.right.row(v - 1), width, frame.right.row(v));
    pair.run(frame);
  }
  CHECK(pair.law.result.obstacle_density > 0.1);
}

TEST(given_disparities_and_another_grid) {
  const Street street{small_rig()};
  Config config{small_config()};
  Runner matcher{reference_stages(config, small_rig()), config, small_rig()};
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

TEST(after_forgetting_the_next_frame_is_a_first_one) {
  const Street street{small_rig()};
  Pair pair{small_config(), small_rig()};
  for (int index{0}; index < 3; ++index) pair.run(street.frame(index));
  pair.gpu.processor.forget();
  pair.law.processor.forget();
  Runner fresh{reference_stages(small_config(), small_rig()), small_config(), small_rig()};
  for (int index{0}; index < 2; ++index) {
    StereoFrame frame{street.frame(index + 3)};
    frame.index = index;
    pair.run(frame);
    fresh.run(frame, index == 0 ? 0 : 0.1);
    CHECK_EQUAL(differences(pair.gpu.result.world.occupancy, fresh.result.world.occupancy), 0);
    CHECK_EQUAL(differences(pair.gpu.result.world.age_s, fresh.result.world.age_s), 0);
    CHECK_EQUAL(differences(pair.gpu.result.world.velocity_x, fresh.result.world.velocity_x), 0);
    compare(pair.gpu.result.ground, fresh.result.ground);
    CHECK_EQUAL(pair.gpu.result.obstacles.size(), fresh.result.obstacles.size());
  }
}

TEST(what_was_saved_goes_on) {
  const Street street{small_rig()};
  Pair pair{small_config(), small_rig()};
  for (int index{0}; index < 3; ++index) pair.run(street.frame(index));
  StateWriter saved;
  pair.gpu.processor.save(saved);
  Pair other{small_config(), small_rig()};
  other.run(street.frame(0));
  StateReader state{saved.bytes()};
  other.gpu.processor.load(state);
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

// A good frame, two that cannot be relied on, one of them with another source's grid, and good ones again.
TEST(what_cannot_be_relied_on_is_unknown) {
  const Street street{small_rig()};
  Random random{7};
  Pair pair{small_config(), small_rig()};
  for (int index{0}; index < 5; ++index) {
    StereoFrame frame{street.frame(index)};
    if (index == 1) frame.right = frame.left;
    if (index == 2) frame.right.fill(9);
    if (index == 2) frame.other_grids.push_back({{0, -4, 0.8, 12, 10}, random.image(12, 10, 0, 1), {}});
    pair.run(frame);
    const FrameResult& result{pair.law.result};
    const bool is_known{index != 1 && index != 2};
    CHECK_EQUAL(result.status.size(), is_known ? 0U : 1U);
    if (!is_known && !result.status.empty()) {
      CHECK(result.status.front() == FrameStatus::few_matches);
    }
    if (index == 1) CHECK(result.observed == Image<float>(20, 16, 0.5f));
    if (index == 2) CHECK(!(result.observed == Image<float>(20, 16, 0.5f)));
  }
}

TEST(a_drive_that_begins_with_nothing) {
  const Street street{small_rig()};
  Pair pair{small_config(), small_rig()};
  for (int index{0}; index < 3; ++index) {
    StereoFrame frame{street.frame(index)};
    if (index == 0) frame.right = frame.left;
    pair.run(frame);
    CHECK_EQUAL(pair.law.result.status.size(), index == 0 ? 1U : 0U);
  }
}

TEST(without_stages_the_grids_are_the_same) {
  const Street street{small_rig()};
  Pair pair{small_config(), small_rig()};
  pair.gpu.processor.stages().fetch_stages(false);
  for (int index{0}; index < 2; ++index) {
    const double dt_s{0.1 * index};
    pair.gpu.run(street.frame(index), dt_s);
    pair.law.run(street.frame(index), dt_s);
    compare_grids(pair.gpu.result, pair.law.result);
  }
  for (const float d : pair.gpu.result.stages.obstacle_disparity) CHECK_EQUAL(d, 0);
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

TEST(settings_that_only_the_cpu_can_do) {
  Config config{small_config()};
  config.filter.model = FilterModel::particles;
  CHECK(complaint_of([&] { CudaStages{config, small_rig()}; }).find("CPU only") != std::string::npos);
}

}  // namespace
}  // namespace stereogrid::test
