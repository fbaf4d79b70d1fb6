// SPDX-License-Identifier: Apache-2.0
//
// Equal to the bit: every back end and number of threads over whole drives, and a pipeline that loads the state of
// another one.
#include "chain_run.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid::test {
namespace {

constexpr std::size_t saved_after{7};
constexpr std::size_t frames{11};

Config small(const char* name) {
  Config config{preset(name)};
  config.grid.length_m = 8;
  config.grid.width_m = 6;
  config.filter.speeds_mps = {1.25, 2.5, 3.9};
  config.matching.disparities = 32;
  config.tracking.confirm_frames = 2;
  return config;
}

struct Case {
  const char* name;
  Config config;
  BackEnd back_end{BackEnd::cpu};
  bool with_poses{true};
  double camera_pitch_rad{0};
};

std::vector<Case> cases() {
  std::vector<Case> all{{"default", small("default")},
                        {"paper", small("paper")},
                        {"without poses", small("default"), BackEnd::cpu, false},
                        {"reference", small("default"), BackEnd::reference},
                        {"levelled", small("default"), BackEnd::cpu, true, 0.03}};
  return all;
}

class SavedState : public testing::TestWithParam<Case> {
 protected:
  SavedState() { rig.camera_pitch_rad = GetParam().camera_pitch_rad; }

  [[nodiscard]] Pipeline pipeline() const {
    return {GetParam().config, rig, {.back_end = GetParam().back_end, .threads = 2}};
  }

  const FrameResult& step(Pipeline& pipeline, std::size_t index) const {
    StereoFrame frame{scene.load(index)};
    if (!GetParam().with_poses && index > 1) frame.world_from_vehicle.reset();
    return pipeline.process(frame);
  }

  Scene scene{"crossing?width=192&height=120&frames=11"};
  Rig rig{scene.rig()};
};

TEST_P(SavedState, GoesOnBitForBit) {
  Pipeline first{pipeline()};
  for (std::size_t i{0}; i < saved_after; ++i) step(first, i);
  Pipeline second{pipeline()};
  step(second, 3);  // its own state is replaced
  second.load_state(first.save_state());
  bool has_obstacles{false};
  for (std::size_t i{saved_after}; i < frames; ++i) {
    SCOPED_TRACE(testing::Message() << "frame " << i);
    const FrameResult& expected{step(first, i)};
    expect_equal(expected, step(second, i));
    has_obstacles = has_obstacles || !expected.obstacles.empty();
  }
  EXPECT_TRUE(has_obstacles);
}

TEST_P(SavedState, OfAPipelineThatHasSeenNothingIsAnEmptyOne) {
  Pipeline fresh{pipeline()};
  Pipeline used{pipeline()};
  for (std::size_t i{0}; i < 3; ++i) step(used, i);
  used.load_state(fresh.save_state());
  for (std::size_t i{0}; i < 3; ++i) expect_equal(step(fresh, i), step(used, i));
}

INSTANTIATE_TEST_SUITE_P(Chain, SavedState, testing::ValuesIn(cases()), [](const auto& test) {
  std::string name{test.param.name};
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
});

struct Refusal : testing::Test {
  Refusal() {
    for (std::size_t i{0}; i < 3; ++i) drive.step(i);
    saved = drive.pipeline.save_state();
  }

  static void expect_refused(Pipeline& pipeline, std::span<const std::byte> bytes) {
    EXPECT_THROW(pipeline.load_state(bytes), InputError);
  }

  Drive drive{"crossing?width=96&height=64&frames=6", small("default")};
  std::vector<std::byte> saved;
};

TEST_F(Refusal, DamagedOrCutOffAndNothingHasChanged) {
  Drive twin{"crossing?width=96&height=64&frames=6", small("default")};
  for (std::size_t i{0}; i < 3; ++i) twin.step(i);
  for (const std::size_t place : {std::size_t{0}, std::size_t{9}, std::size_t{17}, std::size_t{25}, std::size_t{40},
                                  saved.size() / 2, saved.size() - 1}) {
    std::vector<std::byte> damaged{saved};
    damaged[place] ^= std::byte{4};
    expect_refused(twin.pipeline, damaged);
  }
  for (const std::size_t size : {std::size_t{0}, std::size_t{5}, std::size_t{32}, saved.size() / 2, saved.size() - 1}) {
    expect_refused(twin.pipeline, std::span{saved}.first(size));
  }
  std::vector<std::byte> longer{saved};
  longer.resize(saved.size() + 1);
  expect_refused(twin.pipeline, longer);
  for (std::size_t i{3}; i < 6; ++i) expect_equal(drive.step(i), twin.step(i));
}

TEST_F(Refusal, OfAnotherConfigurationRigOrBackEnd) {
  Config other{small("default")};
  other.filter.decay_time_s = 3;
  Pipeline other_config{other, drive.scene.rig()};
  expect_refused(other_config, saved);
  Rig rig{drive.scene.rig()};
  rig.baseline_m *= 1.001;
  Pipeline other_rig{small("default"), rig};
  expect_refused(other_rig, saved);
  Pipeline other_back_end{small("default"), drive.scene.rig(), {.back_end = BackEnd::reference}};
  expect_refused(other_back_end, saved);
}

TEST(ChainThreads, CpuEqualsReferenceOnAnyNumberOfThreads) {
  for (const char* name : {"paper", "default"}) {
    Config config{preset(name)};
    config.matching.window_px = 7;
    config.matching.disparities = 32;
    config.matching.speckle_px = config.matching.road_speckle_px = 10;
    config.grid.length_m = 8;
    config.grid.width_m = 6;
    config.filter.speeds_mps = {1.25, 2.5, 3.9};
    const char* scene{"street?width=123&height=77&frames=3"};
    Drive reference{scene, config, 1, BackEnd::reference};
    Drive one{scene, config, 1};
    Drive two{scene, config, 2};
    for (std::size_t i{0}; i < 3; ++i) {
      const FrameResult& expected{reference.step(i)};
      expect_equal(expected, one.step(i));
      expect_equal(expected, two.step(i));
    }
  }
}

TEST(ChainThreads, ResultsAreTheSameOnAnyNumberOfThreads) {
  const char* scene{"street?width=211&height=103&frames=4"};
  for (const int threads : {2, 3, 7}) {
    Drive one{scene, preset("default"), 1};
    Drive several{scene, preset("default"), threads};
    for (std::size_t i{0}; i < 4; ++i) {
      SCOPED_TRACE(testing::Message() << threads << " threads, frame " << i);
      const FrameResult& result{several.step(i)};
      expect_equal(one.step(i), result);
      EXPECT_GT(result.obstacle_density, 0.05);
      EXPECT_GT(result.road_density, 0.05);
    }
  }
}

TEST(ChainThreads, PipelinesInTwoThreadsDoNotDisturbEachOther) {
  const char* scene{"street?width=211&height=103&frames=4"};
  const Config other{preset("paper")};
  Drive alone{scene};
  Drive other_alone{scene, other};
  Drive beside{scene};
  Drive other_beside{scene, other};
  for (std::size_t i{0}; i < 4; ++i) {
    const FrameResult* others{nullptr};
    std::thread thread{[&] { others = &other_beside.step(i); }};
    const FrameResult& result{beside.step(i)};
    thread.join();
    SCOPED_TRACE(testing::Message() << "frame " << i);
    expect_equal(alone.step(i), result);
    expect_equal(other_alone.step(i), *others);
  }
}

}  // namespace
}  // namespace stereogrid::test
