// SPDX-License-Identifier: Apache-2.0
// Other arrangements of images than left/ and right/: other names, both cameras in one image or folder, videos, EuRoC.
#include <algorithm>
#include <array>
#include <cstdlib>

#include "stereogrid/io/recording.hpp"
#include "support.hpp"

namespace stereogrid::io::testing {
namespace {

constexpr const char* calibration{
    "focal_px: 60\ncx_px: 31.5\ncy_px: 15.5\nbaseline_m: 0.2\nmount: {camera_height_m: 1.2}\n"};
constexpr int width_px{64};
constexpr int height_px{32};

Image<std::uint8_t> flat(int width, int height, int grey) {
  return Image<std::uint8_t>{width, height, static_cast<std::uint8_t>(grey)};
}

/// Left half 50, right half 150; or upper and lower.
Image<std::uint8_t> both(bool is_beside) {
  Image<std::uint8_t> image{flat(is_beside ? 2 * width_px : width_px, is_beside ? height_px : 2 * height_px, 50)};
  for (const auto [u, v] : raster(is_beside ? width_px : 0, image.width(), is_beside ? 0 : height_px, image.height()))
    image.row(v)[u] = 150;
  return image;
}

struct Layouts : FolderTest {
  void put_image(const fs::path& name, int grey) const {
    fs::create_directories((folder / name).parent_path());
    write_png(folder / name, flat(width_px, height_px, grey));
  }
  /// Frames of 50 at the left and 150 at the right, whose lossy codecs may be off by a few levels.
  void expect_pairs(const InputArguments& arguments, std::size_t frames, int off = 0) const {
    const auto recording{open_recording(arguments)};
    ASSERT_EQ(recording->size(), frames);
    for (std::size_t i{0}; i < frames; ++i) {
      const StereoFrame frame{recording->load(i)};
      ASSERT_EQ(frame.left.width(), width_px);
      ASSERT_EQ(frame.left.height(), height_px);
      EXPECT_NEAR(frame.left.row(16)[32], 50, off);
      EXPECT_NEAR(frame.right.row(16)[32], 150, off);
    }
  }
  void put_video(const char* name, const Image<std::uint8_t>& image, int frames, int rate_hz = 20) const {
    write_png(folder / "frame.png", image);
    const std::string command{"ffmpeg -loglevel error -y -loop 1 -r " + std::to_string(rate_hz) + " -i " +
                              (folder / "frame.png").string() + " -frames:v " + std::to_string(frames) +
                              " -c:v mjpeg " + (folder / name).string()};
    ASSERT_EQ(std::system(command.c_str()), 0);
  }
};

TEST_F(Layouts, NamesOfFoldersAndFiles) {
  struct Names {
    const char* left;
    const char* right;
  };
  for (const auto& [left, right] :
       {Names{"cam0/1.png", "cam1/1.png"}, Names{"left_images/1.png", "right_images/1.png"},
        Names{"infra1/1.png", "infra2/1.png"}, Names{"L/1.png", "R/1.png"},
        Names{"left/left_1.png", "right/right_1.png"}, Names{"cam0/data/1.png", "cam1/data/1.png"},
        Names{"1_left.png", "1_right.png"}, Names{"im0.png", "im1.png"}, Names{"left/1_L.png", "right/1_R.png"}}) {
    put_image(left, 50);
    put_image(right, 150);
    put(folder / "calibration.yaml", calibration);
    SCOPED_TRACE(left);
    expect_pairs({{folder.path()}, {}, "none"}, 1);
    for (const auto& entry : fs::directory_iterator{folder.path()}) fs::remove_all(entry.path());
  }
}

TEST_F(Layouts, BothCamerasInEachImage) {
  put(folder / "calibration.yaml", calibration);
  for (const bool is_beside : {true, false}) {
    for (const char* const name : {"1.png", "2.png"}) write_png(folder / name, both(is_beside));
    expect_pairs({{folder.path()}, {}, "none"}, 2);
    InputArguments named{{folder.path()}, {}, "none"};
    named.layout = is_beside ? ImageLayout::side_by_side : ImageLayout::top_bottom;
    expect_pairs(named, 2);
  }
}

TEST_F(Layouts, LayoutOfSeparateImagesIsRefused) {
  put_plain(folder.path());
  InputArguments arguments{{folder.path()}, {}, "none"};
  arguments.layout = ImageLayout::side_by_side;
  expect_no_recording(arguments, {"--layout has no effect"});
}

TEST_F(Layouts, LayoutThatIsNotClear) {
  put(folder / "calibration.yaml", "focal_px: 60\ncx_px: 3\ncy_px: 3\nbaseline_m: 0.2\n");
  write_png(folder / "1.png", flat(90, 60, 50));
  expect_no_recording({{folder.path()}, {}, "none"}, {"90×60 px", "--layout side-by-side"});
}

TEST_F(Layouts, Videos) {
  if (std::system("ffmpeg -version >/dev/null 2>&1") != 0) GTEST_SKIP() << "ffmpeg is not here";
  put(folder / "c" / "calibration.yaml", calibration);
  const fs::path file{folder / "c" / "calibration.yaml"};
  put_video("beside.avi", both(true), 5);
  put_video("above.avi", both(false), 5);
  put_video("left.avi", flat(width_px, height_px, 50), 5);
  put_video("right.avi", flat(width_px, height_px, 150), 4);
  expect_pairs({{folder / "beside.avi"}, file, "none"}, 5, 4);
  expect_pairs({{folder / "above.avi"}, file, "none"}, 5, 4);
  expect_pairs({{folder / "left.avi", folder / "right.avi"}, file, "none"}, 4, 4);
  const auto recording{open_recording({{folder / "beside.avi"}, file, "none"})};
  EXPECT_EQ(recording->contents().frames[2].stamp_ns, 100'000'000) << "20 frames a second";
  EXPECT_NEAR(recording->load(4).right.row(16)[32], 150, 4);
  EXPECT_NEAR(recording->load(1).right.row(16)[32], 150, 4) << "earlier than the last one";

  put_video("slow.avi", flat(width_px, height_px, 150), 5, 15);
  const auto warnings_with{[&](const char* right) {
    return open_recording({{folder / "left.avi", folder / right}, file, "none"})->contents().warnings;
  }};
  EXPECT_THAT(warnings_with("right.avi"), ::testing::ElementsAre(::testing::HasSubstr("5 frames")));
  EXPECT_THAT(warnings_with("slow.avi"), ::testing::ElementsAre(::testing::HasSubstr("differ by 0.067 s")));
}

TEST_F(Layouts, ImagesInAFolderOfTheCamera) {
  put(folder / "calibration.yaml", calibration);
  put_image("left/data/1.png", 50);
  put_image("right/data/1.png", 150);
  expect_pairs({{folder.path()}, {}, "none"}, 1);
}

// img0 and img1 of a longer sequence are no pair.
TEST_F(Layouts, NumbersMayCountFrames) {
  put(folder / "calibration.yaml", calibration);
  for (const char* const name : {"img0.png", "img1.png", "img2.png"}) write_png(folder / name, both(true));
  expect_pairs({{folder.path()}, {}, "none"}, 3);
}

TEST_F(Layouts, ImagesWithDepthOfTumAndScanNet) {
  const auto put_depth{[&](const fs::path& name, std::uint16_t value) {
    fs::create_directories((folder / name).parent_path());
    write_png(folder / name, Image<std::uint16_t>{width_px, height_px, value});
  }};
  put_image("tum/rgb/1305031102.175304.png", 50);
  put_image("tum/rgb/1305031103.175304.png", 50);
  put_depth("tum/depth/1305031102.160407.png", 10000);
  put(folder / "tum/rgb.txt", "# x\n");
  put(folder / "tum/depth.txt", "# x\n");
  put(folder / "tum/calibration.yaml", calibration);
  const auto tum{open_recording({{folder / "tum"}, {}, "none"})};
  ASSERT_EQ(tum->size(), 2);
  EXPECT_EQ(tum->contents().frames[0].stamp_ns, 1305031102175304000);
  EXPECT_FALSE(tum->contents().frames[1].right_exists) << "no depth within 20 ms";
  EXPECT_NEAR(tum->load(0).disparity(5, 5), 60 * 0.2 / 2, 1e-4) << "10000 are 2 m";

  put_image("scan/color/0.png", 50);
  put_depth("scan/depth/0.png", 2000);
  put(folder / "scan/intrinsic/intrinsic_color.txt", "60 0 31.5 0\n0 60 15.5 0\n0 0 1 0\n0 0 0 1\n");
  put(folder / "scan/intrinsic/intrinsic_depth.txt", "30 0 15.5 0\n0 30 7.5 0\n0 0 1 0\n0 0 0 1\n");
  put(folder / "scan/intrinsic/extrinsic_color.txt", "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  const auto scan{open_recording({{folder / "scan"}, {}, "none"})};
  EXPECT_DOUBLE_EQ(scan->rig().focal_px, 60);
  EXPECT_NEAR(scan->load(0).disparity(5, 5), 60 * scan->rig().baseline_m / 2, 1e-4);
}

TEST_F(Layouts, MiddleburyWithDisparitiesInPfm) {
  put_image("im0.png", 50);
  std::string pfm{"Pf\n64 32\n-1\n"};
  const float d_px{9};
  for (int i{0}; i < width_px * height_px; ++i) pfm.append(reinterpret_cast<const char*>(&d_px), sizeof d_px);
  put(folder / "disp0.pfm", pfm);
  put(folder / "calib.txt",
      "cam0=[60 0 31.5; 0 60 15.5; 0 0 1]\ncam1=[60 0 34.5; 0 60 15.5; 0 0 1]\ndoffs=3\nbaseline=200\nwidth=64\n"
      "height=32\n");
  const auto recording{open_recording({{folder.path()}, {}, "none"})};
  EXPECT_NEAR(recording->load(0).disparity(5, 5), 12, 1e-6) << "d + doffs";
}

TEST_F(Layouts, EurocNamesAreStamps) {
  const auto sensor{[](double x_m) {
    return "T_BS: {cols: 4, rows: 4, data: [1, 0, 0, " + std::to_string(x_m) +
           ", 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}\nresolution: [64, 32]\ncamera_model: pinhole\n"
           "intrinsics: [60, 60, 31.5, 15.5]\ndistortion_model: radial-tangential\n"
           "distortion_coefficients: [0, 0, 0, 0]\n";
  }};
  for (const bool is_cam0_left : {true, false}) {
    put(folder / "mav0/cam0/sensor.yaml", sensor(0));
    put(folder / "mav0/cam1/sensor.yaml", sensor(is_cam0_left ? 0.2 : -0.2));
    put(folder / "mav0/cam0/data.csv", "#timestamp [ns],filename\r\n1500000000100000000,1500000000100000000.png\r\n");
    put_image("mav0/cam0/data/1500000000100000000.png", is_cam0_left ? 50 : 150);
    put_image("mav0/cam1/data/1500000000100000000.png", is_cam0_left ? 150 : 50);
    for (const fs::path& input : {folder.path(), folder / "mav0"}) {
      expect_pairs({{input}, {}, "none"}, 1);
      EXPECT_EQ(open_recording({{input}, {}, "none"})->contents().frames[0].stamp_ns, 1500000000100000000);
    }
  }
}

TEST_F(Layouts, EurocsGroundTruthIsTheFoldersOwn) {
  constexpr const char* t_bs{"T_BS: {cols: 4, rows: 4, data: [0, 0, 1, 0, -1, 0, 0, "};  // the camera faces x
  for (const char* const camera : {"cam0", "cam1"}) {
    const bool is_left{std::string_view{camera} == "cam0"};
    put(folder / "mav0" / camera / "sensor.yaml",
        std::string{t_bs} + (is_left ? "0.1" : "-0.1") +
            ", 0, -1, 0, 0, 0, 0, 0, 1]}\nresolution: [64, 32]\ncamera_model: pinhole\nintrinsics: [60, 60, 31.5, "
            "15.5]\ndistortion_model: radial-tangential\ndistortion_coefficients: [0, 0, 0, 0]\n");
    for (const char* const stamp : {"1500000000100000000", "1500000000200000000"}) {
      put_image(fs::path{"mav0"} / camera / "data" / (std::string{stamp} + ".png"), is_left ? 50 : 150);
    }
  }
  std::string rows{
      "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z []\n"};
  for (int i{0}; i < 5; ++i) {
    rows += std::to_string(1500000000050000000 + 50000000L * i) + "," + std::to_string(0.5 * i) + ",0,1,1,0,0,0\n";
  }
  put(folder / "mav0/state_groundtruth_estimate0/data.csv", rows);
  for (const fs::path& input : {folder.path(), folder / "mav0"}) {
    const auto recording{open_recording({{input}, {}, ""})};
    ASSERT_TRUE(recording->has_poses());
    const Pose2 first{*recording->load(0).world_from_vehicle};
    const Pose2 second{*recording->load(1).world_from_vehicle};
    EXPECT_NEAR((inverse(first) * second).x_m, 1, 1e-6);
    EXPECT_NEAR((inverse(first) * second).y_m, 0, 1e-6);
  }
  EXPECT_FALSE(open_recording({{folder.path()}, {}, "none"})->has_poses());
}

TEST_F(Layouts, CalibrationOfAnyNameBesideTheImages) {
  put_image("left/1.png", 50);
  put_image("right/1.png", 150);
  put(folder / "my_camera.json",
      R"({"K1":[[60,0,31.5],[0,60,15.5],[0,0,1]],"D1":[0,0,0,0],"K2":[[60,0,31.5],[0,60,15.5],[0,0,1]],)"
      R"("D2":[0,0,0,0],"R":[[1,0,0],[0,1,0],[0,0,1]],"T":[-0.2,0,0]})");
  expect_pairs({{folder.path()}, {}, "none"}, 1);
  put(folder / "my_camera.json", "{\"a\": 1}");
  expect_no_recording({{folder.path()}, {}, "none"}, {"no calibration", "my_camera.json is there", "--calibration"});
}

TEST_F(Layouts, TwoFolders) {
  for (const char* const name : {"1", "2"}) {
    put_image(fs::path{"a/front_l"} / (std::string{name} + "_leftImg8bit.png"), 50);
    put_image(fs::path{"a/front_r"} / (std::string{name} + "_rightImg8bit.png"), 150);
  }
  put(folder / "a" / "calibration.yaml", calibration);
  expect_pairs({{folder / "a" / "front_l", folder / "a" / "front_r"}, {}, "none"}, 2);
  fs::rename(folder / "a" / "calibration.yaml", folder / "c.yaml");
  expect_pairs({{folder / "a" / "front_l", folder / "a" / "front_r"}, folder / "c.yaml", "none"}, 2);
}

TEST_F(Layouts, PairOfThreeCameras) {
  put_image("cam0/1.png", 50);
  put_image("cam2/1.png", 150);
  const std::string camera{
      "  camera_model: pinhole\n  distortion_model: none\n  intrinsics: [60, 60, 31.5, 15.5]\n  resolution: [64, "
      "32]\n"};
  const auto behind{[](const char* x) {
    return std::string{"  T_cn_cnm1: [[1, 0, 0, "} + x + "], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n";
  }};
  put(folder / "camchain.yaml",
      "cam0:\n" + camera + "cam1:\n" + behind("-0.1") + camera + "cam2:\n" + behind("-0.15") + camera);
  const auto recording{open_recording({{folder.path()}, {}, "none"})};
  EXPECT_NEAR(recording->rig().baseline_m, 0.25, 1e-12);
}

TEST_F(Layouts, DepthWithMoreWordsInItsNames) {
  put(folder / "calibration.yaml", calibration);
  for (const auto& [left, depth] :
       {std::array{"image_left/000000_left.png", "depth_left/000000_left_depth.pfm"},
        std::array{"rgb/rgb_0000.png", "distance_to_image_plane/distance_to_image_plane_0000.pfm"}}) {
    put_image(left, 50);
    std::string pfm{"Pf\n64 32\n-1.0\n"};
    for (int i{0}; i < width_px * height_px; ++i) pfm.append("\0\0\x80\x3f", 4);  // 1 m
    put(folder / depth, pfm);
    const InputArguments arguments{{folder.path()}, {}, "none", {}, folder / fs::path{depth}.parent_path()};
    EXPECT_NEAR(open_recording(arguments)->load(0).disparity(5, 5), 12, 1e-5) << left;
    fs::remove_all(folder / fs::path{left}.parent_path());
  }
}

TEST_F(Layouts, FormatsThatAreNotReadAreNamed) {
  put(folder / "calibration.yaml", calibration);
  put(folder / "left" / "1.jp2", "x");
  put(folder / "right" / "1.jp2", "x");
  expect_no_recording({{folder.path()}, {}, "none"}, {"1 files .jp2 (JPEG 2000)"});
  for (const auto& [name, what] : {std::array{"a.svo2", "ZED"}, std::array{"a.zip", "zip archive"}}) {
    put(folder / name, "x");
    expect_no_recording({{folder / name}, {}, "none"}, {name, what});
  }
}

TEST_F(Layouts, UpsideDownPairsAreTurned) {
  const StereoFrame frame{textured_pair(256, 64, 6)};
  const auto turned{[](const Image<std::uint8_t>& image) {
    Image<std::uint8_t> result{image};
    std::reverse(result.begin(), result.end());
    return result;
  }};
  const std::string own{"focal_px: 150\ncx_px: 125\ncy_px: 33\nbaseline_m: 0.25\n"};
  put(folder / "calibration.yaml", own + "rotate: 180\n");
  for (const bool is_rig : {true, false}) {  // the rig is upside down, or each camera
    for (const char* const side : {"left", "right"}) fs::create_directories(folder / side);
    write_png(folder / "left" / "1.png", turned(is_rig ? frame.right : frame.left));
    write_png(folder / "right" / "1.png", turned(is_rig ? frame.left : frame.right));
    const auto recording{open_recording({{folder.path()}, {}, "none"})};
    const StereoFrame found{recording->load(0)};
    EXPECT_EQ(found.left, frame.left) << is_rig;
    EXPECT_EQ(found.right, frame.right) << is_rig;
    EXPECT_DOUBLE_EQ(recording->rig().cx_px, is_rig ? 130 : 125);
    EXPECT_DOUBLE_EQ(recording->rig().cy_px, is_rig ? 30 : 33);
  }
  put(folder / "calibration.yaml", own + "cx_right_px: 128\nrotate: 180\n");
  for (const char* const side : {"left", "right"}) {
    write_png(folder / side / "1.png", turned(side[0] == 'l' ? frame.right : frame.left));
  }
  const auto raw{open_recording({{folder.path()}, {}, "none"})->contents().calibration.raw};
  ASSERT_TRUE(raw);
  EXPECT_DOUBLE_EQ(raw->left.cx_px, 127);
  EXPECT_DOUBLE_EQ(raw->right.cx_px, 130);
  EXPECT_NEAR(raw->right_from_left_translation_m[0], -0.25, 1e-12);
  put(folder / "calibration.yaml", own + "rotate: 90\n");
  expect_no_recording({{folder.path()}, {}, "none"}, {"neither 0 nor 180"});
}

TEST_F(Layouts, StampsInNames) {
  put(folder / "calibration.yaml", calibration);
  struct Names {
    const char* first;
    const char* second;
    std::int64_t stamp_ns;
  };
  for (const auto& [first, second, stamp_ns] :
       {Names{"1400505794141322", "1400505794203822", 1400505794141322000},
        Names{"1573551234567", "1573551234600", 1573551234567000000},
        Names{"img_1573551234567000000", "img_1573551234600000000", 1573551234567000000},
        Names{"20191112093354567", "20191112093354600", 1573551234567000000}}) {
    for (const char* const name : {first, second}) {
      put_image(fs::path{"left"} / (std::string{name} + ".png"), 50);
      put_image(fs::path{"right"} / (std::string{name} + ".png"), 150);
    }
    const auto recording{open_recording({{folder.path()}, {}, "none"})};
    EXPECT_EQ(recording->contents().frames[0].stamp_ns, stamp_ns) << first;
    EXPECT_TRUE(recording->contents().warnings.empty()) << first;
    fs::remove_all(folder / "left");
    fs::remove_all(folder / "right");
  }
}

}  // namespace
}  // namespace stereogrid::io::testing
