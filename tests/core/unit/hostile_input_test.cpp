// SPDX-License-Identifier: Apache-2.0
//
// Implausible numbers: in poses, disparities, other grids and arguments.
#include "hostile_run.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid::test {
namespace {

using ::testing::AllOf, ::testing::HasSubstr;

constexpr double infinity{std::numeric_limits<double>::infinity()};
constexpr double nan{std::numeric_limits<double>::quiet_NaN()};
constexpr std::int64_t frame_ns{100'000'000};

class HostileInput : public ::testing::TestWithParam<BackEnd> {
 protected:
  Wall wall_{GetParam()};
};

INSTANTIATE_TEST_SUITE_P(BackEnds, HostileInput, ::testing::ValuesIn(back_ends()));

void expect_sane(const FrameResult& result) {
  for (const Image<float>* image : {&result.observed, &result.vehicle.occupancy, &result.world.occupancy}) {
    for (const float p : *image) ASSERT_TRUE(p >= 0 && p <= 1) << p;
  }
  for (const float v : result.world.velocity_x) ASSERT_TRUE(std::isfinite(v));
}

TEST_P(HostileInput, PosesOutOfThisWorldAreRefused) {
  wall_.has_poses = true;
  static_cast<void>(wall_.step(0));
  for (const double x_m : {1.1e9, -1e12, 1e300}) {
    StereoFrame frame{wall_.frame(frame_ns)};
    frame.world_from_vehicle = Pose2{x_m, 0, 0};
    EXPECT_THAT(error_text_of<InputError>([&] { static_cast<void>(wall_.pipeline.process(frame)); }),
                AllOf(HasSubstr("1e9 m"), HasSubstr("leave the pose out")));
  }
  EXPECT_EQ(wall_.step(frame_ns).world_from_vehicle, Pose2{});
}

TEST_P(HostileInput, PosesFromOneEndToTheOtherAreSurvived) {
  for (const bool notices : {true, false}) {
    Config config{small_config()};
    config.motion.detect_jumps = notices;
    Wall wall{GetParam(), config};
    for (int i{0}; i < 6; ++i) {
      StereoFrame frame{wall.frame(i * frame_ns)};
      frame.world_from_vehicle = Pose2{i % 2 == 0 ? 1e9 : -1e9, i % 3 == 0 ? 1e9 : -1e9, i * 1e15};
      expect_sane(wall.pipeline.process(frame));
    }
  }
}

TEST_P(HostileInput, DisparitiesThatAreNoneCountAsNone) {
  Wall clean{GetParam()};
  for (int i{0}; i < 4; ++i) {
    StereoFrame frame{wall_.frame(i * frame_ns)};
    frame.right = {};
    frame.disparity = Image<float>{frame.left.width(), frame.left.height()};
    for (int v{0}; v < frame.disparity.height(); ++v) {
      const auto disparity_px = static_cast<float>(wall_disparity_px(v));
      std::fill_n(frame.disparity.row(v), frame.disparity.width(), disparity_px);
    }
    StereoFrame none{frame};
    const float garbage[]{std::nanf(""),
                          -1,
                          -1e30f,
                          1e30f,
                          std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity(),
                          3e9f};
    for (std::size_t k{0}; k < frame.disparity.size(); k += 7) {
      frame.disparity.data()[k] = garbage[k / 7 % std::size(garbage)];
      none.disparity.data()[k] = 0;
    }
    expect_equal(wall_.pipeline.process(frame), clean.pipeline.process(none));
  }
  const Image<float> only_nan(small_rig().width_px, small_rig().height_px, std::nanf(""));
  StereoFrame frame{wall_.frame(5 * frame_ns)};
  frame.right = {};
  frame.disparity = only_nan;
  expect_sane(wall_.pipeline.process(frame));
}

TEST_P(HostileInput, GarbageDisparitiesOfAPitchedCamera) {
  Rig rig{small_rig()};
  rig.camera_pitch_rad = 0.2;
  Wall wall{GetParam(), small_config(), rig};
  for (int i{0}; i < 2; ++i) {
    StereoFrame frame{wall.frame(i * frame_ns)};
    frame.right = {};
    frame.disparity = Image<float>(rig.width_px, rig.height_px, i == 0 ? 3e38f : std::nanf(""));
    expect_sane(wall.pipeline.process(frame));
  }
}

TEST_P(HostileInput, OtherGridsAnywhereAndOfAnyCells) {
  Wall alone{GetParam()};
  const double smallest{std::numeric_limits<double>::denorm_min()};
  for (const GridGeometry& place : {GridGeometry{1e300, -1e300, 0.2, 2, 2}, GridGeometry{0, 0, smallest, 2, 2},
                                    GridGeometry{-1e308, 1e308, 1e308, 2, 2}, GridGeometry{5, 0, 1e-12, 2, 2}}) {
    StereoFrame frame{wall_.frame(wall_.number * frame_ns)};
    ObservedGrid grid{place, Image<float>(2, 2, 0.9f), {}};
    frame.other_grids = {grid, grid};
    ++wall_.number;
    expect_sane(wall_.pipeline.process(frame));
  }
}

TEST_P(HostileInput, OtherGridsThatAreNoneAreRefused) {
  for (const double bad : {nan, infinity, -infinity}) {
    for (const GridGeometry& place :
         {GridGeometry{bad, 0, 0.2, 2, 2}, GridGeometry{0, bad, 0.2, 2, 2}, GridGeometry{0, 0, bad, 2, 2}}) {
      StereoFrame frame{wall_.frame(0)};
      frame.other_grids = {{place, Image<float>(2, 2, 0.9f), {}}};
      EXPECT_THROW(static_cast<void>(wall_.pipeline.process(frame)), InputError);
    }
  }
}

// A view of each image that has a size but no pixels, and one whose rows overlap.
TEST_P(HostileInput, ViewsWithoutPixelsOrWithRowsThatOverlapAreRefused) {
  const StereoFrame frame{wall_.frame(0)};
  const Image<float> disparity{small_rig().width_px, small_rig().height_px, 5.0f};
  FrameImages given = frame;
  given.right = {};
  given.disparity = disparity.view();
  FrameResult result;
  const auto expect_refused = [&](const FrameImages& images, const char* problem) {
    EXPECT_THAT(error_text_of<InputError>([&] { wall_.pipeline.process(frame, images, result); }), HasSubstr(problem));
  };
  const auto expect_checked = [&](const FrameImages& images, auto member) {
    FrameImages bad{images};
    (bad.*member).data = nullptr;
    expect_refused(bad, "has a size, but no pixels");
    bad = images;
    for (const int pitch : {0, 1, small_rig().width_px - 1, 1 - small_rig().width_px}) {
      (bad.*member).pitch = pitch;
      expect_refused(bad, "rows that overlap");
    }
  };
  expect_checked(frame, &FrameImages::left);
  expect_checked(frame, &FrameImages::right);
  expect_checked(given, &FrameImages::left);
  expect_checked(given, &FrameImages::disparity);
}

TEST_P(HostileInput, RowsMayBeStoredUpsideDown) {
  Wall expected{GetParam()};
  FrameResult result;
  for (int i{0}; i < 2; ++i) {
    const StereoFrame frame{wall_.frame(i * frame_ns)};
    StereoFrame turned{frame};
    FrameImages images = turned;
    for (auto [image, view] : {std::pair{&turned.left, &images.left}, std::pair{&turned.right, &images.right}}) {
      for (int v{0}; v < image->height() / 2; ++v) {
        std::swap_ranges(image->row(v), image->row(v) + image->width(), image->row(image->height() - 1 - v));
      }
      *view = {image->row(image->height() - 1), image->width(), image->height(), -image->width()};
    }
    wall_.pipeline.process(frame, images, result);
    ++wall_.number;
    expect_equal(expected.step(i * frame_ns), result);
  }
}

TEST_P(HostileInput, LongPredictionsAreRefusedAndTheLongestIsNot) {
  for (const double horizon_s : {1e8, 10001.0, nan, infinity, 0.0, -1.0}) {
    const PipelineOptions options{.back_end = GetParam(), .horizons_s = {1, horizon_s}};
    EXPECT_THAT(error_text_of<ConfigError>([&] { Wall{options}; }), HasSubstr("10000"));
  }
  Wall wall{PipelineOptions{.back_end = GetParam(), .horizons_s = {1e4}}};
  const FrameResult& result{wall.step(0)};
  ASSERT_EQ(result.predictions.size(), 1u);
  for (const float p : result.predictions[0].world_occupancy) ASSERT_TRUE(p >= 0 && p <= 1);
}

TEST_P(HostileInput, APlaceToStartAtMustBeOne) {
  for (const Pose2& place : {Pose2{nan, 0, 0}, Pose2{0, infinity, 0}, Pose2{0, 0, nan}, Pose2{1e10, 0, 0}}) {
    const PipelineOptions options{.back_end = GetParam(), .start = place};
    EXPECT_THAT(error_text_of<ConfigError>([&] { Wall{options}; }), HasSubstr("1e9"));
  }
  Wall wall{PipelineOptions{.back_end = GetParam(), .start = {1e9, -1e9, 1}}};
  EXPECT_EQ(wall.step(0).world_from_vehicle, (Pose2{1e9, -1e9, 1}));
  expect_sane(wall.step(frame_ns));
}

TEST(Arguments, ChoicesThatThereAreNotAreNamed) {
  Config config{small_config()};
  config.filter.model = static_cast<FilterModel>(7);
  config.ground.model = static_cast<GroundModel>(-1);
  EXPECT_THAT(problems(config),
              ::testing::ElementsAre(HasSubstr("ground.model is -1 and must be one of: plane terrain"),
                                     HasSubstr("filter.model is 7 and must be one of: tay2008 joint")));
  EXPECT_EQ(get(config, "filter.model"), "7");
  EXPECT_THROW(Pipeline(config, small_rig()), ConfigError);
}

TEST(Arguments, BackEndsAndThreadsThatThereAreNot) {
  EXPECT_THAT(error_text_of<ConfigError>([] {
                Pipeline{small_config(), small_rig(), {.back_end = static_cast<BackEnd>(9)}};
              }),
              HasSubstr("back end"));
  EXPECT_THAT(error_text_of<ConfigError>([] {
                Pipeline{small_config(), small_rig(), {.device = -1}};
              }),
              HasSubstr("counted from 0"));
  EXPECT_THAT(error_text_of<DeviceError>([] {
                Pipeline{small_config(), small_rig(), {.back_end = BackEnd::cuda, .horizons_s = {1}}};
              }),
              HasSubstr("Predictions are supported on the CPU only"));
  for (const int threads : {-1, -1000000, 1025, std::numeric_limits<int>::max()}) {
    EXPECT_THAT(error_text_of<ConfigError>([&] {
                  Pipeline{small_config(), small_rig(), {.threads = threads}};
                }),
                HasSubstr("threads"));
  }
}

TEST(Arguments, MoreThanAMachineHoldsIsRefused) {
  Config config;
  config.grid = {500, 500, 0.125};
  config.filter.speeds_mps = uniform_speeds(2.5, 15);
  EXPECT_THAT(problems(config), ::testing::ElementsAre(HasSubstr("64 GiB")));

  Rig rig{small_rig()};
  rig.width_px = rig.height_px = 16384;
  config = {};
  config.matching.disparities = std::numeric_limits<int>::max();
  EXPECT_THAT(error_text_of<ConfigError>([&] { Pipeline(config, rig); }), HasSubstr("matching.disparities"));
}

TEST(Pipeline, OneThatHasBeenMovedFromSaysSo) {
  Wall wall{BackEnd::cpu};
  Pipeline moved_to{std::move(wall.pipeline)};
  Pipeline& empty{wall.pipeline};
  EXPECT_THAT(error_text_of<std::logic_error>([&] { static_cast<void>(wall.step(0)); }), HasSubstr("moved from"));
  EXPECT_THROW(static_cast<void>(empty.config()), std::logic_error);
  EXPECT_THROW(static_cast<void>(empty.rig()), std::logic_error);
  EXPECT_THROW(static_cast<void>(empty.vehicle_grid()), std::logic_error);
  EXPECT_THROW(static_cast<void>(empty.world_grid()), std::logic_error);
  EXPECT_THROW(static_cast<void>(empty.threads()), std::logic_error);
  EXPECT_THROW(static_cast<void>(empty.back_end()), std::logic_error);
  EXPECT_THROW(static_cast<void>(empty.why_not_cuda()), std::logic_error);
  FrameResult result;
  EXPECT_THROW(empty.process(wall.frame(0), result), std::logic_error);
  EXPECT_THROW(empty.reset(), std::logic_error);
  empty = std::move(moved_to);
  EXPECT_FALSE(wall.step(frame_ns).world.occupancy.empty());
}

TEST(Pipeline, ASecondThreadIsRefused) {
  Wall wall{BackEnd::cpu};
  std::atomic<bool> is_refused{false};
  std::atomic<bool> ends{false};
  std::thread other{[&] {
    while (!is_refused && !ends) {
      try {
        wall.pipeline.reset();
      } catch (const std::logic_error&) {
        is_refused = true;
      }
    }
  }};
  for (int i{0}; i < 2000 && !is_refused; ++i) {
    try {
      static_cast<void>(wall.step(i * frame_ns));
    } catch (const std::logic_error& error) {
      EXPECT_THAT(error.what(), HasSubstr("in use by another thread"));
      is_refused = true;
    }
  }
  ends = true;
  other.join();
  EXPECT_TRUE(is_refused);
  EXPECT_NO_THROW(wall.pipeline.reset()) << "one after the other is fine";
}

TEST(Image, OneThatHasBeenMovedFromIsEmpty) {
  Image<int> first(3, 2, 7);
  Image<int> second{std::move(first)};
  EXPECT_EQ(first, Image<int>{});
  EXPECT_EQ(second, Image<int>(3, 2, 7));
  Image<int> third;
  third = std::move(second);
  EXPECT_EQ(second, Image<int>{});
  EXPECT_EQ(second.view().width, 0);
  EXPECT_EQ(third, Image<int>(3, 2, 7));
  Image<int>& itself{third};
  third = std::move(itself);
  EXPECT_EQ(third, Image<int>(3, 2, 7));
}

TEST(Image, ASizeBelowZeroIsRefused) {
  EXPECT_THROW(Image<float>(-1, 5), std::invalid_argument);
  EXPECT_THROW(Image<float>(5, -1), std::invalid_argument);
  EXPECT_THROW(Image<float>(-5, -5), std::invalid_argument);
  EXPECT_TRUE(Image<float>(0, 5).empty());
}

}  // namespace
}  // namespace stereogrid::test
