// SPDX-License-Identifier: Apache-2.0
// Calibrations of more tools: one rectified pair (fx 150, centre (127.5, 79.5), 0.25 m) in each format, and what is
// refused.
#include <fmt/format.h>

#include <array>
#include <opencv2/core/matx.hpp>
#include <opencv2/core/persistence.hpp>

#include "stereogrid/io/calibration.hpp"
#include "stereogrid/io/npz.hpp"
#include "support.hpp"

namespace stereogrid::io::testing {
namespace {

struct OtherFormats : FolderTest {
  [[nodiscard]] Calibration read(const char* name, const std::string& text) const {
    put(folder / name, text);
    return read_calibration(folder / name, 256, 160);
  }
  void refused(const char* name, const std::string& text, std::initializer_list<std::string_view> parts) const {
    expect_error([&] { return read(name, text); }, parts);
  }
  void expect_pair(const Calibration& calibration, const std::string& format) const {
    EXPECT_EQ(calibration.kind, format);
    EXPECT_FALSE(calibration.raw) << format;
    EXPECT_EQ(calibration.rig.width_px, 256) << format;
    EXPECT_EQ(calibration.rig.height_px, 160) << format;
    EXPECT_DOUBLE_EQ(calibration.rig.focal_px, 150) << format;
    EXPECT_DOUBLE_EQ(calibration.rig.cx_px, 127.5) << format;
    EXPECT_DOUBLE_EQ(calibration.rig.cy_px, 79.5) << format;
    EXPECT_NEAR(calibration.rig.baseline_m, 0.25, 1e-12) << format;
  }
};

/// As stereoCalibrate's results are dumped, with any names.
std::string opencv_dump(const char* matrix, const char* distortion, int format, bool is_row_of_lists = false) {
  cv::FileStorage file{"", cv::FileStorage::WRITE | cv::FileStorage::MEMORY | format};
  const cv::Matx33d k{150, 0, 127.5, 0, 150, 79.5, 0, 0, 1};
  for (const char* const side : {"1", "2"}) {
    if (is_row_of_lists) break;
    file << std::string{matrix} + side << cv::Mat{k};
    file << std::string{distortion} + side << cv::Mat{cv::Mat::zeros(1, 5, CV_64F)};
  }
  file << "R" << cv::Mat{cv::Matx33d::eye()} << "T" << cv::Mat{cv::Vec3d{-0.25, 0, 0}};
  file << "imageSize" << cv::Size{256, 160};
  return file.releaseAndGetString();
}

constexpr const char* matrix_150{"[[150, 0, 127.5], [0, 150, 79.5], [0, 0, 1]]"};

TEST_F(OtherFormats, OpenCvInGroupsAndOtherUnits) {
  const auto with{[](const std::string& text) {
    std::string whole{text};
    for (std::size_t at{whole.find('@')}; at != std::string::npos; at = whole.find('@'))
      whole.replace(at, 1, matrix_150);
    return whole;
  }};
  const std::string turn{R"("R": [[1, 0, 0], [0, 1, 0], [0, 0, 1]])"};
  expect_pair(read("a.json", with(R"({"left": {"camera_matrix": @, "dist_coeffs": [0, 0, 0, 0]}, "right": {"K": @,
    "D": [0, 0, 0, 0]}, "stereo": {)" +
                                  turn + R"(, "T": [[-0.25], [0], [0]]}})")),
              "OpenCV stereo calibration");
  expect_pair(read("a.json", with(R"({"mtx_l": @, "dist_l": [0, 0, 0, 0], "mtx_r": @, "dist_r": [0, 0, 0, 0],
    "rvec": [0, 0, 0], "tvec": [-250, 0, 0], "units": "mm", "imageSize": {"width": 256, "height": 160}})")),
              "OpenCV stereo calibration");
  expect_pair(read("a.json", R"({"fx": 150, "fy": 150, "ppx": 127.5, "ppy": 79.5, "baseline": 0.25})"),
              "OpenCV stereo calibration");
  refused("a.json", with(R"({"K1": @, "D1": [0, 0, 0, 0], "K2": @, "D2": [0, 0, 0, 0]})"), {"'R' and 'T'"});
  refused("a.json",
          with(R"({"K1": @, "D1": [0, 0, 0, 0], "K2": @, "D2": [0, 0, 0, 0], "unit": "ft", )" + turn +
               R"(, "T": [-0.25, 0, 0]})"),
          {"'ft'", "m, cm, mm"});
}

TEST_F(OtherFormats, LibrealsenseHasItsRotationByColumns) {
  const std::string camera{R"({"width": 256, "height": 160, "fx": 150, "fy": 150, "ppx": 127.5, "ppy": 79.5,
    "model": "brown_conrady", "coeffs": [0, 0, 0, 0, 0]})"};
  const std::string turn{"[0.9998, 0.02, 0, -0.02, 0.9998, 0, 0, 0, 1]"};
  const Calibration found{read("a.json", R"({"infra1": {"intrinsics": )" + camera + R"(}, "infra2": {"intrinsics": )" +
                                             camera + R"(}, "extrinsics": {"rotation": )" + turn +
                                             R"(, "translation": [-0.25, 0, 0]}})")};
  ASSERT_TRUE(found.raw);
  EXPECT_DOUBLE_EQ(found.raw->right_from_left_rotation[3], 0.02);
  EXPECT_DOUBLE_EQ(found.raw->left.cx_px, 127.5);
}

