// SPDX-License-Identifier: Apache-2.0
//
// Memory that runs out in process() and load_state(), at every allocation.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <limits>
#include <new>
#include <vector>

#include "stereogrid/pipeline.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace {

constexpr int no_limit{std::numeric_limits<int>::max()};
std::atomic<int> allocations_left{no_limit};  // calls of operator new, in all threads

void* allocated(std::size_t bytes, std::size_t alignment) {
  if (allocations_left != no_limit && allocations_left.fetch_sub(1) <= 0) {
    allocations_left = 0;  // the next ones fail, too
    throw std::bad_alloc{};
  }
  void* const memory{std::aligned_alloc(alignment, bytes / alignment * alignment + alignment)};
  if (memory == nullptr) throw std::bad_alloc{};
  return memory;
}

}  // namespace

void* operator new(std::size_t bytes) {
  return allocated(bytes, alignof(std::max_align_t));
}
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  return allocated(bytes, static_cast<std::size_t>(alignment));
}
// not inlined: the compiler would take free() for the wrong counterpart of new
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t /*bytes*/) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t /*alignment*/) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t /*bytes*/, std::align_val_t /*alignment*/) noexcept {
  std::free(memory);
}

namespace stereogrid::test {
namespace {

// Returns whether `work` has run out of memory after that number of allocations.
template <class Work>
bool runs_out(int allocations, const Work& work) {
  allocations_left = allocations;
  bool has_failed{false};
  try {
    work();
  } catch (const std::bad_alloc&) {
    has_failed = true;
  }
  allocations_left = no_limit;
  return has_failed;
}

struct Street {
  explicit Street(const char* scene_text = "street?width=160&height=96&frames=6")
      : scene{scenes::parse_scene(scene_text), 2} {
    config.grid = {12, 8, 0.5};
    config.matching.disparities = 32;
    config.filter.speeds_mps = {1.25, 2.5};
  }

  [[nodiscard]] Pipeline pipeline(std::size_t frames) const {
    Pipeline made{config, rig, options};
    for (std::size_t i{0}; i < frames; ++i) made.process(scene.load(i));
    return made;
  }

  scenes::Scene scene;
  Config config{preset("default")};
  Rig rig{scene.rig()};
  PipelineOptions options{.threads = 2};
};

/// Extrinsics that the first frame replaces.
struct PitchedStreet : Street {
  PitchedStreet() : Street{"street?width=320&height=200&pitch_deg=8&camera_height=1.0&frames=6"} {
    rig.camera_height_m = 1.65;
    rig.camera_pitch_rad = 0;
    options.extrinsics_given = false;
  }
};

TEST(Failing, AFrameForWhichMemoryRunsOutMayBeGivenAgain) {
  const Street street;
  const StereoFrame frame{street.scene.load(2)};
  Pipeline going_on{street.pipeline(2)};
  const Image<float> expected{going_on.process(frame).world.occupancy};
  Pipeline resets{street.pipeline(2)};
  resets.reset();
  const Image<float> expected_resets{resets.process(frame).world.occupancy};
  ASSERT_NE(expected, expected_resets);
  int allocations{0};
  for (bool fails{true}; fails; ++allocations) {
    SCOPED_TRACE(testing::Message() << "after " << allocations << " allocations");
    Pipeline pipeline{street.pipeline(2)};
    FrameResult result;
    fails = runs_out(allocations, [&] { pipeline.process(frame, result); });
    if (!fails) break;
    ASSERT_NO_THROW(pipeline.process(frame, result));
    EXPECT_TRUE(result.world.occupancy == expected || result.world.occupancy == expected_resets);
    EXPECT_EQ(result.world_from_vehicle, *frame.world_from_vehicle);
  }
  EXPECT_GT(allocations, 10) << "those of a new result";
}

// All stages are allocated again.
TEST(Failing, AFrameThatReplacesTheExtrinsicsMayBeGivenAgain) {
  const PitchedStreet street;
  const StereoFrame frame{street.scene.load(0)};
  Pipeline whole{street.pipeline(0)};
  const Image<float> expected{whole.process(frame).world.occupancy};
  ASSERT_NE(whole.next_rig(), street.rig);
  for (int allocations{0};; allocations += 40) {
    SCOPED_TRACE(testing::Message() << "after " << allocations << " allocations");
    Pipeline pipeline{street.pipeline(0)};
    FrameResult result;
    if (!runs_out(allocations, [&] { pipeline.process(frame, result); })) break;
    ASSERT_NO_THROW(pipeline.process(frame, result));
    EXPECT_EQ(result.world.occupancy, expected);
    EXPECT_EQ(pipeline.next_rig(), whole.next_rig());
  }
}

// `step`: allocations from one attempt to the next.
void expect_unchanged(Pipeline& pipeline, const std::vector<std::byte>& saved, int step) {
  const std::vector<std::byte> before{pipeline.save_state()};
  const Rig rig_before{pipeline.next_rig()};
  ASSERT_NE(before, saved);
  int failures{0};
  while (runs_out(failures * step, [&] { pipeline.load_state(saved); })) {
    ++failures;
    ASSERT_EQ(pipeline.save_state(), before) << "after " << (failures - 1) * step << " allocations";
    ASSERT_EQ(pipeline.next_rig(), rig_before);
  }
  EXPECT_EQ(pipeline.save_state(), saved);
  EXPECT_GT(failures, 10);
}

TEST(Failing, AStateForWhichMemoryRunsOutIsNotLoaded) {
  const Street street;
  Pipeline pipeline{street.pipeline(2)};
  expect_unchanged(pipeline, street.pipeline(5).save_state(), 3);
}

TEST(Failing, AStateOfOtherExtrinsicsForWhichMemoryRunsOutIsNotLoaded) {
  const PitchedStreet street;
  const Pipeline found{street.pipeline(2)};
  ASSERT_NE(found.next_rig(), street.rig);
  Pipeline fresh{street.pipeline(0)};
  expect_unchanged(fresh, found.save_state(), 20);
  EXPECT_EQ(fresh.next_rig(), found.next_rig());
}

}  // namespace
}  // namespace stereogrid::test
