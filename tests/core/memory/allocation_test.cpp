// SPDX-License-Identifier: Apache-2.0
//
// Pipeline::process() on the CPU does not allocate on a busy street, with any settings, except for the text of a
// warning. oneTBB's pool of memory for tasks calls malloc more and more rarely; its allocations are separate
// (allocations.hpp) and only have to be few.
#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <utility>

#include "allocations.hpp"
#include "stereogrid/pipeline.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace stereogrid::test {
namespace {

constexpr std::size_t frames{30};
constexpr std::size_t warm_up_frames{10};
constexpr int of_tbb_max{5};  // a frame

struct Recording {
  Rig rig;
  std::vector<StereoFrame> frames;
};

Recording record(const char* scene_text, bool is_given) {
  const scenes::Scene scene{scenes::parse_scene(scene_text), 2};
  Recording recording{scene.rig(), {}};
  for (std::size_t i{0}; i < frames; ++i) {
    recording.frames.push_back(scene.load(i));
    if (!is_given) continue;
    recording.frames.back().right = {};
    recording.frames.back().disparity = scene.truth(i).disparity;
  }
  return recording;
}

constexpr const char* street{"street?width=320&height=160&frames=30"};
constexpr const char* pitched_street{"street?width=320&height=160&frames=30&pitch_deg=4"};

void without_poses(Recording& recording) {
  for (StereoFrame& frame : recording.frames) frame.world_from_vehicle.reset();
}

void with_gaps_in_poses(Recording& recording) {
  for (std::size_t i{2}; i < recording.frames.size(); i += 3) recording.frames[i].world_from_vehicle.reset();
}

// Seen by another source: a wall that comes nearer.
void with_other_grids(Recording& recording) {
  for (std::size_t i{0}; i < recording.frames.size(); ++i) {
    Image<float> cells{60, 40, 0.5f};
    for (int iy{10}; iy < 30; ++iy) cells(50 - static_cast<int>(i), iy) = 0.9f;
    recording.frames[i].other_grids.push_back({{2, -6, 0.3, 60, 40}, cells, {}});
    recording.frames[i].other_grids.push_back({{0, -4, 0.2, 60, 40}, cells, Image<float>{60, 40, 0.7f}});
  }
}

// Nothing matches in the frames before those that count: what grows with the data has not grown yet.
void blank_at_first(Recording& recording) {
  for (std::size_t i{0}; i < warm_up_frames; ++i) {
    StereoFrame& frame{recording.frames[i]};
    frame.left.fill(128);
    frame.right.fill(128);
    frame.disparity.fill(0);
  }
}

void as_it_is(Recording& /*recording*/) {}

// The lowest rows; none: empty.
Image<std::uint8_t> mask_of(const Rig& rig, int rows) {
  if (rows == 0) return {};
  Image<std::uint8_t> mask{rig.width_px, rig.height_px, 1};
  for (int v{rig.height_px - rows}; v < rig.height_px; ++v) std::fill_n(mask.row(v), rig.width_px, std::uint8_t{0});
  return mask;
}

using Settings = std::vector<std::pair<const char*, const char*>>;

struct Case {
  const char* name;
  const char* preset{"default"};
  Settings settings{};
  const char* scene{street};
  bool is_given{false};
  void (*change)(Recording&){as_it_is};
  int threads{2};
  bool fetches_stages{true};
  bool has_own_results{false};  ///< two, in turn
  std::vector<double> horizons_s{};
  int masked_rows{0};
};

void PrintTo(const Case& one, std::ostream* out) {
  *out << one.name;
}

const std::vector<Case>& cases() {
  static const std::vector<Case> all{
      {.name = "Default"},
      {.name = "DefaultOnOneThread", .threads = 1},
      {.name = "DefaultOnMoreThreadsThanCores", .threads = 5},
      {.name = "Paper", .preset = "paper"},
      {.name = "PaperOnOneThread", .preset = "paper", .threads = 1},
      {.name = "Tay2008", .settings = {{"filter.model", "tay2008"}}},
      {.name = "WithoutSceneFlow", .settings = {{"filter.scene_flow", "false"}}},
      {.name = "Bins", .settings = {{"projection.model", "bins"}}},
      {.name = "WithoutStages", .fetches_stages = false},
      {.name = "OwnResults", .has_own_results = true},
      {.name = "OwnResultsWithoutStages", .fetches_stages = false, .has_own_results = true},
      {.name = "OwnResultsWithPredictions", .has_own_results = true, .horizons_s = {0.5, 1}},
      {.name = "Predictions", .horizons_s = {0.5, 1}},
      {.name = "GivenDisparities", .is_given = true},
      {.name = "OtherGrids", .change = with_other_grids},
      {.name = "Pitched", .scene = pitched_street},
      {.name = "PitchedGivenDisparities", .scene = pitched_street, .is_given = true},
      {.name = "Masked", .masked_rows = 20},
      {.name = "PitchedMasked", .scene = pitched_street, .masked_rows = 20},
      {.name = "MaskedGivenDisparities", .is_given = true, .masked_rows = 20},
      {.name = "BlankAtFirst", .change = blank_at_first},
      {.name = "BlankAtFirstGivenDisparities", .is_given = true, .change = blank_at_first},
      {.name = "WithoutPoses", .change = without_poses},
      {.name = "WithGapsInPoses", .change = with_gaps_in_poses},
  };
  return all;
}

// In all frames that count: those after the first ones, but where there is something to warn of.
struct Found {
  void add_frame(Pipeline& pipeline, const StereoFrame& frame, bool has_own_results) {
    start_counting();
    if (has_own_results) {
      std::swap(now, before);
      pipeline.process(frame, now);
    }
    const FrameResult& result{has_own_results ? now : pipeline.process(frame)};
    const Allocations allocations{stop_counting()};
    obstacles += result.obstacles.size();
    if (++processed <= warm_up_frames || !result.warnings.empty()) return;
    ++counted;
    count += allocations.count;
    of_tbb += allocations.of_tbb;
    bytes += allocations.bytes;
    for (const std::string& way : allocations.where) where += "\n  " + way;
  }

