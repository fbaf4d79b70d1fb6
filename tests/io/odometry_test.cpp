// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/odometry.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "stereogrid/io/recording.hpp"
#include "stereogrid/scenes/scene.hpp"
#include "support.hpp"

namespace stereogrid::io::testing {
namespace {

using ::testing::HasSubstr, ::testing::Optional;

std::vector<StereoFrame> render(const std::string& scene) {
  const scenes::Scene source{scenes::parse_scene(scene)};
  std::vector<StereoFrame> frames;
  for (std::size_t i{0}; i < source.size(); ++i) frames.push_back(source.load(i));
  return frames;
}

Rig rig_of(const std::string& scene) {
  return scenes::Scene{scenes::parse_scene(scene)}.rig();
}

std::vector<OdometryStep> steps_of(const std::vector<StereoFrame>& frames, const Rig& rig) {
  VisualOdometry odometry{rig};
  std::vector<OdometryStep> steps;
  for (const StereoFrame& frame : frames) steps.push_back(odometry.update(frame));
  return steps;
}

/// Error of the last step relative to the true pose; both begin at the first frame.
Pose2 drift(const std::vector<StereoFrame>& frames, const std::vector<OdometryStep>& steps) {
  const Pose2 truth{inverse(*frames.front().world_from_vehicle) * *frames.back().world_from_vehicle};
  return inverse(truth) * steps.back().world_from_vehicle;
}

double length_m(const Pose2& pose) {
  return std::hypot(pose.x_m, pose.y_m);
}

double way_m(const std::vector<StereoFrame>& frames) {
  return length_m(inverse(*frames.front().world_from_vehicle) * *frames.back().world_from_vehicle);
}

const char* const street{"scene:street?frames=12&width=384&height=240"};

/// Rendered once.
std::vector<StereoFrame> drive() {
  static const std::vector<StereoFrame> frames{render(street)};
  return frames;
}

TEST(Odometry, FollowsAStreet) {
  const std::vector<StereoFrame> frames{drive()};
  const std::vector<OdometryStep> steps{steps_of(frames, rig_of(street))};
  ASSERT_GT(way_m(frames), 5);
  EXPECT_LT(length_m(drift(frames, steps)), 0.005 * way_m(frames));
  EXPECT_LT(std::abs(drift(frames, steps).yaw_rad), 0.002);
  EXPECT_FALSE(steps[0].measured);
  for (std::size_t i{1}; i < steps.size(); ++i) {
    EXPECT_TRUE(steps[i].measured) << i;
    EXPECT_FALSE(steps[i].standing) << i;
    EXPECT_GT(steps[i].inliers, 100) << i;
    EXPECT_GE(steps[i].tracked, steps[i].inliers) << i;
    EXPECT_GT(steps[i].spread, 0.5) << i;
    EXPECT_EQ(steps[i].warning, std::nullopt) << i;
  }
}

TEST(Odometry, KnowsHowGoodItIs) {
  const std::vector<StereoFrame> frames{drive()};
  const std::vector<OdometryStep> steps{steps_of(frames, rig_of(street))};
  EXPECT_EQ(steps.front().covariances.pose, (std::array<double, 9>{})) << "the world begins there";
  const auto sigma = [](const std::array<double, 9>& covariance, std::size_t i) {
    return std::sqrt(covariance[4 * i]);
  };
  for (std::size_t i{1}; i < steps.size(); ++i) {
    const Pose2 truth{inverse(*frames[i - 1].world_from_vehicle) * *frames[i].world_from_vehicle};
    const Pose2 error{inverse(truth) * (inverse(steps[i - 1].world_from_vehicle) * steps[i].world_from_vehicle)};
    const auto& [pose, motion]{steps[i].covariances};
    EXPECT_LT(std::abs(error.x_m), 3 * sigma(motion, 0)) << i;
    EXPECT_LT(std::abs(error.y_m), 3 * sigma(motion, 1)) << i;
    EXPECT_LT(std::abs(error.yaw_rad), 3 * sigma(motion, 2)) << i;
    EXPECT_LT(sigma(motion, 0), 0.02 * way_m(frames) / 11) << i;
    EXPECT_LT(sigma(motion, 2), 0.002) << i;
    for (const std::size_t k : {0, 1, 2}) EXPECT_GT(sigma(pose, k), sigma(steps[i - 1].covariances.pose, k)) << i;
  }
  const Pose2 error{drift(frames, steps)};
  const auto& pose{steps.back().covariances.pose};
  EXPECT_LT(length_m(error), 3 * sigma(pose, 0));
  EXPECT_LT(std::abs(error.yaw_rad), 3 * sigma(pose, 2));
}

TEST(Odometry, BearsUnequalExposures) {
  for (const double gain : {0.3, 2.0, 3.0}) {
    std::vector<StereoFrame> frames{drive()};
    for (StereoFrame& frame : frames) {
      for (std::uint8_t& grey : frame.right) grey = static_cast<std::uint8_t>(std::min(std::lround(gain * grey), 255L));
    }
    EXPECT_LT(length_m(drift(frames, steps_of(frames, rig_of(street)))), 0.01 * way_m(frames)) << gain;
  }
}

TEST(Odometry, GivesTheCamerasMotion) {
  const std::vector<StereoFrame> frames{drive()};
  const OdometryStep last{steps_of(frames, rig_of(street)).back()};
  const Pose2 truth{inverse(*frames[10].world_from_vehicle) * *frames[11].world_from_vehicle};
  EXPECT_NEAR(last.camera_motion[11], truth.x_m, 0.02);  // z is ahead
  EXPECT_NEAR(last.camera_motion[3], -truth.y_m, 0.02);  // x is right
  EXPECT_NEAR(last.camera_motion[7], 0, 0.02);           // y is down
}

TEST(Odometry, SeesThroughAPitchedCamera) {
  const std::string scene{std::string{street} + "&pitch_deg=12"};
  const std::vector<StereoFrame> frames{render(scene)};
  EXPECT_LT(length_m(drift(frames, steps_of(frames, rig_of(scene)))), 0.005 * way_m(frames));
}

TEST(Odometry, BearsMissingFrames) {
  std::vector<StereoFrame> frames{drive()};
  frames.erase(frames.begin() + 7, frames.begin() + 9);
  frames.erase(frames.begin() + 3);
  EXPECT_LT(length_m(drift(frames, steps_of(frames, rig_of(street)))), 0.01 * way_m(frames));
}

TEST(Odometry, TakesGivenDisparities) {
  std::vector<StereoFrame> frames{drive()};
  for (StereoFrame& frame : frames) {
    const auto mat_of = [](Image<std::uint8_t>& image) {
      return cv::Mat{image.height(), image.width(), CV_8UC1, image.data()};
    };
    cv::Mat sixteenths;  // OpenCV's fixed point; negative: none
    cv::StereoSGBM::create(0, 64, 5, 200, 800, 1, 0, 10, 100, 2)
        ->compute(mat_of(frame.left), mat_of(frame.right), sixteenths);
    frame.disparity = Image<float>{frame.left.width(), frame.left.height()};
    std::transform(sixteenths.begin<std::int16_t>(), sixteenths.end<std::int16_t>(), frame.disparity.data(),
                   [](std::int16_t d) { return d > 0 ? static_cast<float>(d) / 16 : 0.0F; });
    frame.right = {};
  }
  EXPECT_LT(length_m(drift(frames, steps_of(frames, rig_of(street)))), 0.02 * way_m(frames));
}

TEST(Odometry, IsTheSameForAnyNumberOfThreads) {
  const std::vector<StereoFrame> frames{drive()};
  const std::vector<OdometryStep> many{steps_of(frames, rig_of(street))};
  const int threads{cv::getNumThreads()};
  cv::setNumThreads(1);
  const std::vector<OdometryStep> one{steps_of(frames, rig_of(street))};
  cv::setNumThreads(threads);
  for (std::size_t i{0}; i < frames.size(); ++i) {
    EXPECT_EQ(many[i].camera_motion, one[i].camera_motion);
    EXPECT_EQ(many[i].world_from_vehicle, one[i].world_from_vehicle);
    EXPECT_EQ(many[i].covariances.pose, one[i].covariances.pose);
  }
}

TEST(Odometry, CarriesTheLastMotionOnInTheDark) {
  std::vector<StereoFrame> frames{drive()};
  for (std::size_t i{6}; i < 8; ++i) {
    frames[i].left.fill(0);
    frames[i].right.fill(0);
  }
  const std::vector<OdometryStep> steps{steps_of(frames, rig_of(street))};
  for (std::size_t i{6}; i < 8; ++i) {
    EXPECT_FALSE(steps[i].measured) << i;
    EXPECT_THAT(steps[i].warning, Optional(HasSubstr("the last motion continues"))) << i;
    EXPECT_GT(steps[i].covariances.motion[0], 10 * steps[5].covariances.motion[0]) << i;
  }
  EXPECT_TRUE(steps[8].measured) << "the frame before the dark still serves";
  EXPECT_LT(length_m(drift(frames, steps)), 0.02 * way_m(frames));
}

// All the street but a strip is hidden by an object that moves with the camera.
TEST(Odometry, TakesNoCornersFromWhatIsMasked) {
  std::vector<StereoFrame> frames{drive()};
  Image<std::uint8_t> mask{384, 240, 255};
  cv::RNG random{3};
  for (const auto [u, v] : raster(0, 384, 60, 240)) {
    if (u > 130 && u < 250) continue;
    mask(u, v) = 0;
    const auto grey{static_cast<std::uint8_t>(random.uniform(0, 2) * 200)};
    for (StereoFrame& frame : frames) {
      frame.left(u, v) = grey;
      if (u >= 9) frame.right(u - 9, v) = grey;
    }
  }
  const Rig rig{rig_of(street)};
  EXPECT_GT(length_m(drift(frames, steps_of(frames, rig))), 0.5 * way_m(frames)) << "the vehicle seems to stand";
  VisualOdometry odometry{rig, mask};
  std::vector<OdometryStep> steps;
  for (const StereoFrame& frame : frames) steps.push_back(odometry.update(frame));
  EXPECT_LT(length_m(drift(frames, steps)), 0.05 * way_m(frames));
  EXPECT_THROW((VisualOdometry{rig, Image<std::uint8_t>{10, 10, 1}}), InputError);
}

TEST(Odometry, NothingToSeeIsStandstillWithAWarning) {
  const Rig rig{320, 200, 300, 160, 100, 0.3};
  StereoFrame grey{"0", 0, 0, Image<std::uint8_t>{320, 200, 90}, Image<std::uint8_t>{320, 200, 90}, {}, {}};
  VisualOdometry odometry{rig};
  (void)odometry.update(grey);
  grey.stamp_ns = 100'000'000;
  const OdometryStep step{odometry.update(grey)};
  EXPECT_FALSE(step.measured);
  EXPECT_EQ(step.world_from_vehicle, Pose2{});
  EXPECT_THAT(step.warning, Optional(HasSubstr("too few points")));
}

// A wall with texture straight ahead; on it, where it is given, something nearer.
class Wall {
 public:
  Wall() : texture_(600, 1200, CV_8UC1) {
    cv::RNG random{7};
    random.fill(texture_, cv::RNG::UNIFORM, 0, 256);
    cv::GaussianBlur(texture_, texture_, {}, 2);
    cv::normalize(texture_, texture_, 0, 255, cv::NORM_MINMAX);
  }