TEST_F(OtherFormats, OpenCvRectificationAlone) {
  expect_pair(read("a.json", R"({"P1": [[150, 0, 127.5, 0], [0, 150, 79.5, 0], [0, 0, 1, 0]],
    "P2": [[150, 0, 127.5, -37.5], [0, 150, 79.5, 0], [0, 0, 1, 0]]})"),
              "OpenCV stereo rectification");
  expect_pair(read("a.json", R"({"Q": [[1, 0, 0, -127.5], [0, 1, 0, -79.5], [0, 0, 0, 150], [0, 0, 4, 0]]})"),
              "OpenCV stereo rectification");
  const Calibration shifted{
      read("a.json", R"({"Q": [[1, 0, 0, -127.5], [0, 1, 0, -79.5], [0, 0, 0, 150], [0, 0, 4, 48]]})")};
  ASSERT_TRUE(shifted.raw);
  EXPECT_DOUBLE_EQ(shifted.raw->right.cx_px, 139.5);
  refused("a.json", R"({"P1": [[150, 0, 127.5, 0], [0, 150, 79.5, 0], [0, 0, 1, 0]],
    "P2": [[150, 0, 127.5, -37.5], [0, 150, 70, 0], [0, 0, 1, 0]]})",
          {"P2", "cy"});
}

TEST_F(OtherFormats, RightCentreInCalibrationYaml) {
  const std::string own{"focal_px: 150\ncx_px: 127.5\ncy_px: 79.5\nbaseline_m: 0.25\n"};
  const Calibration found{read("c.yaml", own + "cx_right_px: 130.5\n")};
  ASSERT_TRUE(found.raw);
  EXPECT_DOUBLE_EQ(found.raw->right.cx_px, 130.5);
  put(folder / "p.json", R"({"fx": 150, "fy": 150, "cx": 127.5, "cy": 79.5, "baseline": 0.25})");
  EXPECT_TRUE(read("d.yaml", "from: p.json\ncx_right_px: 130.5\n").raw);
}

TEST_F(OtherFormats, OneCameraIsEnoughForDepth) {
  const auto expect_single{[&](const char* name, const std::string& text) {
    put(folder / name, text);
    const Calibration found{read_depth_calibration(folder / name, 256, 160)};
    EXPECT_DOUBLE_EQ(found.rig.focal_px, 150) << name;
    EXPECT_DOUBLE_EQ(found.rig.cx_px, 127.5) << name;
    EXPECT_DOUBLE_EQ(found.rig.baseline_m, virtual_baseline_m(150, 256)) << name;
    expect_error([&] { return read_calibration(folder / name, 256, 160); }, {name});
  }};
  expect_single("intrinsic_color.txt", "150 0 127.5 0\n0 150 79.5 0\n0 0 1 0\n0 0 0 1\n");
  expect_single("k.txt", "150 0 127.5\n0 150 79.5\n0 0 1\n");
  expect_single("camera.json", R"({"camera": {"fx": 150, "fy": 150, "cx": 127.5, "cy": 79.5, "scale": 6553.5}})");
  expect_single("calibration.yaml", "focal_px: 150\ncx_px: 127.5\ncy_px: 79.5\n");
  expect_single("tum.yaml", "Camera.fx: 150\nCamera.fy: 150\nCamera.cx: 127.5\nCamera.cy: 79.5\n");
}

