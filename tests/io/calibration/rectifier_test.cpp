// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/rectifier.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "stereogrid/io/calibration.hpp"
#include "stereogrid/io/recording.hpp"
#include "support.hpp"

namespace stereogrid::io::testing {
namespace {

constexpr int width_px{641};
constexpr int height_px{479};

constexpr const char* raw_yaml{
    "image: {width_px: 641, height_px: 479}\n"
    "left: {focal_u_px: 500, focal_v_px: 502, cx_px: 322, cy_px: 236, distortion: [-0.2, 0.05, 0.001, "
    "-0.0005, 0.01]}\n"
    "right: {focal_u_px: 507, focal_v_px: 505, cx_px: 315, cy_px: 241, distortion: [-0.18, 0.04, 0, "
    "0.0008]}\n"
    "right_from_left: {rotation: [0.01, -0.02, 0.015], translation_m: [-0.2998, 0.006, -0.009]}\n"
    "mount: {camera_height_m: 1.4, camera_pitch_rad: 0.02}\n"};

/// Bright dots at world points, as one camera of the raw pair sees them. Rendered by projection, so that the rectifier
/// is checked against the forward model.
Image<std::uint8_t> dots(const std::vector<cv::Point3d>& points, const CameraModel& camera, const cv::Vec3d& turn,
                         const cv::Vec3d& shift) {
  const cv::Matx33d k{camera.focal_u_px, 0, camera.cx_px, 0, camera.focal_v_px, camera.cy_px, 0, 0, 1};
  std::vector<cv::Point2d> centres;
  if (camera.lens == LensModel::fisheye) {
    cv::fisheye::projectPoints(points, centres, turn, shift, k, camera.distortion);
  } else {
    cv::projectPoints(points, turn, shift, k, camera.distortion, centres);
  }
  Image<std::uint8_t> image{width_px, height_px, 0};
  for (const auto [u, v] : raster(width_px, height_px)) {
    double value{0};
    for (const auto& c : centres) value += 250 * std::exp(-((u - c.x) * (u - c.x) + (v - c.y) * (v - c.y)) / 18);
    image(u, v) = static_cast<std::uint8_t>(std::min(value, 255.0));
  }
  return image;
}

/// Centre of brightness within 10 px; the window follows it.
cv::Point2d centroid(const Image<std::uint8_t>& image, cv::Point2d near) {
  for (int round{0}; round < 4; ++round) {
    cv::Point2d sum{0, 0};
    double weight{0};
    const cv::Point centre{cvRound(near.x), cvRound(near.y)};
    for (int v{std::max(0, centre.y - 10)}; v <= std::min(image.height() - 1, centre.y + 10); ++v) {
      for (int u{std::max(0, centre.x - 10)}; u <= std::min(image.width() - 1, centre.x + 10); ++u) {
        sum += cv::Point2d(u, v) * static_cast<double>(image(u, v));
        weight += image(u, v);
      }
    }
    near = sum / weight;
  }
  return near;
}

/// The turn that takes points of the raw left camera to the rectified one.
cv::Matx33d rectified_from_left(const RawPair& raw) {
  const auto matrix{
      [](const CameraModel& c) { return cv::Matx33d{c.focal_u_px, 0, c.cx_px, 0, c.focal_v_px, c.cy_px, 0, 0, 1}; }};
  cv::Mat left, right, p, q, depth;
  const cv::Matx33d turn{raw.right_from_left_rotation.data()};
  const cv::Vec3d shift{raw.right_from_left_translation_m.data()};
  const cv::Size size{width_px, height_px};
  if (raw.left.lens == LensModel::fisheye) {
    cv::fisheye::stereoRectify(matrix(raw.left), raw.left.distortion, matrix(raw.right), raw.right.distortion, size,
                               turn, shift, left, right, p, q, depth, 0);
  } else {
    cv::stereoRectify(matrix(raw.left), raw.left.distortion, matrix(raw.right), raw.right.distortion, size, turn, shift,
                      left, right, p, q, depth);
  }
  return left;
}

/// Dots on three planes before the cameras.
std::vector<cv::Point3d> points_ahead() {
  std::vector<cv::Point3d> points;
  for (int i{0}; i < 12; ++i) {
    const double z{4.0 + i % 3};
    points.emplace_back((-0.4 + 0.27 * (i % 4)) * z, (-0.25 + 0.25 * (i / 4)) * z, z);
  }
  return points;
}

/// Compares the points in the rectified pair with their expected places.
void expect_rectified(const RawPair& raw, const std::vector<cv::Point3d>& points, const Image<std::uint8_t>& raw_left,
                      const Image<std::uint8_t>& raw_right) {
  const Rectifier rectifier{raw, width_px, height_px};
  const auto left{rectifier.left(raw_left)};
  const auto right{rectifier.right(raw_right)};
  ASSERT_EQ(left.width(), width_px);
  ASSERT_EQ(left.height(), height_px);
  const Rig& rig{rectifier.rig()};
  const cv::Matx33d turn{rectified_from_left(raw)};
  int found{0};
  for (const auto& raw_point : points) {
    const cv::Point3d point{turn * raw_point};
    const double disparity{rig.focal_px * rig.baseline_m / point.z};
    const cv::Point2d guess{rig.cx_px + rig.focal_px * point.x / point.z, rig.cy_px + rig.focal_px * point.y / point.z};
    const auto l{centroid(left, guess)};
    const auto r{centroid(right, {l.x - disparity, l.y})};
    if (std::isnan(l.x) || std::isnan(r.x) || l.x < 25 || r.x < 25 || l.x > width_px - 25) continue;
    ++found;
    EXPECT_NEAR(l.x, guess.x, 0.15);
    EXPECT_NEAR(l.y, guess.y, 0.15);
    EXPECT_NEAR(l.y, r.y, 0.1);
    EXPECT_NEAR(l.x - r.x, disparity, 0.1) << "at " << l;
  }
  EXPECT_GE(found, 9);
}

struct RawPairOnDisk : FolderTest {
  void SetUp() override {
    put(folder / "calibration.yaml", raw_yaml);
    points_ = points_ahead();
    calibration_ = read_calibration(folder / "calibration.yaml");
    const auto& t{calibration_.raw->right_from_left_translation_m};
    left_ = dots(points_, calibration_.raw->left, {0, 0, 0}, {0, 0, 0});
    right_ = dots(points_, calibration_.raw->right, {0.01, -0.02, 0.015}, {t[0], t[1], t[2]});
  }
  Calibration calibration_;
  std::vector<cv::Point3d> points_;
  Image<std::uint8_t> left_;
  Image<std::uint8_t> right_;
};

TEST_F(RawPairOnDisk, RigIsThatOfTheRectifiedPair) {
  EXPECT_NEAR(calibration_.rig.baseline_m, std::sqrt(0.2998 * 0.2998 + 0.006 * 0.006 + 0.009 * 0.009), 1e-9);
  EXPECT_EQ(calibration_.rig.width_px, width_px);
  EXPECT_DOUBLE_EQ(calibration_.rig.camera_height_m, 1.4);
  EXPECT_GT(calibration_.rig.focal_px, 350);
  EXPECT_LT(calibration_.rig.focal_px, 650);
}

TEST_F(RawPairOnDisk, RowsAlignAndDisparityIsFocalTimesBaselineOverDepth) {
  expect_rectified(*calibration_.raw, points_, left_, right_);
}

/// Fisheye lenses; `focal_px` says how wide.
RawPair fisheye_pair(double focal_px) {
  RawPair raw;
  raw.left = {focal_px, focal_px + 1, 322, 236, {0.03, -0.01, 0.003, -0.001}, LensModel::fisheye};
  raw.right = {focal_px + 4, focal_px + 2, 316, 241, {0.02, -0.008, 0.002, 0}, LensModel::fisheye};
  cv::Matx33d turn;
  cv::Rodrigues(cv::Vec3d{0.01, -0.02, 0.015}, turn);
  std::copy_n(turn.val, 9, raw.right_from_left_rotation.begin());
  raw.right_from_left_translation_m = {-0.2998, 0.006, -0.009};
  return raw;
}

TEST(Rectifier, TakesFisheyeLensesAsTheyAre) {
  // the second sees 155°, more than a flat image has room for: 120° remain
  for (const double focal_px : {400.0, 230.0}) {
    const RawPair raw{fisheye_pair(focal_px)};
    const auto& t{raw.right_from_left_translation_m};
    const auto left{dots(points_ahead(), raw.left, {0, 0, 0}, {0, 0, 0})};
    const auto right{dots(points_ahead(), raw.right, {0.01, -0.02, 0.015}, {t[0], t[1], t[2]})};
    expect_rectified(raw, points_ahead(), left, right);
    const Rig rig{Rectifier{raw, width_px, height_px}.rig()};
    EXPECT_NEAR(rig.baseline_m, std::hypot(t[0], t[1], t[2]), 1e-9);
    const double half_deg{std::atan(width_px / 2 / rig.focal_px) * 180 / CV_PI};
    EXPECT_NEAR(half_deg, focal_px == 230 ? 60 : 42, 1);
  }
}

TEST(Rectifier, RefusesLensesOfTwoKinds) {
  RawPair raw{fisheye_pair(400)};
  raw.right.lens = LensModel::perspective;
  expect_error([&] { return Rectifier{raw, width_px, height_px}; }, {"fisheye", "the other has not"});
}

TEST_F(RawPairOnDisk, RecordingRectifiesOnLoading) {
  fs::create_directories(folder / "left");
  fs::create_directories(folder / "right");
  write_png(folder / "left" / "0.png", left_);
  write_png(folder / "right" / "0.png", right_);
  const auto recording{open_recording({{folder.path()}, {}, ""})};
  const Rectifier rectifier{*calibration_.raw, width_px, height_px};
  const StereoFrame frame{recording->load(0)};
  EXPECT_EQ(frame.left, rectifier.left(left_));
  EXPECT_EQ(frame.right, rectifier.right(right_));
  EXPECT_NE(frame.left, left_);
  EXPECT_EQ(recording->rig(), calibration_.rig);
}

TEST_F(RawPairOnDisk, MatrixAndRodriguesFormsAgree) {
  cv::Matx33d r;
  cv::Rodrigues(cv::Vec3d{0.01, -0.02, 0.015}, r);
  std::string text{raw_yaml};
  std::string matrix{"["};
  for (int i{0}; i < 3; ++i) {
    matrix += (i == 0 ? "[" : ", [") + std::to_string(r(i, 0)) + ", " + std::to_string(r(i, 1)) + ", " +
              std::to_string(r(i, 2)) + "]";
  }
  text.replace(text.find("[0.01, -0.02, 0.015]"), 20, matrix + "]");
  put(folder / "b.yaml", text);
  EXPECT_NEAR(read_calibration(folder / "b.yaml").rig.cx_px, calibration_.rig.cx_px, 0.02);
}

TEST_F(RawPairOnDisk, Findings) {
  const auto refused{
      [&](const std::string& from, const std::string& to, std::initializer_list<std::string_view> parts) {
        std::string text{raw_yaml};
        ASSERT_NE(text.find(from), std::string::npos);
        text.replace(text.find(from), from.size(), to);
        put(folder / "b.yaml", text);
        expect_error([&] { return read_calibration(folder / "b.yaml"); }, parts);
      }};
  refused("[-0.2998, 0.006, -0.009]", "[0.2998, 0.006, -0.009]", {"b.yaml", "negative", "swapped"});
  refused("[-0.2998, 0.006, -0.009]", "[0, 0, 0]", {"baseline is zero"});
  refused("[-0.2998, 0.006, -0.009]", "[0.01, 0.3, 0]", {"side by side"});
  refused("[-0.2998, 0.006, -0.009]", "[-299.8, 6, -9]", {"millimetres"});
  refused("[-0.2998, 0.006, -0.009]", "[-0.3]", {"not 3 numbers"});
  refused("[0.01, -0.02, 0.015]", "[0.01, -0.02]", {"rotation of 2 numbers"});
  refused("[0.01, -0.02, 0.015]", "[1, 0, 0, 0, 1, 0, 0, 0, -1]", {"not a rotation matrix"});
  refused("[0.01, -0.02, 0.015]", "[1, 0.5, 0, 0, 1, 0, 0, 0, 1]", {"not a rotation matrix"});
  refused("focal_u_px: 507", "focal_u_px: 0", {"focal length", "not positive"});
  refused("focal_u_px: 507", "focal_u_px: 5070", {"differ by more than a fifth"});
  refused("distortion: [-0.18, 0.04, 0, 0.0008]", "distortion: [-0.18]", {"1 distortion numbers"});
  refused("distortion: [-0.18, 0.04, 0, 0.0008]", "distortion: [-0.18, 1, 1, 1, 1], lens: fisheye",
          {"(right)", "5 distortion numbers", "fisheye lens has 4"});
  refused("distortion: [-0.18, 0.04, 0, 0.0008]", "lens: bent", {"neither perspective nor fisheye"});
  refused("right: {", "rihgt: {", {"unknown key 'rihgt'"});
  refused("mount:", "focal_px: 500\nmount:", {"mixes"});
  refused("image: {width_px: 641, height_px: 479}\n", "", {"no 'image' size"});
}

TEST(RectifierOfRowAlignedPairs, TheRightImageIsShiftedByWholePixels) {
  RawPair raw;
  raw.left = {100, 100, 31, 20, {}};
  raw.right = {100, 100, 36, 20, {}};
  raw.right_from_left_translation_m = {-0.25, 0, 0};
  const StereoFrame frame{textured_pair(64, 40, 3)};
  const Rectifier rectifier{raw, 64, 40};
  EXPECT_EQ(rectifier.rig().focal_px, 100);
  EXPECT_EQ(rectifier.rig().cx_px, 31);
  EXPECT_EQ(rectifier.left(frame.left), frame.left);
  const Image<std::uint8_t> right{rectifier.right(frame.right)};
  for (int u{0}; u + 5 < 64; ++u) EXPECT_EQ(right.row(7)[u], frame.right.row(7)[u + 5]) << u;
}

}  // namespace
}  // namespace stereogrid::io::testing
