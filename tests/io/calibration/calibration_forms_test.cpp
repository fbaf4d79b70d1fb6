// SPDX-License-Identifier: Apache-2.0
// The same cameras, written as each tool writes them, are the same cameras.
#include <algorithm>
#include <cstdlib>

#include "calibration/calibration_writers.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/io/rectifier.hpp"
#include "stereogrid/pipeline.hpp"
#include "stereogrid/scenes/scene.hpp"
#include "support.hpp"

namespace stereogrid::io::testing {
namespace {

using ::testing::Contains, ::testing::HasSubstr, ::testing::IsEmpty;

const std::vector<double> radtan_left{-0.2, 0.05, 0.001, -0.0005};
const std::vector<double> radtan_right{-0.18, 0.04, 0, 0.0008};

/// Every form of a pair whose cameras have at most four numbers of distortion.
std::map<std::string, Files> forms_of(const CameraPair& pair) {
  std::map<std::string, Files> forms{
      {"ROS", ros_files(pair)}, {"Kalibr", kalibr_files(pair)}, {"ours, raw", own_files(pair)}};
  if (pair.cameras.left.lens == LensModel::perspective) forms["OpenCV"] = opencv_files(pair);
  return forms;
}

const char* main_file_of(const Files& files) {
  for (const char* const name : {"left.yaml", "extrinsics.yml", "camchain.yaml", "calibration.yaml", "calib.txt"}) {
    if (files.contains(name)) return name;
  }
  return "none";
}

struct CalibrationForms : FolderTest {
  [[nodiscard]] Calibration read(const Files& files, int width_px, int height_px) const {
    put_files(folder.path(), files);
    return read_calibration(folder / main_file_of(files), width_px, height_px);
  }
};

/// As written in all five forms.
std::map<std::string, Files> rectified_forms(const Rig& rig) {
  auto forms{forms_of(rectified_pair(rig))};
  const std::string p{"256 0 128 "};
  const std::string q{" 0 256 64 0 0 0 1 0\n"};
  EXPECT_EQ(rig.focal_px, 256);
  forms["KITTI"] = {{"calib.txt", "P0: " + p + "0" + q + "P1: " + p + "-64" + q}};
  forms["ours"] = {{"calibration.yaml", "focal_px: 256\ncx_px: 128\ncy_px: 64\nbaseline_m: 0.25\n"}};
  return forms;
}

TEST_F(CalibrationForms, ARectifiedRigIsTheSame) {
  const Rig rig{256, 128, 256, 128, 64, 0.25};
  for (const auto& [form, files] : rectified_forms(rig)) {
    const Calibration calibration{read(files, 256, 128)};
    EXPECT_EQ(calibration.rig, rig) << form;
    EXPECT_FALSE(calibration.raw) << form;
    EXPECT_FALSE(calibration.has_extrinsics) << form;
  }
}

TEST_F(CalibrationForms, ADriveGivesTheSameGrids) {
  const scenes::Scene scene{
      scenes::parse_scene("street?frames=3&width=256&height=128&focal=256&baseline=0.25&camera_height=1.65")};
  for (std::size_t i{0}; i < scene.size(); ++i) {
    const StereoFrame frame{scene.load(i)};
    for (const char* const side : {"left", "right"}) fs::create_directories(folder / side);
    write_png(folder / "left" / (frame.name + ".png"), frame.left);
    write_png(folder / "right" / (frame.name + ".png"), frame.right);
  }
  std::optional<FrameResult> first;
  for (const auto& [form, files] : rectified_forms(scene.rig())) {
    const fs::path drive{folder / form};
    put_files(drive, files);
    for (const char* const side : {"left", "right"}) fs::create_directory_symlink(folder / side, drive / side);
    const auto recording{open_recording({{drive}, {}, "none"})};
    EXPECT_EQ(recording->rig(), scene.rig()) << form;
    Pipeline pipeline{preset("default"), recording->rig(), {.stages = false}};
    for (std::size_t i{0}; i + 1 < recording->size(); ++i) static_cast<void>(pipeline.process(recording->load(i)));
    const FrameResult& result{pipeline.process(recording->load(recording->size() - 1))};
    if (!first) {
      first = result;
      const auto& occupancy{result.vehicle.occupancy};
      EXPECT_GT(std::count_if(occupancy.begin(), occupancy.end(), [](float p) { return p > 0.8F; }), 10) << form;
    }
    EXPECT_EQ(result.vehicle.occupancy, first->vehicle.occupancy) << form;
  }
}

/// Pixels that differ by more than `most`.
std::size_t count_different(const Image<std::uint8_t>& a, const Image<std::uint8_t>& b, int most) {
  std::size_t count{0};
  for (std::size_t i{0}; i < a.size(); ++i) count += std::abs(a.data()[i] - b.data()[i]) > most ? 1 : 0;
  return count;
}

void expect_same_maps(const Calibration& a, const Calibration& b, const std::string& form) {
  ASSERT_TRUE(a.raw && b.raw) << form;
  EXPECT_NEAR(a.rig.focal_px, b.rig.focal_px, 1e-6) << form;
  EXPECT_NEAR(a.rig.cx_px, b.rig.cx_px, 1e-6) << form;
  EXPECT_NEAR(a.rig.cy_px, b.rig.cy_px, 1e-6) << form;
  EXPECT_NEAR(a.rig.baseline_m, b.rig.baseline_m, 1e-9) << form;
  const StereoFrame frame{textured_pair(a.rig.width_px, a.rig.height_px, 7)};
  const Rectifier first{*a.raw, a.rig.width_px, a.rig.height_px};
  const Rectifier second{*b.raw, a.rig.width_px, a.rig.height_px};
  // maps are to 1/32 px: where numbers differ in the last digit, a pixel in thousands is rounded the other way
  EXPECT_LE(count_different(first.left(frame.left), second.left(frame.left), 0), frame.left.size() / 1000) << form;
  EXPECT_LE(count_different(first.right(frame.right), second.right(frame.right), 0), frame.left.size() / 1000) << form;
  EXPECT_GT(count_different(first.left(frame.left), frame.left, 0), frame.left.size() / 2) << form;
}

TEST_F(CalibrationForms, ARawPairIsRectifiedInTheSameWay) {
  const std::vector<double> rational{-0.2, 0.05, 0.001, -0.0005, 0.01, 0.02, -0.01, 0.003};
  const std::vector<CameraPair> pairs{
      raw_pair(radtan_left, radtan_right),
      raw_pair({0.02, -0.01, 0.003, -0.001}, {0.018, -0.012, 0.004, 0}, LensModel::fisheye)};
  for (const CameraPair& pair : pairs) {
    const Calibration ours{read(own_files(pair), 321, 239)};
    for (const auto& [form, files] : forms_of(pair)) expect_same_maps(read(files, 321, 239), ours, form);
  }
  const CameraPair pair{raw_pair(rational, rational)};
  expect_same_maps(read(ros_files(pair), 321, 239), read(own_files(pair), 321, 239), "ROS, 8 numbers");
  expect_same_maps(read(opencv_files(pair), 321, 239), read(own_files(pair), 321, 239), "OpenCV, 8 numbers");
}

TEST_F(CalibrationForms, EitherFileOfAPairMayBeNamed) {
  const CameraPair pair{raw_pair(radtan_left, radtan_right)};
  put_files(folder.path(), ros_files(pair));
  put_files(folder.path(), opencv_files(pair));
  EXPECT_EQ(read_calibration(folder / "left.yaml").rig, read_calibration(folder / "right.yaml").rig);
  EXPECT_EQ(read_calibration(folder / "intrinsics.yml", 321, 239).rig,
            read_calibration(folder / "extrinsics.yml", 321, 239).rig);
}

TEST_F(CalibrationForms, OneFileMayHoldAllOfOpenCvs) {
  Files files{opencv_files(raw_pair(radtan_left, radtan_right))};
  const Calibration two{read(files, 321, 239)};
  const std::string rest{files["extrinsics.yml"].substr(files["extrinsics.yml"].find("R:"))};
  put(folder / "stereo.yml", files["intrinsics.yml"] + rest);
  EXPECT_EQ(read_calibration(folder / "stereo.yml", 321, 239).rig, two.rig);
}

TEST_F(CalibrationForms, KalibrsLeftCameraIsFoundByTheTransform) {
  const CameraPair pair{raw_pair(radtan_left, radtan_right)};
  Files files{kalibr_files(pair)};
  const Calibration usual{read(files, 0, 0)};
  EXPECT_THAT(usual.notes, Contains(HasSubstr("cam0 is the left one")));
  const auto& r{pair.cameras.right_from_left_rotation};
  const auto& t{pair.cameras.right_from_left_translation_m};
  CameraPair exchanged{pair};  // cam0 is the right camera, T takes its points to the left one
  std::swap(exchanged.cameras.left, exchanged.cameras.right);
  for (std::size_t i{0}; i < 3; ++i) {
    exchanged.cameras.right_from_left_translation_m[i] = -(r[i] * t[0] + r[3 + i] * t[1] + r[6 + i] * t[2]);
    for (std::size_t j{0}; j < 3; ++j) exchanged.cameras.right_from_left_rotation[3 * i + j] = r[3 * j + i];
  }
  std::string text{kalibr_files(exchanged)["camchain.yaml"]};
  text.replace(text.find("/left/"), 6, "/right/");
  text.replace(text.rfind("/right/"), 7, "/left/");
  const Calibration other{read({{"camchain.yaml", text}}, 0, 0)};
  EXPECT_THAT(other.notes, Contains(HasSubstr("cam1 is the left one")));
  expect_same_maps(other, usual, "Kalibr");
}

TEST_F(CalibrationForms, AreFoundInAPlainFolder) {
  const Rig rig{64, 32, 60, 32, 16, 0.25};
  const CameraPair pair{rectified_pair(rig)};
  const Files ros{ros_files(pair)};
  const std::vector<Files> places{
      ros,
      {{"camera_left.yml", ros.at("left.yaml")}, {"camera_right.yml", ros.at("right.yaml")}},
      {{"camera_info/left.yaml", ros.at("left.yaml")}, {"camera_info/right.yaml", ros.at("right.yaml")}},
      {{"left/camera_info.yaml", ros.at("left.yaml")}, {"right/camera_info.yaml", ros.at("right.yaml")}},
      opencv_files(pair),
      {{"camchain-drive.yaml", kalibr_files(pair)["camchain.yaml"]}}};
  for (const Files& files : places) {
    const TemporaryFolder drive;
    for (const char* const side : {"left", "right"}) {
      fs::create_directories(drive / side);
      write_png(drive / side / "0.png", Image<std::uint8_t>{64, 32, 7});
    }
    put_files(drive.path(), files);
    EXPECT_EQ(open_recording({{drive.path()}, {}, "none"})->rig(), rig) << files.begin()->first;
    put_files(drive.path(), {{"extrinsics-2.yml", ""}});
    expect_no_recording({{drive.path()}, {}, "none"}, {"several calibrations", "--calibration"});
  }
}

TEST_F(CalibrationForms, CalibrationYamlNamesAnother) {
  const CameraPair pair{raw_pair(radtan_left, radtan_right)};
  put_files(folder.path(), ros_files(pair));
  const Calibration raw{read_calibration(folder / "left.yaml")};
  ASSERT_TRUE(raw.raw);
  EXPECT_THAT(raw.notes, Contains(HasSubstr("images: rectified")));
  put_files(folder.path(), ros_files(rectified_pair({64, 32, 60, 32, 16, 0.25})));
  EXPECT_THAT(read_calibration(folder / "left.yaml").notes, IsEmpty()) << "raw or rectified, it is the same";
  put_files(folder.path(), ros_files(pair));
  put(folder / "c.yaml", "from: left.yaml\nimages: raw\nmount: {camera_height_m: 1.2}\nmask: m.png\n");
  const Calibration named{read_calibration(folder / "c.yaml")};
  EXPECT_EQ(named.rig.focal_px, raw.rig.focal_px);
  EXPECT_EQ(named.rig.camera_height_m, 1.2);
  EXPECT_TRUE(named.raw && named.has_extrinsics && named.notes.empty());
  EXPECT_EQ(named.mask, folder / "m.png");
  put(folder / "c.yaml", "from: [left.yaml, right.yaml]\nimages: rectified\n");
  const Calibration rectified{read_calibration(folder / "c.yaml")};
  EXPECT_FALSE(rectified.raw);
  EXPECT_NE(rectified.rig.focal_px, raw.rig.focal_px);
  EXPECT_NEAR(rectified.rig.baseline_m, raw.rig.baseline_m, 1e-9);
}

TEST_F(CalibrationForms, AMeasuredBaselineMendsTheUnit) {
  CameraPair pair{raw_pair(radtan_left, radtan_right)};
  const double true_m{read(own_files(pair), 0, 0).rig.baseline_m};
  for (double& number : pair.cameras.right_from_left_translation_m) number *= 1000;
  for (const Files& files : {ros_files(pair), opencv_files(pair), kalibr_files(pair)}) {
    const std::string name{main_file_of(files)};
    expect_error([&] { return read(files, 321, 239); },
                 {"300 m apart", "millimetres (0.3 m) or squares", "from: FILE", "baseline_m: 0.3"});
    put(folder / "c.yaml", "from: " + name + "\nbaseline_m: " + std::to_string(true_m) + "\n");
    EXPECT_NEAR(read_calibration(folder / "c.yaml", 321, 239).rig.baseline_m, true_m, 1e-6) << name;
  }
}

}  // namespace
}  // namespace stereogrid::io::testing