TEST_F(OtherFormats, OpenCvInAnyContainerWithTheUsualNames) {
  for (const auto& [matrix, distortion] :
       {std::pair{"K", "D"}, std::pair{"M", "D"}, std::pair{"cameraMatrix", "distCoeffs"}, std::pair{"mtx", "dist"}}) {
    expect_pair(read("a.yml", opencv_dump(matrix, distortion, cv::FileStorage::FORMAT_YAML)),
                "OpenCV stereo calibration");
    expect_pair(read("a.xml", opencv_dump(matrix, distortion, cv::FileStorage::FORMAT_XML)),
                "OpenCV stereo calibration");
    expect_pair(read("a.json", opencv_dump(matrix, distortion, cv::FileStorage::FORMAT_JSON)),
                "OpenCV stereo calibration");
  }
  const std::string k{"[[150, 0, 127.5], [0, 150, 79.5], [0, 0, 1]]"};
  expect_pair(read("b.json", R"({"K_left":)" + k + R"(,"dist_left":[0,0,0,0,0],"K_right":)" + k +
                                 R"(,"dist_right":[[0,0,0,0,0]],"R":[[1,0,0],[0,1,0],[0,0,1]],)"
                                 R"("T":[[-0.25],[0],[0]],"image_size":[256,160]})"),
              "OpenCV stereo calibration");
}

TEST_F(OtherFormats, OpenCvRefusals) {
  refused("a.json", R"({"K1": [[150,0,127],[0,150,79],[0,0,1]], "K2": [[150,0,127],[0,150,79],[0,0,1]],
                        "R": [1,0,0,0,1,0,0,0,1], "T": [-0.25,0,0]})",
          {"a.json", "has no 'D1'"});
  refused("a.json", "{}", {"a.json", "not a calibration that is known"});
  refused("a.xml", "<opencv_storage><K1><rows>3</rows>", {"a.xml", "XML", "missing"});
  refused("a.xml", "<opencv_storage><K1></K2></opencv_storage>", {"a.xml", "'K1' has no end"});
  std::string deep;
  for (int i{0}; i < 40; ++i) deep += "<a>";
  refused("a.xml", deep, {"nested deeper than 16"});
  refused("a.yml", opencv_dump("K", "D", cv::FileStorage::FORMAT_YAML, true), {"one half of a calibration"});
}

constexpr const char* orbslam_camera{
    "%YAML:1.0\nCamera.type: \"PinHole\"\nCamera.fx: 150.0\nCamera.fy: 150.0\nCamera.cx: 127.5\nCamera.cy: 79.5\n"
    "Camera.k1: 0.0\nCamera.k2: 0.0\nCamera.p1: 0.0\nCamera.p2: 0.0\nCamera.width: 256\nCamera.height: 160\n"};

TEST_F(OtherFormats, OrbSlam) {
  const std::string camera{orbslam_camera};
  expect_pair(read("o.yaml", camera + "Camera.bf: 37.5\n"), "ORB-SLAM settings");
  const std::string second{
      "Camera2.fx: 150.0\nCamera2.fy: 150.0\nCamera2.cx: 127.5\nCamera2.cy: 79.5\nStereo.T_c1_c2: !!opencv-matrix\n"
      "  rows: 4\n  cols: 4\n  dt: f\n  data: [1, 0, 0, 0.25, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n"};
  expect_pair(read("p.yaml", camera + second), "ORB-SLAM settings");
  std::string dense{camera + "Camera.bf: 37.5\n"};  // as the settings for EuRoC that come with ORB-SLAM2
  dense.erase(dense.find(".fx: ") + 4, 1);
  expect_pair(read("r.yaml", dense), "ORB-SLAM settings");
  refused("q.yaml", camera, {"q.yaml", "no baseline", "Camera.bf"});
}

TEST_F(OtherFormats, OstOfBothCameras) {
  const auto camera{[](const char* name, const char* tx) {
    return fmt::format(
        "# oST version 5.0 parameters\n\n\n[image]\n\nwidth\n256\n\nheight\n160\n\n[narrow_stereo/{}]\n\n"
        "camera matrix\n150 0 127.5\n0 150 79.5\n0 0 1\n\ndistortion\n0 0 0 0 0\n\nrectification\n"
        "1 0 0\n0 1 0\n0 0 1\n\nprojection\n150 0 127.5 {}\n0 150 79.5 0\n0 0 1 0\n\n",
        name, tx);
  }};
  expect_pair(read("ost.txt", camera("left", "0") + camera("right", "-37.5")), "ROS camera_info");
  expect_pair(read("ost.txt", camera("right", "-37.5") + camera("left", "0")), "ROS camera_info");
  refused("ost.txt", camera("left", "0"), {"ost.txt", "1 cameras, not 2", "no baseline"});
}