  /// `noise` of its own for each index; `van_left_px`: left edge of the moving part, 220 px wide and 190 px high.
  [[nodiscard]] StereoFrame frame(int index, int van_left_px = -1000) const {
    StereoFrame frame;
    frame.stamp_ns = index * std::int64_t{100'000'000};
    frame.left = seen(index, 0, van_left_px);
    frame.right = seen(index + 1000, 1, van_left_px);
    return frame;
  }

  static constexpr int wall_disparity_px{10};
  static constexpr int van_disparity_px{16};

 private:
  [[nodiscard]] Image<std::uint8_t> seen(int seed, int camera, int van_left_px) const {
    cv::Mat image{texture_(cv::Rect{100 + camera * wall_disparity_px, 100, 320, 200}).clone()};
    const cv::Rect van{cv::Rect{van_left_px - camera * van_disparity_px, 5, 220, 190}};
    const cv::Rect visible{van & cv::Rect{0, 0, 320, 200}};
    if (!visible.empty())
      texture_(cv::Rect{700, 300, visible.width, visible.height} + (visible.tl() - van.tl())).copyTo(image(visible));
    cv::Mat noise{image.size(), CV_16SC1};
    cv::RNG random{static_cast<std::uint64_t>(seed) + 1};
    random.fill(noise, cv::RNG::NORMAL, 0, 2);
    cv::add(image, noise, image, cv::noArray(), CV_8U);
    Image<std::uint8_t> pixels{320, 200};
    for (int v{0}; v < 200; ++v) std::copy_n(image.ptr(v), 320, pixels.row(v));
    return pixels;
  }

