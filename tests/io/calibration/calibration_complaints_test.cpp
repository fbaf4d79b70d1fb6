// SPDX-License-Identifier: Apache-2.0
// What is wrong with the calibrations of other tools: each error_text names the file, what is wrong, and what would
// mend it.
#include "calibration/calibration_writers.hpp"
#include "support.hpp"

namespace stereogrid::io::testing {
namespace {

using Parts = std::initializer_list<std::string_view>;

/// With the first `from` exchanged.
std::string changed(std::string text, const std::string& from, const std::string& to) {
  const std::size_t place{text.find(from)};
  EXPECT_NE(place, std::string::npos) << from;
  return place == std::string::npos ? text : text.replace(place, from.size(), to);
}

/// Text without the line of the key and the indented lines below it.
std::string without(const std::string& text, const std::string& key) {
  const std::size_t start{text.find(key + ":")};
  EXPECT_NE(start, std::string::npos) << key;
  const std::size_t line{text.rfind('\n', start) + 1};
  std::size_t end{text.find('\n', start) + 1};
  const std::size_t indent{start - line};
  while (end < text.size() && (text.substr(end, indent + 2) == std::string(indent + 2, ' ') ||
                               text.substr(end, indent + 2) == std::string(indent, ' ') + "- ")) {
    end = text.find('\n', end) + 1;
  }
  return text.substr(0, line) + text.substr(end);
}

struct ForeignCalibration : FolderTest {
  /// `named`: the file that is opened; `changed`: the one that is wrong.
  void refused(Files files, const char* named, const char* wrong, const std::string& text, Parts parts) const {
    files[wrong] = text;
    put_files(folder.path(), files);
    expect_error([&] { return read_calibration(folder / named, 321, 239); }, parts);
    expect_error([&] { return read_calibration(folder / named, 321, 239); }, {wrong});
  }
  void ros_refused(const char* wrong, const std::string& from, const std::string& to, Parts parts) const {
    refused(ros_, "left.yaml", wrong, changed(ros_.at(wrong), from, to), parts);
  }
  void opencv_refused(const char* wrong, const std::string& from, const std::string& to, Parts parts) const {
    refused(opencv_, "extrinsics.yml", wrong, changed(opencv_.at(wrong), from, to), parts);
  }
  void kalibr_refused(const std::string& from, const std::string& to, Parts parts) const {
    refused(kalibr_, "camchain.yaml", "camchain.yaml", changed(kalibr_.at("camchain.yaml"), from, to), parts);
  }
  const Rig rig_{321, 239, 256, 160, 120, 0.25};
  const CameraPair rectified_{rectified_pair(rig_)};
  const Files ros_{ros_files(rectified_)};
  const Files opencv_{opencv_files(rectified_)};
  const Files kalibr_{kalibr_files(raw_pair({-0.2, 0.05, 0, 0}, {-0.2, 0.05, 0, 0}))};
};

TEST_F(ForeignCalibration, KeysThatAreMissing) {
  for (const char* const key : {"image_width", "image_height", "camera_matrix", "distortion_coefficients",
                                "rectification_matrix", "projection_matrix"}) {
    for (const char* const file : {"left.yaml", "right.yaml"}) {
      refused(ros_, "left.yaml", file, without(ros_.at(file), key), {"has no '", key});
    }
  }
  for (const char* const key : {"M1", "D1", "M2", "D2"}) {
    refused(opencv_, "extrinsics.yml", "intrinsics.yml", without(opencv_.at("intrinsics.yml"), key), {"has no '", key});
  }
  for (const char* const key : {"R", "T"}) {
    refused(opencv_, "extrinsics.yml", "extrinsics.yml", without(opencv_.at("extrinsics.yml"), key), {"has no '", key});
  }
  const std::string chain{kalibr_.at("camchain.yaml")};
  for (const char* const key : {"camera_model", "distortion_coeffs", "distortion_model", "intrinsics", "resolution"}) {
    refused(kalibr_, "camchain.yaml", "camchain.yaml", without(chain, key), {"has no 'cam0.", key});
  }
  for (const char* const key : {"cam0", "cam1", "T_cn_cnm1"}) {
    refused(kalibr_, "camchain.yaml", "camchain.yaml", without(chain, key), {"has no '", key});
  }
}

TEST_F(ForeignCalibration, NumbersThatAreNone) {
  for (const char* const number : {".nan", ".inf", "1e300", "abc", "{}"}) {
    const std::string what{"is not a number"};
    ros_refused("left.yaml", "data: [256", std::string{"data: ["} + number, {"camera_matrix.data", what});
    ros_refused("right.yaml", "image_width: 321", std::string{"image_width: "} + number, {"image_width", "not a "});
    kalibr_refused("intrinsics: [250", std::string{"intrinsics: ["} + number, {"intrinsics"});
    opencv_refused("intrinsics.yml", "data: [ 256.", std::string{"data: [ "} + number, {"M1.data"});
  }
  ros_refused("left.yaml", "image_width: 321", "image_width: 0", {"not a size in pixels"});
  ros_refused("left.yaml", "image_width: 321", "image_width: 320.5", {"not a size in pixels"});
  kalibr_refused("[321, 239]", "[321, 0]", {"'resolution' that is none"});
  kalibr_refused("[321, 239]", "[321]", {"1 numbers, not 2"});
  ros_refused("left.yaml", "rows: 3", "rows: 2", {"'camera_matrix' has 9 numbers, but 2 rows of 3"});
  ros_refused("left.yaml", "camera_matrix:\n  rows: 3\n  cols: 3", "camera_matrix:\n  rows: 9\n  cols: 1",
              {"matrix of 9 rows of 1, not of 3 of 3"});
  ros_refused("left.yaml", "camera_matrix:\n", "camera_matrix: 3\nother:\n",
              {"'camera_matrix' is not a group of keys"});
  opencv_refused("extrinsics.yml", "T: !!opencv-matrix\n   rows: 3", "T: !!opencv-matrix\n   rows: 2", {"'T'"});
  refused(opencv_, "extrinsics.yml", "intrinsics.yml", "%YAML:1.0\n---\nM1: [\n", {"not YAML"});
}

TEST_F(ForeignCalibration, RosCamerasThatAreNotCalibrated) {
  ros_refused("right.yaml", "data: [256", "data: [0", {"not calibrated", "'camera_matrix' is 0", "cameracalibrator"});
  ros_refused("right.yaml", "projection_matrix:\n  rows: 3\n  cols: 4\n  data: [256",
              "projection_matrix:\n  rows: 3\n  cols: 4\n  data: [0", {"not calibrated", "'projection_matrix' is 0"});
  ros_refused("left.yaml", "data: [256, 0", "data: [256, 3", {"'camera_matrix' is not a camera matrix", "fx 0 cx"});
  ros_refused("left.yaml", "256, 120, 0, 0, 0, 1, 0]", "256, 120, 0, 0, 0, 2, 0]", {"none of a rectified pair"});
  ros_refused("left.yaml", "rectification_matrix:\n  rows: 3\n  cols: 3\n  data: [1",
              "rectification_matrix:\n  rows: 3\n  cols: 3\n  data: [2", {"'rectification_matrix'", "not a rotation"});
}

TEST_F(ForeignCalibration, RosPairsThatAreNone) {
  ros_refused("right.yaml", "image_width: 321", "image_width: 640", {"640×239", "left.yaml for 321×239"});
  ros_refused("right.yaml", "-64", "0", {"baseline is zero", "cameracalibrator", "'baseline_m'"});
  ros_refused("right.yaml", "-64", "64", {"negative", "swapped", "correct the sign"});
  ros_refused("right.yaml", "256, 120, 0, 0, 0, 1, 0]", "256, 124, 0, 0, 0, 1, 0]",
              {"rows differ", "cy 124", "256 and 120", "one by one"});
  ros_refused("right.yaml", "256, 120, 0, 0, 0, 1, 0]", "256, 120, -64, 0, 0, 1, 0]", {"one camera above the other"});
  const Files exchanged{{"left.yaml", ros_.at("right.yaml")}, {"right.yaml", ros_.at("left.yaml")}};
  refused(exchanged, "left.yaml", "left.yaml", exchanged.at("left.yaml"),
          {"is the right camera's", "the names of the two files"});
}

TEST_F(ForeignCalibration, RosMessagesAreNoFiles) {
  put(folder / "left.yaml", "header: {frame_id: left}\nheight: 239\nwidth: 321\nD: [0]\nK: [1]\nR: [1]\nP: [1]\n");
  expect_error([&] { return read_calibration(folder / "left.yaml"); },
               {"left.yaml", "CameraInfo message", "camera_calibration has written"});
}

TEST_F(ForeignCalibration, RosDistortionThatIsNone) {
  ros_refused("left.yaml", "plumb_bob", "thin_prism", {"none of plumb_bob", "images: rectified"});
  ros_refused("left.yaml", "cols: 5\n  data: [0, 0, 0, 0, 0]", "cols: 0\n  data: []",
              {"no numbers in 'distortion_coefficients'", "cannot be rectified", "images: rectified"});
  ros_refused("left.yaml", "plumb_bob", "equidistant", {"5 distortion numbers, as equidistant does not"});
  ros_refused("left.yaml", "plumb_bob", "rational_polynomial", {"5 distortion numbers"});
  const CameraPair fisheye{raw_pair({0.1, 0, 0, 0}, {0.1, 0, 0, 0}, LensModel::fisheye)};
  const Files files{ros_files(fisheye)};
  refused(files, "left.yaml", "left.yaml", changed(files.at("left.yaml"), "equidistant", "plumb_bob"),
          {"One camera has a fisheye lens"});
}

TEST_F(ForeignCalibration, WithoutItsOtherHalf) {
  put(folder / "left.yaml", ros_.at("left.yaml"));
  put(folder / "calib_a.yaml", ros_.at("left.yaml"));
  put(folder / "extrinsics.yml", opencv_.at("extrinsics.yml"));
  const auto read{[&](const char* name) { return [this, name] { return read_calibration(folder / name); }; }};
  expect_error(read("left.yaml"), {"left.yaml", "one half", "right.yaml is not there"});
  expect_error(read("extrinsics.yml"), {"extrinsics.yml", "one half", "intrinsics.yml is not there"});
  expect_error(read("calib_a.yaml"), {"name does not say which is the other", "from: [left, right]"});
}

TEST_F(ForeignCalibration, OpenCvPairsThatAreNone) {
  opencv_refused("extrinsics.yml", "-2.5000000000000000e-01", "2.5e-01", {"negative", "swapped", "inverse"});
  opencv_refused("extrinsics.yml", "-2.5000000000000000e-01", "0.", {"baseline is zero"});
  opencv_refused("extrinsics.yml", "-2.5000000000000000e-01", "-2.5e-4", {"0.00025 m apart", "baseline_m"});
  opencv_refused("extrinsics.yml", "-2.5000000000000000e-01, 0.", "-0.1, 0.3", {"side by side"});
  opencv_refused("extrinsics.yml", "R: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 1.",
                 "R: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 3.",
                 {"'R'", "not a rotation matrix"});
  opencv_refused("intrinsics.yml", "data: [ 256.", "data: [ -256.", {"not positive"});
  const Files raw{opencv_files(raw_pair({-0.2, 0.05, 0, 0}, {-0.2, 0.05, 0, 0}))};
  put_files(folder.path(), raw);
  expect_error([&] { return read_calibration(folder / "extrinsics.yml", 160, 120); },
               {"left camera's principal point (161, 118)", "outside images of 160×120", "scaled by 0.5"});
  expect_error([&] { return read_calibration(folder / "extrinsics.yml"); }, {"'image' size"});
}

TEST_F(ForeignCalibration, KalibrChainsThatAreNone) {
  kalibr_refused("camera_model: pinhole", "camera_model: omni", {"(cam0)", "other than pinhole", "pinhole-radtan"});
  kalibr_refused("distortion_model: radtan", "distortion_model: fov", {"none of radtan", "pinhole-equi"});
  kalibr_refused("[321, 239]", "[640, 480]", {"(cam1)", "another 'resolution' than cam0"});
  kalibr_refused("[0.0, 0.0, 0.0, 1.0]", "[0.0, 0.0, 0.1, 1.0]", {"no rigid transform", "last column"});
}

TEST_F(ForeignCalibration, KalibrTransformsTheWrongWayRound) {
  const CameraPair pair{rectified_pair(rig_)};
  const std::string chain{kalibr_files(pair).at("camchain.yaml")};
  const auto chain_refused{
      [&](const std::string& text, Parts parts) { refused(kalibr_, "camchain.yaml", "camchain.yaml", text, parts); }};
  chain_refused(changed(chain, "-0.25", "0.25"),
                {"T_cn_cnm1", "cam1 left of cam0", "topics say otherwise", "looks like the inverse", "invert it"});
  const std::string pose{"[[1, 0, 0, X], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]"};
  const auto imu{[&](const char* x) { return "  T_cam_imu: " + changed(pose, "X", x) + "\n"; }};
  std::string inertial{changed(chain, "cam0:\n", "cam0:\n" + imu("0.3"))};
  inertial = changed(inertial, "cam1:\n", "cam1:\n" + imu("0.05"));
  put(folder / "good.yaml", inertial);
  EXPECT_EQ(read_calibration(folder / "good.yaml").rig.baseline_m, 0.25);
  chain_refused(changed(inertial, "-0.25", "0.25"), {"inverse of what the transforms to the IMU say", "invert it"});
  chain_refused(changed(chain, "[0, 0, 1, 0]\n  - [0.0, 0.0, 0.0, 1.0]", "[0, 0, 1, 0]\n  - [-0.25, 0, 0, 1]"),
                {"no rigid transform"});
  std::string transposed{changed(chain, "-0.25]", "0]")};
  chain_refused(changed(transposed, "[0.0, 0.0, 0.0, 1.0]", "[-0.25, 0.0, 0.0, 1.0]"),
                {"'T_cn_cnm1' that is transposed"});
}

TEST_F(ForeignCalibration, OfImagesOfAnotherSize) {
  for (const Files& files : {ros_, kalibr_}) {
    put_files(folder.path(), files);
    const fs::path file{folder / (files.size() == 2 ? "left.yaml" : "camchain.yaml")};
    expect_error([&] { return read_calibration(file, 642, 480); }, {"321×239", "642×480"});
  }
}

TEST_F(ForeignCalibration, NamedByAnotherWithoutSense) {
  put_files(folder.path(), ros_);
  put_files(folder.path(), opencv_);
  put(folder / "own.yaml", "focal_px: 1\n");
  put(folder / "calib.txt", "P0: 60 0 160 0 0 60 120 0 0 0 1 0\nP1: 60 0 160 -30 0 60 120 0 0 0 1 0\n");
  const auto named{[&](const std::string& text, Parts parts) {
    put(folder / "c.yaml", text);
    expect_error([&] { return read_calibration(folder / "c.yaml", 321, 239); }, parts);
  }};
  named("from: own.yaml\n", {"own.yaml", "another one names"});
  named("from: none.yaml\n", {"none.yaml", "no such file"});
  named("from: []\n", {"neither one file nor two"});
  named("from: {a: b}\n", {"not a file's name"});
  named("from: left.yaml\nfocal_px: 3\n", {"unknown key 'focal_px'"});
  named("from: left.yaml\nimages: bent\n", {"neither raw nor rectified"});
  named("from: left.yaml\nbaseline_m: -1\n", {"not positive"});
  named("from: extrinsics.yml\nimages: raw\n", {"leaves no choice", "OpenCV"});
  named("from: calib.txt\nbaseline_m: 0.3\n", {"KITTI", "metres"});
  put(folder / "c.yaml", "from: calib.txt\nmount: {camera_height_m: 1.2}\n");
  EXPECT_EQ(read_calibration(folder / "c.yaml", 321, 239).rig.camera_height_m, 1.2);
}

}  // namespace
}  // namespace stereogrid::io::testing