TEST_F(OtherFormats, Basalt) {
  const std::string camera{R"({"camera_type":"pinhole","intrinsics":{"fx":150.0,"fy":150.0,"cx":127.5,"cy":79.5}})"};
  const auto file{[&](const std::string& second) {
    return R"({"value0":{"T_imu_cam":[{"px":0,"py":0,"pz":0,"qx":0,"qy":0,"qz":0,"qw":1},)"
           R"({"px":0.25,"py":0,"pz":0,"qx":0,"qy":0,"qz":0,"qw":1}],"intrinsics":[)" +
           camera + "," + second + R"(],"resolution":[[256,160],[256,160]]}})";
  }};
  expect_pair(read("calib.json", file(camera)), "Basalt calibration");
  refused("calib.json", file(R"({"camera_type":"ds","intrinsics":{"fx":1,"fy":1,"cx":1,"cy":1,"xi":0,"alpha":0}})"),
          {"calib.json", "'camera_type' ds", "allowed: pinhole"});
}

std::string depthai_camera(int socket, double x_cm, int to) {
  return fmt::format(R"([{},{{"cameraType":0,"width":256,"height":160,"distortionCoeff":[0,0,0,0,0,0,0,0,0,0,0,0,0,0],)"
                     R"("intrinsicMatrix":[[150,0,127.5],[0,150,79.5],[0,0,1]],"extrinsics":{{"toCameraSocket":{},)"
                     R"("rotationMatrix":[[1,0,0],[0,1,0],[0,0,1]],"translation":{{"x":{},"y":0,"z":0}}}}}}])",
                     socket, to, x_cm);
}

TEST_F(OtherFormats, DepthAiInAnyDirectionOfItsChain) {
  const auto file{[](const std::string& cameras) { return "{\"cameraData\":[" + cameras + "]}"; }};
  expect_pair(read("d.json", file(depthai_camera(1, -25, 2) + "," + depthai_camera(2, 0, -1))), "DepthAI calibration");
  expect_pair(read("d.json", file(depthai_camera(2, 25, 1) + "," + depthai_camera(1, 0, -1))), "DepthAI calibration");
  // both lead to a third one
  expect_pair(read("d.json", file(depthai_camera(1, -12.5, 0) + "," + depthai_camera(2, 12.5, 0) + "," +
                                  depthai_camera(0, 0, -1))),
              "DepthAI calibration");
  refused("d.json", file(depthai_camera(1, -25, -1) + "," + depthai_camera(2, 0, -1)),
          {"no extrinsics that lead from camera 1 to camera 2"});
  refused("d.json", file(depthai_camera(1, -25, 2)), {"no camera of socket 2"});
}

TEST_F(OtherFormats, ZedTakesTheSectionsOfTheImages) {
  const auto camera{[](const char* side, const char* mode, double f, double cx, double cy) {
    return fmt::format("[{}_CAM_{}]\r\nfx={}\r\nfy={}\r\ncx={}\r\ncy={}\r\nk1=0\r\nk2=0\r\n\r\n", side, mode, f, f, cx,
                       cy);
  }};
  std::string text;
  for (const char* const side : {"LEFT", "RIGHT"}) {
    text += camera(side, "HD", 699.2, 640, 360) + camera(side, "VGA", 349.6, 338.4, 186.9);
  }
  text += "[STEREO]\r\nBaseline=120\r\nTY=0\r\nTZ=0\r\nCV_VGA=0\r\nRX_VGA=0\r\nRZ_VGA=0\r\n";
  put(folder / "SN1.conf", text);
  const Rig vga{read_calibration(folder / "SN1.conf", 672, 376).rig};
  EXPECT_DOUBLE_EQ(vga.focal_px, 349.6);
  EXPECT_DOUBLE_EQ(vga.cx_px, 338.4);
  EXPECT_NEAR(vga.baseline_m, 0.12, 1e-12);
  EXPECT_DOUBLE_EQ(read_calibration(folder / "SN1.conf", 1280, 720).rig.focal_px, 699.2);
  EXPECT_DOUBLE_EQ(read_calibration(folder / "SN1.conf", 640, 360).rig.focal_px, 349.6) << "half of 1280×720";
  expect_error([&] { return read_calibration(folder / "SN1.conf", 500, 500); },
               {"SN1.conf", "none for images of 500×500 px"});
  refused("SN2.conf", "[STEREO]\nBaseline\n", {"SN2.conf", "line 2", "key=value"});
}