  cv::Mat texture_;
};

const Rig wall_rig{320, 200, 300, 160, 100, 0.3};

TEST(Odometry, AStandingCameraDoesNotDrift) {
  const Wall wall;
  VisualOdometry odometry{wall_rig};
  (void)odometry.update(wall.frame(0));
  for (int i{1}; i < 10; ++i) {
    const OdometryStep step{odometry.update(wall.frame(i))};
    EXPECT_TRUE(step.standing) << i;
    EXPECT_EQ(step.world_from_vehicle, Pose2{}) << i;
  }
}

TEST(Odometry, AVanThatFillsThePictureIsNotOurMotion) {
  const Wall wall;
  VisualOdometry odometry{wall_rig};
  for (int i{0}; i < 4; ++i) (void)odometry.update(wall.frame(i, 10));
  for (int i{4}; i < 8; ++i) {
    const OdometryStep step{odometry.update(wall.frame(i, 10 + (i - 3) * 20))};
    EXPECT_TRUE(step.measured) << i;
    EXPECT_LT(length_m(step.world_from_vehicle), 0.03) << i;
    EXPECT_LT(2 * step.inliers, step.tracked) << "the van is not what fills the picture";
  }
}

TEST(Odometry, RefusesWhatDoesNotFit) {
  const Wall wall;
  VisualOdometry odometry{wall_rig};
  (void)odometry.update(wall.frame(1));
  EXPECT_THROW((void)odometry.update(wall.frame(1)), InputError);
  StereoFrame small{wall.frame(2)};
  small.right = Image<std::uint8_t>{319, 200};
  EXPECT_THROW((void)odometry.update(small), InputError);
  EXPECT_TRUE(odometry.update(wall.frame(2)).standing);
}

TEST(Odometry, FollowsARealDrive) {
  if (!data_folder()) GTEST_SKIP() << "needs the data sets (STEREOGRID_DATA)";
  InputArguments arguments;
  arguments.paths = {*data_folder() / "kitti_odo04"};
  const auto recording{open_recording(arguments)};
  std::vector<StereoFrame> frames;
  for (std::size_t i{0}; i < 16; ++i) frames.push_back(recording->load(i));
  const Pose2 off{drift(frames, steps_of(frames, recording->rig()))};
  EXPECT_LT(length_m(off), 0.025 * way_m(frames));
  EXPECT_LT(std::abs(off.yaw_rad), 0.004);
}

}  // namespace
}  // namespace stereogrid::io::testing
