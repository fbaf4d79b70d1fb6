// SPDX-License-Identifier: Apache-2.0
// Calibrations of images of another size: scaled where the ratio is exact, else refused or complained of.
#include <fmt/format.h>

#include <cmath>
#include <functional>

#include "calibration/calibration_writers.hpp"
#include "support.hpp"

namespace stereogrid::io::testing {
namespace {

using ::testing::AllOf, ::testing::ElementsAre, ::testing::HasSubstr, ::testing::IsEmpty;

struct Size {
  int width_px;
  int height_px;
};

/// Writes a calibration.yaml; `size`: its `image` line, "": none.
std::string own_form(double cx, double cy, const std::string& size = "") {
  return (size.empty() ? "" : "image: " + size + "\n") +
         fmt::format("focal_px: 150\ncx_px: {}\ncy_px: {}\nbaseline_m: 0.25\n", cx, cy);
}

std::string opencv_form(double cx, double cy) {
  const auto matrix = [](const char* key, int rows, int cols, const std::string& numbers) {
    return fmt::format("{}: !!opencv-matrix\n  rows: {}\n  cols: {}\n  dt: d\n  data: [{}]\n", key, rows, cols,
                       numbers);
  };
  const std::string camera{fmt::format("150., 0., {}, 0., 150., {}, 0., 0., 1.", cx, cy)};
  return "%YAML:1.0\n---\n" + matrix("M1", 3, 3, camera) + matrix("D1", 1, 4, "-0.1, 0.01, 0., 0.") +
         matrix("M2", 3, 3, camera) + matrix("D2", 1, 4, "-0.1, 0.01, 0., 0.") +
         matrix("R", 3, 3, "1., 0., 0., 0., 1., 0., 0., 0., 1.") + matrix("T", 3, 1, "-0.25, 0., 0.");
}

std::string kitti_form(double cx, double cy) {
  const std::string p{fmt::format("150 0 {} ", cx)};
  const std::string q{fmt::format(" 0 150 {} 0 0 0 1 0\n", cy)};
  return "P0: " + p + "0" + q + "P1: " + p + "-37.5" + q;
}

struct ImageSize : FolderTest {
  [[nodiscard]] Calibration read(const std::string& name, const std::string& text, Size images) const {
    put(folder / name, text);
    return read_calibration(folder / name, images.width_px, images.height_px);
  }
  /// Calibration of 256×160 px without a size.
  void for_each_form(const std::function<void(const std::string& name, const std::string& text)>& action) const {
    action("calibration.yaml", own_form(127.5, 79.5));
    action("stereo.yml", opencv_form(127.5, 79.5));
    action("calib.txt", kitti_form(127.5, 79.5));
  }
};

TEST_F(ImageSize, OfAnExactRatioIsScaled) {
  for (const auto& [factor, images] : {std::pair{0.5, Size{128, 80}},
                                       {2, {512, 320}},
                                       {0.75, {192, 120}},
                                       {1.25, {320, 200}},
                                       {0.4, {102, 64}},      // 102.4
                                       {1.1, {282, 176}},     // 281.6
                                       {0.9, {231, 144}}}) {  // 230.4, rounded up
    const Calibration scaled{read("c.yaml", own_form(127.5, 79.5, "{width_px: 256, height_px: 160}"), images)};
    EXPECT_NEAR(scaled.rig.focal_px, 150 * factor, 0.5) << factor;
    EXPECT_NEAR(scaled.rig.cx_px, (images.width_px - 1) / 2.0, 1e-9) << factor;
    EXPECT_NEAR(scaled.rig.cy_px, (images.height_px - 1) / 2.0, 1e-9) << factor;
    EXPECT_EQ(scaled.rig.width_px, images.width_px);
    EXPECT_EQ(scaled.rig.height_px, images.height_px);
    EXPECT_EQ(scaled.rig.baseline_m, 0.25);
    EXPECT_THAT(scaled.warnings, IsEmpty());
    ASSERT_THAT(scaled.notes, ElementsAre(AllOf(HasSubstr("256×160"), HasSubstr("scaled by"))));
  }
}

TEST_F(ImageSize, OfARawPairIsScaledBeforeRectification) {
  CameraPair pair{raw_pair({-0.2, 0.05, 0.001, -0.0005}, {-0.18, 0.04, 0, 0.0008})};
  pair.width_px = 320;
  pair.height_px = 240;
  CameraPair half{pair};
  half.width_px /= 2;
  half.height_px /= 2;
  for (CameraModel* camera : {&half.cameras.left, &half.cameras.right}) {
    camera->focal_u_px /= 2;
    camera->focal_v_px /= 2;
    camera->cx_px = (camera->cx_px + 0.5) / 2 - 0.5;
    camera->cy_px = (camera->cy_px + 0.5) / 2 - 0.5;
  }
  for (const auto& form : {&ros_files, &kalibr_files, &own_files}) {
    put_files(folder / "half", form(half));
    put_files(folder / "whole", form(pair));
    const std::string name{form(pair).size() == 2 ? "left.yaml" : form(pair).begin()->first};
    const Calibration expected{read_calibration(folder / "half" / name, 160, 120)};
    const Calibration scaled{read_calibration(folder / "whole" / name, 160, 120)};
    ASSERT_TRUE(scaled.raw) << name;
    EXPECT_NEAR(scaled.raw->right.cx_px, half.cameras.right.cx_px, 1e-9);
    EXPECT_NEAR(scaled.rig.focal_px, expected.rig.focal_px, 1e-6) << name;
    EXPECT_NEAR(scaled.rig.cy_px, expected.rig.cy_px, 1e-6) << name;
    EXPECT_EQ(scaled.rig.width_px, 160);
  }
}

TEST_F(ImageSize, OfACameraInfoIsScaled) {
  RosCamera left{"left",
                 256,
                 160,
                 "plumb_bob",
                 std::vector<double>(5),
                 {150, 0, 127.5, 0, 150, 79.5, 0, 0, 1},
                 {1, 0, 0, 0, 1, 0, 0, 0, 1},
                 {150, 0, 127.5, 0, 0, 150, 79.5, 0, 0, 0, 1, 0}};
  RosCamera right{left};
  right.p[3] = -37.5;
  Calibration calibration{ros_calibration(left, right, true)};
  fit_to_images(calibration, "/left/camera_info", 128, 80);
  EXPECT_EQ(calibration.rig, (Rig{128, 80, 75, 63.5, 39.5, 0.25}));
  expect_error([&] { fit_to_images(calibration, "/left/camera_info", 100, 80); },
               {"/left/camera_info", "128×80", "100×80"});
}

TEST_F(ImageSize, OfNoExactRatioIsRefused) {
  const std::string kitti{own_form(609.5, 172.8, "{width_px: 1242, height_px: 375}")};
  for (const Size images : {Size{1226, 370}, {1241, 376}, {621, 180}, {1242, 374}, {1392, 512}}) {
    expect_error([&] { return read("c.yaml", kitti, images); },
                 {"1242×375", fmt::format("{}×{}", images.width_px, images.height_px), "not an exact multiple",
                  "principal point"});
  }
}

TEST_F(ImageSize, ThatIsNotStatedIsSeenByThePrincipalPoint) {
  for (const double factor : {0.4, 0.5, 0.6, 0.667, 0.75, 0.8, 1.25, 1.5, 2.0, 3.0}) {
    const Size images{static_cast<int>(std::lround(256 * factor)), static_cast<int>(std::lround(160 * factor))};
    for_each_form([&](const std::string& name, const std::string& text) {
      SCOPED_TRACE(fmt::format("{} {}", name, factor));
      expect_error([&] { return read(name, text, images); }, {name, "principal point (127.5, 79.5)", "about 256×160 px",
                                                              "scaled by", "'image: {width_px: 256, height_px: 160}'"});
    });
  }
}

TEST_F(ImageSize, ThatMayBeAnotherIsWarnedOf) {
  for (const double factor : {0.9, 1.1}) {
    const Size images{static_cast<int>(std::lround(256 * factor)), static_cast<int>(std::lround(160 * factor))};
    for_each_form([&](const std::string& name, const std::string& text) {
      EXPECT_THAT(read(name, text, images).warnings, ElementsAre(HasSubstr("about 256×160 px")))
          << name << " " << factor;
    });
  }
}

TEST_F(ImageSize, OfCroppedImagesIsReported) {
  for (const Size images : {Size{164, 160}, {205, 160}, {230, 160}, {256, 103}, {256, 144}}) {
    for_each_form([&](const std::string& name, const std::string& text) {
      EXPECT_THAT(read(name, text, images).warnings, ElementsAre(AllOf(HasSubstr("cropped"), HasSubstr("'image: {"))))
          << name << " " << images.width_px;
    });
  }
  for (const Size images : {Size{144, 160}, {256, 96}, {128, 160}}) {
    for_each_form([&](const std::string& name, const std::string& text) {
      expect_error([&] { return read(name, text, images); }, {name, "cropped"});
    });
  }
}

TEST_F(ImageSize, ThatIsStatedCounts) {
  const std::string size{"{width_px: 144, height_px: 100}"};
  const Calibration cropped{read("c.yaml", own_form(127.5, 79.5, size), {144, 100})};
  EXPECT_EQ(cropped.rig.cx_px, 127.5);
  EXPECT_THAT(cropped.warnings, ElementsAre(HasSubstr("Check that")));
  EXPECT_THAT(read("c.yaml", own_form(97.5, 59.5, "{width_px: 210, height_px: 130}"), {210, 130}).warnings, IsEmpty());
  for_each_form([&](const std::string& name, const std::string& text) {
    if (name == "calibration.yaml") return;
    put(folder / name, text);
    const auto named = [&](const char* stated, Size images) {
      return read("c.yaml", "from: " + name + "\nimage: " + stated + "\n", images);
    };
    EXPECT_EQ(named("{width_px: 144, height_px: 100}", {144, 100}).rig.width_px, 144) << name;
    const Calibration whole{named("{width_px: 256, height_px: 160}", {256, 160})};
    const Calibration half{named("{width_px: 256, height_px: 160}", {128, 80})};
    EXPECT_NEAR(half.rig.focal_px, whole.rig.focal_px / 2, 1e-3 * whole.rig.focal_px) << name;
    EXPECT_NEAR(half.rig.cx_px, 63.5, 0.1) << name;
    EXPECT_THAT(half.warnings, IsEmpty());
  });
}

// Centres of rectified and raw cameras as real data sets have them.
TEST_F(ImageSize, OfRealCamerasIsAccepted) {
  struct Camera {
    double cx;
    double cy;
    Size images;
  };
  for (const Camera& camera : {Camera{601.8873, 183.1104, {1226, 370}},
                               {609.5593, 172.854, {1242, 375}},
                               {635.96, 194.13, {1344, 391}},
                               {328.8657, 249.43, {640, 480}},
                               {367.215, 248.375, {752, 480}},
                               {379.999, 255.238, {752, 480}},
                               {338.4, 186.9, {672, 376}},
                               {640, 360, {1280, 720}}}) {
    EXPECT_THAT(read("calib.txt", kitti_form(camera.cx, camera.cy), camera.images).warnings, IsEmpty()) << camera.cx;
  }
}

}  // namespace
}  // namespace stereogrid::io::testing