TEST_F(OtherFormats, MiddleburyHasAnOffset) {
  const Calibration calibration{
      read("calib.txt",
           "cam0=[150 0 127.5; 0 150 79.5; 0 0 1]\ncam1=[150 0 136.5; 0 150 79.5; 0 0 1]\ndoffs=9.0\n"
           "baseline=250\nwidth=256\nheight=160\nndisp=64\n")};
  EXPECT_EQ(calibration.kind, "Middlebury calib.txt");
  EXPECT_DOUBLE_EQ(calibration.rig.focal_px, 150);
  EXPECT_DOUBLE_EQ(calibration.rig.cx_px, 127.5);
  EXPECT_NEAR(calibration.rig.baseline_m, 0.25, 1e-12);
  ASSERT_TRUE(calibration.raw);
  EXPECT_DOUBLE_EQ(calibration.raw->right.cx_px, 136.5);
  refused("calib.txt", "cam0=[150 0 127.5; 0 150 79.5; 0 0 1]\nbaseline=x\n", {"calib.txt", "'baseline'"});
}

TEST_F(OtherFormats, OneCameraHasNoBaseline) {
  refused("cam0.yaml",
          "%YAML:1.0\n---\nmodel_type: PINHOLE\ncamera_name: cam0\nimage_width: 256\nimage_height: 160\n"
          "projection_parameters: {fx: 150, fy: 150, cx: 127.5, cy: 79.5}\n",
          {"cam0.yaml", "one camera", "no baseline"});
}

TEST_F(OtherFormats, EurocOfEitherCameraInEitherOrder) {
  const auto camera{[](double x_m) {
    return fmt::format(
        "sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [1, 0, 0, {}, 0, 1, 0, 0, 0, 0, 1, 0, "
        "0, 0, 0, 1]\nresolution: [256, 160]\ncamera_model: pinhole\nintrinsics: [150, 150, 127.5, "
        "79.5]\ndistortion_model: radial-tangential\ndistortion_coefficients: [0, 0, 0, 0]\n",
        x_m);
  }};
  for (const double second_m : {0.25, -0.25}) {
    put(folder / "cam0" / "sensor.yaml", camera(0));
    put(folder / "cam1" / "sensor.yaml", camera(second_m));
    for (const char* const named : {"cam0", "cam1"}) {
      expect_pair(read_calibration(folder / named / "sensor.yaml", 256, 160), "EuRoC sensor.yaml");
    }
  }
  refused("cam0/sensor.yaml", "T_BS: 1\n", {"sensor.yaml"});
}

TEST_F(OtherFormats, KittiWithAnotherCentreOfTheRightCamera) {
  const Calibration calibration{read("calib.txt",
                                     "P0: 150 0 127.5 0 0 150 79.5 0 0 0 1 0\n"
                                     "P1: 150 0 139.5 -37.5 0 150 79.5 0 0 0 1 0\n")};
  ASSERT_TRUE(calibration.raw);
  EXPECT_DOUBLE_EQ(calibration.rig.focal_px, 150);
  EXPECT_DOUBLE_EQ(calibration.rig.cx_px, 127.5);
  EXPECT_DOUBLE_EQ(calibration.rig.baseline_m, 0.25);
  EXPECT_DOUBLE_EQ(calibration.raw->right.cx_px, 139.5);
}

TEST_F(OtherFormats, FoundationStereoAndCityscapes) {
  expect_pair(read("K.txt", "150 0 127.5 0 150 79.5 0 0 1\n0.25\n"), "OpenCV stereo calibration");
  expect_pair(read("camera.json", R"({"extrinsic": {"baseline": 0.25, "pitch": 0.03, "x": 1.7, "z": 1.2},
    "intrinsic": {"fx": 150, "fy": 150, "u0": 127.5, "v0": 79.5}})"),
              "OpenCV stereo calibration");
  refused("times.txt", "0\n1\n2\n3\n4\n5\n6\n7\n8\n9\n", {"times.txt"});
}

