// SPDX-License-Identifier: Apache-2.0
//
// The whole pipeline on images smaller than its windows and narrower than its disparities.
#include "stereogrid/error.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

struct Run {
  Rig rig;
  bool has_disparities{false};
};

Rig rig_of(int width, int height) {
  Rig rig{small_kitti_rig()};
  rig.width_px = width;
  rig.height_px = height;
  rig.cx_px = width / 2.0;
  rig.cy_px = height / 2.0;
  return rig;
}

StereoFrame noise_frame(const Run& run, int index) {
  std::mt19937 generator{static_cast<unsigned>(137 + index)};
  StereoFrame frame;
  frame.name = std::to_string(index);
  frame.stamp_ns = 100'000'000 * (index + 1);
  frame.left = noise_image(run.rig.width_px, run.rig.height_px, generator);
  if (run.has_disparities) {
    frame.disparity = Image<float>{run.rig.width_px, run.rig.height_px, 5.5f};
  } else {
    frame.right = noise_image(run.rig.width_px, run.rig.height_px, generator);
  }
  return frame;
}

Config small_config() {
  Config config{preset("default")};
  config.matching.disparities = 64;
  config.grid.length_m = 6;
  config.grid.width_m = 4;
  config.filter.speeds_mps = {1.25, 2.5};
  return config;
}

void expect_equal_to_reference(const Run& run) {
  const Config config{small_config()};
  Pipeline reference{config, run.rig, {.back_end = BackEnd::reference}};
  Pipeline cpu{config, run.rig, {.threads = 3}};
  for (int i{0}; i < 2; ++i) {
    const FrameResult& expected{reference.process(noise_frame(run, i))};
    const FrameResult& actual{cpu.process(noise_frame(run, i))};
    EXPECT_EQ(expected.ground, actual.ground);
    EXPECT_EQ(expected.stages.obstacle_disparity, actual.stages.obstacle_disparity);
    EXPECT_EQ(expected.stages.road_disparity, actual.stages.road_disparity);
    EXPECT_EQ(expected.observed, actual.observed);
    EXPECT_EQ(expected.vehicle.occupancy, actual.vehicle.occupancy);
  }
}

TEST(PipelineSizes, AnyImageWorks) {
  for (const Rig& rig : {rig_of(1, 1), rig_of(1, 33), rig_of(33, 1), rig_of(2, 2), rig_of(7, 5), rig_of(63, 12)}) {
    SCOPED_TRACE(std::to_string(rig.width_px) + " × " + std::to_string(rig.height_px));
    for (const bool has_disparities : {false, true}) expect_equal_to_reference({rig, has_disparities});
  }
}

TEST(PipelineSizes, AnyImageWorksWithATiltedCamera) {
  for (Rig rig : {rig_of(1, 1), rig_of(33, 1), rig_of(7, 5)}) {
    rig.camera_pitch_rad = 0.1;
    rig.camera_roll_rad = 0.05;
    expect_equal_to_reference({rig});
  }
}

TEST(PipelineSizes, SaysThatAnImageIsTooLarge) {
  const std::string text{test::error_text_of<ConfigError>([] { Pipeline{preset("default"), rig_of(16385, 10)}; })};
  EXPECT_NE(text.find("16384"), std::string::npos) << text;
}

TEST(Pipeline, StagesThatNobodyWantsAreEmpty) {
  const test::Run run{rig_of(61, 40)};
  Pipeline with{small_config(), run.rig, {.threads = 1}};
  Pipeline without{small_config(), run.rig, {.threads = 1, .stages = false}};
  for (int i{0}; i < 5; ++i) {
    SCOPED_TRACE(i);
    const FrameResult& expected{with.process(noise_frame(run, i))};
    const FrameResult& result{without.process(noise_frame(run, i))};
    EXPECT_EQ(result.vehicle.occupancy, expected.vehicle.occupancy);
    EXPECT_EQ(result.obstacle_density, expected.obstacle_density);
    EXPECT_TRUE(result.stages.obstacle_disparity.empty());
    EXPECT_TRUE(result.stages.occupancy_smooth.empty());
  }
}

// Rows with gaps between them.
template <class T>
std::pair<Image<T>, View<const T>> with_gaps(const Image<T>& image) {
  constexpr int gap{3};
  Image<T> wide{image.width() + gap, image.height(), T{77}};
  for (int v{0}; v < image.height(); ++v) std::copy_n(image.row(v), image.width(), wide.row(v));
  const View<const T> view{wide.data(), image.width(), image.height(), wide.width()};
  return {std::move(wide), view};
}

TEST(Pipeline, ReadsImagesInPlace) {
  for (const bool has_disparities : {false, true}) {
    const test::Run run{rig_of(61, 40), has_disparities};
    Pipeline of_frames{small_config(), run.rig, {.threads = 1}};
    Pipeline of_views{small_config(), run.rig, {.threads = 1}};
    FrameResult result;
    for (int i{0}; i < 5; ++i) {
      StereoFrame frame{noise_frame(run, i)};
      const FrameResult& expected{of_frames.process(frame)};
      const auto [left, left_view] = with_gaps(std::exchange(frame.left, {}));
      const auto [right, right_view] = with_gaps(std::exchange(frame.right, {}));
      const auto [disparity, disparity_view] = with_gaps(std::exchange(frame.disparity, {}));
      FrameImages images;
      images.left = left_view;
      images.right = right_view;
      images.disparity = disparity_view;
      of_views.process(frame, images, result);
      EXPECT_EQ(result.stages.obstacle_disparity, expected.stages.obstacle_disparity);
      EXPECT_EQ(result.vehicle.occupancy, expected.vehicle.occupancy);
    }
  }
}

}  // namespace
}  // namespace stereogrid::test
