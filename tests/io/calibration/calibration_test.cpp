// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/calibration.hpp"

#include <algorithm>
#include <limits>

#include "stereogrid/io/file.hpp"
#include "stereogrid/io/recording.hpp"
#include "support.hpp"

namespace stereogrid::io::testing {
namespace {

constexpr const char* odometry{
    "P0: 700 0 600 0 0 700 180 0 0 0 1 0\n"
    "P1: 700 0 600 -378 0 700 180 0 0 0 1 0\n"
    "P2: 700 0 600 42 0 700 180 0.7 0 0 1 0.003\n"
    "P3: 700 0 600 -336 0 700 180 0.7 0 0 1 0.003\n"
    "Tr: 0 -1 0 0.01 0 0 -1 -0.08 1 0 0 -0.27\n"};

constexpr const char* raw_drive{
    "calib_time: 09-Jan-2012 13:57:47\n"
    "S_rect_00: 1.242e+03 3.75e+02\n"
    "R_rect_00: 1 0 0 0 1 0 0 0 1\n"
    "P_rect_00: 721.5 0 609.5 0 0 721.5 172.8 0 0 0 1 0\n"
    "P_rect_01: 721.5 0 609.5 -387.5 0 721.5 172.8 0 0 0 1 0\n"};

std::string rectified(const std::string& baseline = "0.22", const std::string& rest = "",
                      const std::string& mount = "{camera_height_m: 1.25, camera_pitch_rad: 0.1}") {
  return "image: {width_px: 512, height_px: 320}\nfocal_px: 410.0\ncx_px: 256.0\ncy_px: "
         "160.0\nbaseline_m: " +
         baseline + "\nmount: " + mount + "\n" + rest;
}

struct CalibrationFile : FolderTest {
  [[nodiscard]] Calibration read(const std::string& name, const std::string& text, int width_px = 0, int height_px = 0,
                                 KittiPair pair = KittiPair::grey) const {
    put(folder / name, text);
    return read_calibration(folder / name, width_px, height_px, pair);
  }
  void expect_refused(const std::string& name, const std::string& text,
                      std::initializer_list<std::string_view> parts) const {
    expect_error([&] { return read(name, text, 512, 320); }, parts);
    expect_error([&] { return read(name, text, 512, 320); }, {name});
  }
};

TEST_F(CalibrationFile, OwnFormRoundTrips) {
  const Rig rig{1241, 377, 707.0912, 601.8873, 183.1104, 0.53715, 1.65, -0.0139626, 0.001};
  write_calibration_yaml(folder / "calibration.yaml", rig);
  const auto read{read_calibration(folder / "calibration.yaml", 1241, 377)};
  EXPECT_EQ(read.rig, rig);
  EXPECT_FALSE(read.raw);
}

TEST_F(CalibrationFile, FormerNamesAreRead) {
  const std::string rest{"centre_v_px: 160\nbaseline_m: 0.22\n"};
  const Rig rig{read("c.yaml", "focal_px: 410\ncentre_u_px: 256\n" + rest, 512, 320).rig};
  EXPECT_EQ(rig.cx_px, 256);
  EXPECT_EQ(rig.cy_px, 160);
  expect_refused("d.yaml", "focal_px: 410\ncx_px: 256\ncentre_u_px: 256\n" + rest, {"unknown key 'centre_u_px'"});
}

TEST_F(CalibrationFile, TheMaskStandsBesideIt) {
  EXPECT_EQ(read("c.yaml", rectified("0.22", "mask: masks/bonnet.png\n")).mask, folder / "masks/bonnet.png");
  EXPECT_EQ(read("c.yaml", rectified("0.22", "mask: /a/bonnet.png\n")).mask, "/a/bonnet.png");
  EXPECT_EQ(read("c.yaml", rectified()).mask, "");
  for (const char* mask : {"mask:\n", "mask: ''\n", "mask: [1]\n", "mask: \"a\\0b\"\n"}) {
    expect_refused("c.yaml", rectified("0.22", mask), {"'mask' in line", "is not a file's name"});
  }
}

TEST_F(CalibrationFile, OwnForm) {
  const Rig rig{read("c.yaml", rectified()).rig};
  EXPECT_EQ(rig, (Rig{512, 320, 410, 256, 160, 0.22, 1.25, 0.1, 0}));
}

TEST_F(CalibrationFile, SizeComesFromTheImagesWhereTheFileHasNone) {
  EXPECT_EQ(read("calib.txt", odometry, 1226, 370).rig.width_px, 1226);
  EXPECT_EQ(read("c.yaml", "focal_px: 9\ncx_px: 32\ncy_px: 24\nbaseline_m: 1\nmount: {camera_height_m: 1}\n", 64, 48)
                .rig.height_px,
            48);
}

TEST_F(CalibrationFile, KittiOdometry) {
  const auto grey{read("calib.txt", odometry, 1226, 370)};
  EXPECT_EQ(grey.kind, "KITTI odometry");
  EXPECT_EQ(grey.rig, (Rig{1226, 370, 700, 600, 180, 0.54, 1.65, 0, 0}));
  ASSERT_TRUE(grey.camera_from_velodyne);
  EXPECT_DOUBLE_EQ(grey.camera_from_velodyne->at(3), 0.01);
}

TEST_F(CalibrationFile, KittiColourPairIsItsOwnReference) {
  const auto colour{read("calib.txt", odometry, 1226, 370, KittiPair::colour)};
  EXPECT_DOUBLE_EQ(colour.rig.baseline_m, 0.54);
  // camera 2 stands 6 cm left of camera 0: a point lies 6 cm further right in its frame, less what z makes of the
  // centre
  EXPECT_NEAR(colour.camera_from_velodyne->at(3), 0.01 + (42 - 600 * 0.003) / 700, 1e-12);
  EXPECT_NEAR(colour.camera_from_velodyne->at(11), -0.27 + 0.003, 1e-12);
}

TEST_F(CalibrationFile, KittiRaw) {
  put(folder / "calib_velo_to_cam.txt", "calib_time: x\nR: 0 -1 0 0 0 -1 1 0 0\nT: 0.1 0.2 0.3\n");
  const auto raw{read("calib_cam_to_cam.txt", raw_drive, 1242, 375)};
  EXPECT_EQ(raw.kind, "KITTI raw");
  EXPECT_NEAR(raw.rig.baseline_m, 387.5 / 721.5, 1e-12);
  ASSERT_TRUE(raw.camera_from_velodyne);
  EXPECT_EQ(*raw.camera_from_velodyne, (Transform{0, -1, 0, 0.1, 0, 0, -1, 0.2, 1, 0, 0, 0.3}));
}

TEST_F(CalibrationFile, KittiRawOfOtherImages) {
  put(folder / "calib_cam_to_cam.txt", raw_drive);
  expect_error([&] { return read_calibration(folder / "calib_cam_to_cam.txt", 1392, 512); },
               {"1242×375", "1392×512", "synced"});
}

TEST_F(CalibrationFile, RejectsTheBaseline) {
  expect_refused("c.yaml", rectified("0"), {"baseline is zero"});
  expect_refused("c.yaml", rectified("-0.22"), {"negative", "swapped"});
  expect_refused("c.yaml", rectified("220"), {"millimetres", "divide by 1000"});
  expect_refused("c.yaml", rectified("22"), {"centimetres or millimetres", "divide by 100 or 1000"});
  expect_refused("calib.txt", "P0: 700 0 300 0 0 700 180 0 0 0 1 0\nP1: 700 0 300 0 0 700 180 0 0 0 1 0\n", {"zero"});
  expect_refused("calib.txt", "P0: 700 0 300 0 0 700 180 0 0 0 1 0\nP1: 700 0 300 378 0 700 180 0 0 0 1 0\n",
                 {"swapped"});
}

TEST_F(CalibrationFile, KittiOfColourCamerasAlone) {
  const auto found{read("calib.txt", "P2: 700 0 300 0 0 700 180 0 0 0 1 0\nP3: 700 0 300 -378 0 700 180 0 0 0 1 0\n")};
  EXPECT_NEAR(found.rig.baseline_m, 0.54, 1e-12);
  EXPECT_THAT(found.notes, ::testing::Contains(::testing::HasSubstr("P2 and P3")));
}

TEST_F(CalibrationFile, KittiWithABaselineInPlaceOfItsProduct) {
  expect_refused("calib.txt", "P0: 700 0 300 0 0 700 180 0 0 0 1 0\nP1: 700 0 300 -0.54 0 700 180 0 0 0 1 0\n",
                 {"has -0.54", "the baseline in metres", "here -378"});
}

TEST_F(CalibrationFile, MountingMayBeUnknown) {
  const Calibration unknown{read("c.yaml", "focal_px: 410\ncx_px: 32\ncy_px: 24\nbaseline_m: 1\n", 64, 48)};
  EXPECT_FALSE(unknown.has_extrinsics);
  EXPECT_EQ(unknown.rig, (Rig{64, 48, 410, 32, 24, 1, 1.65, 0, 0}));
  EXPECT_TRUE(read("c.yaml", rectified()).has_extrinsics);
  EXPECT_FALSE(read("calib.txt", odometry, 1226, 370).has_extrinsics);
}

TEST_F(CalibrationFile, RejectsMissingKeys) {
  expect_refused("c.yaml", "focal_px: 410\n", {"no 'cx_px'", "docs/input.md"});
  expect_refused("c.yaml", rectified("0.2", "", "{camera_pitch_rad: 0}"), {"no 'mount.camera_height_m'"});
  expect_refused("calib.txt", "P0: 700 0 600 0 0 700 180 0 0 0 1 0\n", {"'P1:"});
  expect_refused("calib.txt", "P0: 700 0 600 0\nP1: 1 2 3\n", {"not 12"});
  expect_refused("calib.txt", "hello\n", {"not a calibration that is known"});
  expect_refused("calib_cam_to_cam.txt", "P_rect_00: 721.5 0 609.5 0 0 721.5 172.8 0 0 0 1 0\n", {"P_rect_01"});
}

TEST_F(CalibrationFile, RejectsTypingErrors) {
  expect_refused("c.yaml", rectified("0.22", "basline_m: 3\n"), {"unknown key 'basline_m'", "line 7"});
  expect_refused("c.yaml", rectified("0.22", "baseline_m: 3\n"), {"has 'baseline_m' again in line 7"});
  expect_refused("c.yaml", rectified("0.22", "baseline_mm: 220\n"), {"line 7. Is 'baseline_m' meant?"});
  expect_refused("c.yaml", rectified("0.22", "focal_length: 4\n"), {"Is 'focal_px' meant?"});
  expect_refused("c.yaml", rectified("0.22 m"), {"'baseline_m' in line 5", "not a number"});
  expect_refused("c.yaml", rectified(".nan"), {"not a number"});
  expect_refused("c.yaml", "focal_px: [1\n", {"not YAML"});
  expect_refused("c.yaml", "just text\n", {"not a YAML mapping"});
  expect_refused("c.yaml", rectified("0.22", "", "5"), {"'mount' is not a group"});
  expect_refused("calib.txt", "P0: nan 0 600 0 0 700 180 0 0 0 1 0\nP1: 700 0 600 -9 0 700 180 0 0 0 1 0\n",
                 {"not finite"});
}

TEST_F(CalibrationFile, RejectsTheOptics) {
  const auto p{[](const std::string& f, const std::string& g, const std::string& u) {
    const std::string head{f + " 0 " + u + " "};
    const std::string tail{" 0 " + g + " 160 0 0 0 1 0\n"};
    return "P0: " + head + "0" + tail + "P1: " + head + "-200" + tail;
  }};
  expect_refused("calib.txt", p("0", "0", "256"), {"focal length is 0"});
  expect_refused("calib.txt", p("-400", "-400", "256"), {"focal length is -400"});
  expect_refused("calib.txt", p("400", "500", "256"), {"400 and 500", "rectified"});
  expect_refused("calib.txt", p("400", "400", "600"), {"principal point (600, 160)", "outside"});
  expect_refused("calib.txt", "P0: 400 0 256 0 0 400 160 0 0 0 1 0\nP1: 410 0 256 -200 0 410 160 0 0 0 1 0\n",
                 {"different focal lengths"});
  expect_refused("c.yaml", "image: {width_px: 640, height_px: 320}\n" + rectified().substr(39), {"640×320", "512×320"});
}

TEST_F(CalibrationFile, RejectsTheMount) {
  expect_refused("c.yaml", rectified("0.2", "", "{camera_height_m: 0}"), {"camera height is 0"});
  expect_refused("c.yaml", rectified("0.2", "", "{camera_height_m: -1.2}"), {"camera height is -1.2"});
  expect_refused("c.yaml", rectified("0.2", "", "{camera_height_m: 1, camera_pitch_rad: 3.0}"), {"pitch", "degrees"});
  expect_refused("c.yaml", rectified("0.2", "", "{camera_height_m: 1, camera_roll_rad: -1}"), {"roll", "degrees"});
}

TEST_F(CalibrationFile, NamesEveryProblemAtOnce) {
  expect_refused("c.yaml", rectified("0", "", "{camera_height_m: -1.2}"), {"baseline is zero", "camera height"});
}

TEST_F(CalibrationFile, MissingFile) {
  expect_error([&] { return read_calibration(folder / "none.yaml"); }, {"none.yaml", "no such file"});
}

TEST(RigProblems, NotFinite) {
  Rig rig{512, 320, 410, 256, 160, 0.22, 1.25, 0, 0};
  EXPECT_TRUE(problems(rig).empty());
  rig.camera_roll_rad = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(problems(rig), ::testing::ElementsAre(::testing::HasSubstr("not finite")));
}

TEST(Swapped, IsSeenOnTexturedPairs) {
  for (const int disparity_px : {4, 17, 60}) {
    StereoFrame frame{textured_pair(641, 239, disparity_px)};
    EXPECT_FALSE(finding_if_swapped(frame)) << disparity_px;
    std::swap(frame.left, frame.right);
    const auto error_text{finding_if_swapped(frame)};
    ASSERT_TRUE(error_text) << disparity_px;
    EXPECT_THAT(*error_text, ::testing::HasSubstr("swapped"));
  }
}

// Far above, near below, the right image 20 px off: the farthest points have −10 px.
TEST(Swapped, AShiftedRightImageIsNone) {
  const StereoFrame far{textured_pair(641, 240, 10)};
  const StereoFrame near{textured_pair(641, 240, 30)};
  StereoFrame frame{far};
  const auto set_below{[](Image<std::uint8_t>& to, const Image<std::uint8_t>& from) {
    for (int v{120}; v < 240; ++v) std::copy_n(from.row(v), from.width(), to.row(v));
  }};
  set_below(frame.left, near.left);
  set_below(frame.right, near.right);
  Rig rig;
  rig.cx_px = 320;
  EXPECT_FALSE(finding_if_shifted(frame, rig));
  for (int v{0}; v < 240; ++v) {
    auto* const row{frame.right.row(v)};
    std::rotate(row, row + 641 - 20, row + 641);
  }
  const auto shift_px{negative_disparity_px(frame)};
  ASSERT_TRUE(shift_px);
  EXPECT_NEAR(*shift_px, -10, 0.5);
  EXPECT_THAT(*finding_if_shifted(frame, rig), ::testing::HasSubstr("'cx_right_px: 330"));
  EXPECT_FALSE(finding_if_swapped(frame));
}

TEST(Swapped, IsNotClaimedWhereNothingCanBeSeen) {
  StereoFrame frame;
  EXPECT_FALSE(finding_if_swapped(frame)) << "no images";
  frame.left = frame.right = Image<std::uint8_t>{640, 240, 128};
  EXPECT_FALSE(finding_if_swapped(frame)) << "no texture";
  frame.left = textured_pair(640, 240, 3, 1).left;
  frame.right = textured_pair(640, 240, 3, 2).left;
  EXPECT_FALSE(finding_if_swapped(frame)) << "two images that have nothing in common";
  EXPECT_FALSE(finding_if_swapped(textured_pair(640, 240, 0))) << "all at infinity";
  EXPECT_FALSE(finding_if_swapped(textured_pair(20, 12, 2))) << "too small to tell";
}

}  // namespace
}  // namespace stereogrid::io::testing