  FrameResult now;
  FrameResult before;
  std::size_t processed{0};
  std::size_t obstacles{0};
  int counted{0};
  int count{0};
  int of_tbb{0};
  std::size_t bytes{0};
  std::string where;
};

class Allocation : public testing::TestWithParam<Case> {};

TEST_P(Allocation, NoneOnceThePipelineRuns) {
  if (!can_count_allocations()) GTEST_SKIP() << "malloc cannot be counted under a sanitizer, nor without glibc";
  const Case& one{GetParam()};
  Recording recording{record(one.scene, one.is_given)};
  one.change(recording);
  Config config{preset(one.preset)};
  for (const auto& [key, value] : one.settings) set(config, key, value);
  std::size_t reported{0};
  Pipeline pipeline{config,
                    recording.rig,
                    {.threads = one.threads,
                     .stages = one.fetches_stages,
                     .horizons_s = one.horizons_s,
                     .mask = mask_of(recording.rig, one.masked_rows),
                     .on_grids = [&reported](const FrameResult&) { ++reported; }}};
  Found found;
  for (const StereoFrame& frame : recording.frames) found.add_frame(pipeline, frame, one.has_own_results);
  RecordProperty("allocations", found.count);
  RecordProperty("bytes", std::to_string(found.bytes));
  RecordProperty("of_tbb", found.of_tbb);
  EXPECT_EQ(reported, frames);
  EXPECT_EQ(found.count, 0) << "in " << found.counted << " frames, " << found.bytes << " bytes, by" << found.where;
  EXPECT_LE(found.of_tbb, of_tbb_max * found.counted);
  EXPECT_GT(found.counted, 10);
  EXPECT_GT(found.obstacles, 2 * frames) << "the street is not busy";
}

INSTANTIATE_TEST_SUITE_P(, Allocation, testing::ValuesIn(cases()),
                         [](const auto& run) { return std::string{run.param.name}; });

// The counter sees allocations of this test.
TEST(AllocationCount, SeesWhatIsAllocated) {
  if (!can_count_allocations()) GTEST_SKIP() << "malloc cannot be counted under a sanitizer, nor without glibc";
  const std::ptrdiff_t before{live_bytes()};
  start_counting();
  static const std::vector<int>* numbers;  // static: or the compiler may leave new and delete away
  numbers = new std::vector<int>(1000);
  Allocations found{stop_counting()};
  EXPECT_EQ(found.count, 2);
  EXPECT_EQ(found.bytes, sizeof(std::vector<int>) + 1000 * sizeof(int));
  EXPECT_GE(live_bytes() - before, 4000);
  delete numbers;
  EXPECT_LT(live_bytes() - before, 4000);
}

// The program's other parts allocate little beside: what oneTBB keeps, and malloc's own rounding.
constexpr double error_max{0.005};

struct MemoryCase {
  const char* name;
  std::vector<std::pair<const char*, const char*>> settings{};
  int threads{2};
  std::vector<double> horizons_s{};
  bool is_masked{false};
};

void PrintTo(const MemoryCase& one, std::ostream* out) {
  *out << one.name;
}

class Memory : public testing::TestWithParam<MemoryCase> {};

// The pipeline's held bytes equal those of malloc, before the first frame and after ten.
TEST_P(Memory, IsWhatThePipelineSays) {
  if (!can_count_allocations()) GTEST_SKIP() << "malloc cannot be counted under a sanitizer, nor without glibc";
  const MemoryCase& one{GetParam()};
  const scenes::Scene scene{scenes::parse_scene("street?width=320&height=160&frames=10"), 2};
  std::vector<StereoFrame> recording;
  for (std::size_t i{0}; i < scene.size(); ++i) recording.push_back(scene.load(i));
  Config config{preset("default")};
  for (const auto& [key, value] : one.settings) set(config, key, value);

  Image<std::uint8_t> mask;
  if (one.is_masked) mask = Image<std::uint8_t>{320, 160, 1};
  if (one.is_masked) mask(160, 150) = 0;
  const std::ptrdiff_t before{live_bytes()};
  Pipeline pipeline{config, scene.rig(), {.threads = one.threads, .horizons_s = one.horizons_s, .mask = mask}};
  const auto said{static_cast<double>(pipeline.memory_use().host_bytes)};
  EXPECT_NEAR(static_cast<double>(live_bytes() - before), said, error_max * said) << "at construction";
  for (const StereoFrame& frame : recording) pipeline.process(frame);
  EXPECT_NEAR(static_cast<double>(live_bytes() - before), said, error_max * said) << "after ten frames";
  EXPECT_EQ(static_cast<double>(pipeline.memory_use().host_bytes), said);
  EXPECT_EQ(pipeline.memory_use().device_bytes, 0u);
  RecordProperty("bytes", std::to_string(pipeline.memory_use().host_bytes));
}

INSTANTIATE_TEST_SUITE_P(, Memory,
                         testing::Values(MemoryCase{.name = "Default"}, MemoryCase{.name = "FiveThreads", .threads = 5},
                                         MemoryCase{.name = "Tay2008", .settings = {{"filter.model", "tay2008"}}},
                                         // with little else, so that the small things count
                                         MemoryCase{.name = "FewVelocities",
                                                    .settings = {{"filter.speeds_mps", "1.25"}}},
                                         MemoryCase{.name = "Bins", .settings = {{"projection.model", "bins"}}},
                                         MemoryCase{.name = "Predictions", .horizons_s = {0.5, 1}},
                                         // the mask and its level image: 0.1 MB of 11
                                         MemoryCase{.name = "Masked", .is_masked = true}),
                         [](const auto& one) { return std::string{one.param.name}; });

TEST(MemoryOfPipelines, OfALargerPipelineIsMore) {
  const Rig rig{scenes::Scene{scenes::parse_scene("street?width=320&height=160&frames=1"), 1}.rig()};
  const auto bytes = [&](const char* key, const char* value) {
    Config config{preset("default")};
    set(config, key, value);
    return Pipeline{config, rig, {.threads = 1}}.memory_use().host_bytes;
  };
  EXPECT_GT(bytes("grid.length_m", "30"), bytes("grid.length_m", "20"));
  EXPECT_GT(bytes("filter.speeds_mps", "1,2,4,8"), bytes("filter.speeds_mps", "1"));
}

}  // namespace
}  // namespace stereogrid::test