TEST_F(OtherFormats, ProjectionMatricesWithoutNames) {
  expect_pair(read("calib.txt", "150 0 127.5 0 0 150 79.5 0 0 0 1 0\n150 0 127.5 -37.5 0 150 79.5 0 0 0 1 0\n"),
              "OpenCV stereo rectification");
  refused("poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 0.8\n", {"poses.txt"});
}

TEST_F(OtherFormats, OneCameraAndABaseline) {
  const auto expect_camera = [&](const char* name, const std::string& text) {
    refused(name, text, {name, "one camera", "no baseline", "'baseline_m: …' (m)"});
    const Calibration found{read("c.yaml", "from: " + std::string{name} + "\nbaseline_m: 0.25\n")};
    expect_pair(found, "intrinsics of one camera");
    EXPECT_DOUBLE_EQ(found.rig.baseline_m, 0.25);
    EXPECT_TRUE(found.notes.empty());
  };
  expect_camera("K.txt", "150 0 127.5\n0 150 79.5\n0 0 1\n");
  expect_camera("camera.txt", "fx = 150\nfy = 150\ncx = 127.5\ncy = 79.5\n");
  expect_camera("cameras.txt", "# Camera list\n1 PINHOLE 256 160 150 150 128 80\n2 PINHOLE 256 160 150 150 128 80\n");
  expect_camera("opencv.txt", "1 OPENCV 256 160 150 150 128 80 0 0 0 0\n");
  expect_camera("simple.txt", "1 SIMPLE_PINHOLE 256 160 150 128 80\n");
  refused("cameras.txt", "1 OPENCV 256 160 150 150 128 80 0.1 0 0 0\n", {"one raw camera"});
  refused("cameras.txt", "1 OPENCV_FISHEYE 256 160 150 150 128 80 0 0 0 0\n", {"OPENCV_FISHEYE", "image_undistorter"});
  refused("cameras.txt", "1 PINHOLE 256 160 150 150 128 80\n2 PINHOLE 256 160 151 150 128 80\n", {"differ"});
  refused("cameras.txt", "1 PINHOLE 256 160 150 x 128 80\n", {"PINHOLE"});
  put(folder / "raw.json", R"({"fx": 150, "fy": 150, "cx": 127.5, "cy": 79.5, "distortion": [0.1, 0, 0, 0]})");
  refused("c.yaml", "from: raw.json\nbaseline_m: 0.25\n", {"one raw camera, with distortion"});
}

TEST_F(OtherFormats, NumpyArchive) {
  const std::vector<double> k{150, 0, 127.5, 0, 150, 79.5, 0, 0, 1};
  const std::vector<double> none(5);
  const std::vector<double> turn{1, 0, 0, 0, 1, 0, 0, 0, 1};
  const std::vector<double> shift{-0.25, 0, 0};
  const std::vector<std::int64_t> size{256, 160};
  write_npz(folder / "stereo.npz", std::vector<NpzArray>{{"cameraMatrix1", {3, 3}, k},
                                                         {"distCoeffs1", {1, 5}, none},
                                                         {"cameraMatrix2", {3, 3}, k},
                                                         {"distCoeffs2", {1, 5}, none},
                                                         {"R", {3, 3}, turn},
                                                         {"T", {3, 1}, shift},
                                                         {"imageSize", {2}, size}});
  expect_pair(read_calibration(folder / "stereo.npz", 256, 160), "OpenCV stereo calibration");
}

TEST_F(OtherFormats, MatlabIsTransposedAndCountsFromOne) {
  const auto camera{[](const char* matrix) {
    return fmt::format(R"({{"RadialDistortion": [0, 0], "TangentialDistortion": [0, 0], "ImageSize": [160, 256],
      "WorldUnits": "millimeters", "{}"}})",
                       matrix);
  }};
  const auto pair{[&](const char* matrix) {
    std::string text{camera(matrix)};
    text.erase(text.rfind('"'), 1);
    return fmt::format(R"({{"CameraParameters1": {0}, "CameraParameters2": {0},
      "RotationOfCamera2": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "TranslationOfCamera2": [-250, 0, 0]}})",
                       text);
  }};
  expect_pair(read("a.json", pair(R"(IntrinsicMatrix": [[150, 0, 0], [0, 150, 0], [128.5, 80.5, 1]])")),
              "MATLAB stereoParameters");
  expect_pair(read("a.json", pair(R"(K": [[150, 0, 128.5], [0, 150, 80.5], [0, 0, 1]])")), "MATLAB stereoParameters");
}

constexpr const char* kalibr_camera{
    "  camera_model: pinhole\n  distortion_model: none\n  intrinsics: [150, 150, 127.5, 79.5]\n"
    "  resolution: [256, 160]\n"};

TEST_F(OtherFormats, KalibrThroughTheImu) {
  for (const auto& [key, left, right] :
       {std::array{"T_cam_imu", "0.04", "-0.21"}, std::array{"T_imu_cam", "0", "0.25"}}) {
    const auto transform{[key = key](const char* x) {
      return fmt::format("  {}: [[1, 0, 0, {}], [0, 1, 0, 0.2], [0, 0, 1, -0.1], [0, 0, 0, 1]]\n", key, x);
    }};
    expect_pair(
        read("c.yaml", "cam0:\n" + transform(left) + kalibr_camera + "cam1:\n" + transform(right) + kalibr_camera),
        "Kalibr camchain");
  }
}

TEST_F(OtherFormats, VinsNamesItsCameras) {
  put(folder / "cam.yaml",
      "%YAML:1.0\n---\nmodel_type: PINHOLE\nimage_width: 256\nimage_height: 160\n"
      "distortion_parameters: {k1: 0, k2: 0, p1: 0, p2: 0}\nprojection_parameters: {fx: 150, fy: 150, cx: 127.5, cy: "
      "79.5}\n");
  const auto body{[](const char* y) {
    return fmt::format(
        "!!opencv-matrix\n   rows: 4\n   cols: 4\n   dt: d\n"
        "   data: [0, 0, 1, 0.1, -1, 0, 0, {}, 0, -1, 0, 0.2, 0, 0, 0, 1]\n",
        y);
  }};
  expect_pair(
      read("vins.yaml", "%YAML:1.0\n---\nimu: 1\ncam0_calib: \"cam.yaml\"\ncam1_calib: \"cam.yaml\"\nbody_T_cam0: " +
                            body("0.04") + "body_T_cam1: " + body("-0.21")),
      "VINS-Fusion configuration");
}

TEST_F(OtherFormats, DrivingStereoHasCameras101And103) {
  expect_pair(read("calib.txt",
                   "S_rect_101: 256 160\nP_rect_101: 150 0 127.5 0 0 150 79.5 0 0 0 1 0\n"
                   "P_rect_103: 150 0 127.5 -37.5 0 150 79.5 0 0 0 1 0\n"),
              "KITTI raw");
}

TEST_F(OtherFormats, MapsHaveNoFocalLength) {
  refused("maps.xml",
          "<?xml version=\"1.0\"?>\n<opencv_storage><stereoMapL_x type_id=\"opencv-matrix\"><rows>1</rows>"
          "</stereoMapL_x></opencv_storage>",
          {"rectification maps", "Save K, D, R and T"});
}

TEST_F(OtherFormats, LensOfAFileThatNamesNone) {
  const std::string bent{R"({"K1": @, "D1": [0.01, 0.02, 0.001, 0.002], "K2": @, "D2": [0.01, 0.02, 0.001, 0.002],
    "R": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "T": [-0.25, 0, 0], "imageSize": [256, 160]})"};
  const auto with{[&](const std::string& more) {
    std::string text{bent};
    for (std::size_t at{text.find('@')}; at != std::string::npos; at = text.find('@')) text.replace(at, 1, matrix_150);
    return text.insert(1, more);
  }};
  EXPECT_TRUE(read("a.json", with("")).is_lens_unnamed);
  const Calibration named{read("a.json", with(R"("camera_model": "fisheye", )"))};
  EXPECT_FALSE(named.is_lens_unnamed);
  EXPECT_EQ(named.raw->left.lens, LensModel::fisheye);
  put(folder / "a.json", with(""));
  EXPECT_EQ(read("c.yaml", "from: a.json\nlens: fisheye\n").raw->left.lens, LensModel::fisheye);
  EXPECT_EQ(read("c.yaml", "from: a.json\nlens: perspective\n").raw->left.lens, LensModel::perspective);
  refused("c.yaml", "from: a.json\nlens: mirror\n", {"lens"});
}

}  // namespace
}  // namespace stereogrid::io::testing
