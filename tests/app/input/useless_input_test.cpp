// SPDX-License-Identifier: Apache-2.0
//
// Inputs that nothing can come of, and what `info` and `run` say about them.

#include "stereogrid/io/image_file.hpp"
#include "stereogrid/io/npz.hpp"
#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

using OddSize = FolderTest;
using UselessInput = FolderTest;

using ::testing::AnyOf;
using Grey = Image<std::uint8_t>;

/// A simulated drive on the disk with a pitched camera.
fs::path drive(const TemporaryFolder& folder, int frames, const std::string& more = "") {
  run_well({"simulate", "scene:street?width=320&height=200&frames=" + std::to_string(frames) + more, "--no-truth",
            "--out", folder / "drive"});
  return folder / "drive";
}

/// Puts other images in the place of each pair.
void replace_pairs(const fs::path& drive, const std::function<void(Grey& left, Grey& right)>& replace,
                   std::size_t from = 0) {
  const std::vector<std::string> names{files_in(drive / "left")};
  for (std::size_t i{from}; i < names.size(); ++i) {
    Grey left{io::read_grey(drive / "left" / names[i])};
    Grey right{io::read_grey(drive / "right" / names[i])};
    replace(left, right);
    io::write_png(drive / "left" / names[i], left);
    io::write_png(drive / "right" / names[i], right);
  }
}

Grey turned(const Grey& image) {
  Grey result{image};
  std::reverse(result.begin(), result.end());
  return result;
}

void set_pitch(const fs::path& drive, const std::string& rad) {
  edit(drive / "calibration.yaml", "camera_pitch_rad: [-0-9.]+", "camera_pitch_rad: " + rad);
}

void expect_useless(const fs::path& drive, const std::string& said) {
  const Outcome info{run_tool({"info", drive})};
  EXPECT_EQ(info.exit_code, 65) << info.output;
  EXPECT_THAT(info.output, AllOf(HasSubstr(said), HasSubstr("cannot be used"), Not(HasSubstr("fine"))));
}

TEST_F(UselessInput, InfoSaysWhatIsWrong) {
  struct Case {
    std::function<void(Grey&, Grey&)> replace;
    std::string said;
  };
  const auto black = [](Grey& left, Grey& right) {
    left.fill(0);
    right.fill(0);
  };
  const auto upside_down = [](Grey& left, Grey& right) { left = turned(std::exchange(right, turned(left))); };
  const auto rows_off = [](Grey&, Grey& right) {
    std::rotate(right.begin(), right.begin() + 12 * right.width(), right.end());
  };
  // turned twice, the images are as they were
  const fs::path input{drive(folder, 2)};
  replace_pairs(input, upside_down);
  expect_useless(input, "upside down");
  replace_pairs(input, upside_down);
  for (const Case& wrong :
       std::vector<Case>{{rows_off, "vertical misalignment: the right image lies about 12 rows too high"},
                         {[](Grey&left, Grey&right) { right = left; }, "the same image"},
                         {black, "black or without texture"}}) {
    SCOPED_TRACE(wrong.said);
    replace_pairs(input, wrong.replace);
    expect_useless(input, wrong.said);
  }
}

TEST_F(UselessInput, AWrongSignOfThePitchIsNotAnImageUpsideDown) {
  const fs::path input{drive(folder, 1, "&pitch_deg=15")};
  set_pitch(input, "-0.262");
  expect_useless(input, "pitch 15.");
  EXPECT_THAT(run_tool({"info", input}).output, Not(HasSubstr("upside down")));
}

TEST_F(UselessInput, InfoNoticesImagesTurnedByAQuarter) {
  const fs::path input{drive(folder, 1)};
  std::ofstream{input / "calibration.yaml"} << "focal_px: 256.25\ncx_px: 100\ncy_px: 160\nbaseline_m: 0.22\n";
  const auto turn = [](Grey& left, Grey& right) {
    for (Grey* const image : {&left, &right}) {
      Grey result{image->height(), image->width()};
      for (int v{0}; v < image->height(); ++v) {
        for (int u{0}; u < image->width(); ++u) result(v, image->width() - 1 - u) = (*image)(u, v);
      }
      *image = result;
    }
  };
  replace_pairs(input, turn);
  expect_useless(input, "turned by 90°: they match when both are turned clockwise");
  for (int i{0}; i < 2; ++i) replace_pairs(input, turn);
  expect_useless(input, "turned by 90°: they match when both are turned counterclockwise");
}

TEST_F(UselessInput, InfoTakesNoWrongRotationOfARawPairForTurnedImages) {
  const fs::path input{drive(folder, 2)};
  const std::string camera{": {focal_u_px: 256.25, focal_v_px: 256.25, cx_px: 160, cy_px: 100}\n"};
  std::ofstream{input / "calibration.yaml"}
      << "left" << camera << "right" << camera
      << "right_from_left: {rotation: [0, 0, 0.05], translation_m: [-0.22, 0, 0]}\n";
  replace_pairs(input, [](Grey&, Grey& right) {
    const Grey usual{right};
    for (int v{0}; v < right.height(); ++v) {
      for (int u{0}; u < right.width(); ++u) right(u, v) = usual(u, std::clamp(v - 20 + (u - 160) / 20, 0, 199));
    }
  });
  EXPECT_THAT(run_tool({"info", input}).output, AllOf(HasSubstr("hardly match"), Not(HasSubstr("turned by 90°"))));
}

/// One of ROS's files; the right camera is turned by 3°, so that rectification moves rows.
std::string ros_file(bool is_left) {
  const std::string camera{"256.25, 0, 160"};
  const std::string turn{is_left ? "1, 0, 0, 0, 1, 0, 0, 0, 1"
                                 : "1, 0, 0, 0, 0.99863, -0.052336, 0, 0.052336, 0.99863"};
  return "image_width: 320\nimage_height: 200\ncamera_matrix: {rows: 3, cols: 3, data: [" + camera +
         ", 0, 256.25, 100, 0, 0, 1]}\ndistortion_model: plumb_bob\n" +
         "distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}\n" +
         "rectification_matrix: {rows: 3, cols: 3, data: [" + turn + "]}\n" +
         "projection_matrix: {rows: 3, cols: 4, data: [" + camera + (is_left ? ", 0" : ", -56.375") +
         ", 0, 256.25, 100, 0, 0, 0, 1, 0]}\n";
}

TEST_F(UselessInput, InfoNoticesImagesThatWouldBeRectifiedTwice) {
  const fs::path input{drive(folder, 2)};
  std::ofstream{input / "left.yaml"} << ros_file(true);
  std::ofstream{input / "right.yaml"} << ros_file(false);
  fs::remove(input / "calibration.yaml");
  expect_useless(input, "these are rectified already");
  expect_useless(input, "'images: rectified'");
  std::ofstream{input / "calibration.yaml"} << "from: left.yaml\nimages: rectified\nmount: {camera_height_m: 1.25}\n";
  EXPECT_THAT(run_well({"info", input}).output, AllOf(HasSubstr("found in 2 of 2 frames"), HasSubstr("fine")));
}

TEST_F(UselessInput, InfoNoticesSidesThatAreSwappedLater) {
  const fs::path input{drive(folder, 4)};
  replace_pairs(
      input, [](Grey& left, Grey& right) { std::swap(left, right); }, 1);
  expect_useless(input, "swapped");
}

TEST_F(UselessInput, InfoNoticesThatTheRightImagesAreLate) {
  const fs::path input{drive(folder, 5)};
  for (const char* name : {"000004.png", "000003.png", "000002.png", "000001.png"}) {
    fs::copy_file(input / "right" / (std::string{"00000"} + std::to_string(name[5] - '1') + ".png"),
                  input / "right" / name, fs::copy_options::overwrite_existing);
  }
  const Outcome info{run_tool({"info", input})};
  EXPECT_THAT(info.output, AllOf(HasSubstr("the right images are a frame late"), Not(HasSubstr("fine"))));
}

TEST_F(UselessInput, InfoNoticesThatTheLeftImagesAreTwoFramesLate) {
  const fs::path input{drive(folder, 5)};
  for (const char* name : {"000004.png", "000003.png", "000002.png"}) {
    fs::copy_file(input / "left" / (std::string{"00000"} + std::to_string(name[5] - '2') + ".png"),
                  input / "left" / name, fs::copy_options::overwrite_existing);
  }
  for (const char* side : {"left", "right"}) {
    for (const char* name : {"000000.png", "000001.png"}) fs::remove(input / side / name);
  }
  fs::remove(input / "poses.csv");
  expect_useless(input, "the left images are 2 frames late");
}

TEST_F(UselessInput, InfoNoticesACameraThatHasStopped) {
  const fs::path input{drive(folder, 4)};
  for (const char* name : {"000001.png", "000002.png", "000003.png"}) {
    fs::copy_file(input / "right" / "000000.png", input / "right" / name, fs::copy_options::overwrite_existing);
  }
  EXPECT_THAT(run_tool({"info", input}).output, HasSubstr("the right image of 000002 is the same as that of 000001"));
  fs::copy_file(input / "left" / "000002.png", input / "left" / "000003.png", fs::copy_options::overwrite_existing);
  EXPECT_THAT(run_tool({"info", input}).output,
              HasSubstr("the images are those of the frame before in 1 of 4 frames (first: 000003)"));
}

TEST_F(UselessInput, InfoNoticesAnotherFocalLengthOfTheRightCamera) {
  const fs::path input{drive(folder, 2)};
  replace_pairs(input, [](Grey&, Grey& right) {
    constexpr double zoom{1.06};
    const Grey usual{right};
    for (int v{0}; v < right.height(); ++v) {
      for (int u{0}; u < right.width(); ++u) {
        right(u, v) = usual(static_cast<int>(std::lround(160 + (u - 160) / zoom)),
                            static_cast<int>(std::lround(100 + (v - 100) / zoom)));
      }
    }
  });
  EXPECT_THAT(run_tool({"info", input}).output,
              AllOf(HasSubstr("vertical misalignment: matched corners"), Not(HasSubstr("cx_right_px"))));
}

TEST_F(UselessInput, InfoNoticesOneMirroredImage) {
  const fs::path input{drive(folder, 2)};
  replace_pairs(input, [](Grey& left, Grey&) {
    for (int v{0}; v < left.height(); ++v) std::reverse(left.row(v), left.row(v) + left.width());
  });
  expect_useless(input, "the left image is mirrored");
}

TEST_F(UselessInput, InfoNoticesInvertedPoses) {
  const fs::path input{drive(folder, 3)};
  std::ofstream{input / "poses.csv"} << "name,stamp_ns,x_m,y_m,yaw_rad\n000000,0,0,0,0\n000001,100000000,-0.8,0,0\n"
                                        "000002,200000000,-1.6,0,0\n";
  EXPECT_THAT(run_well({"info", input}).output,
              AllOf(HasSubstr("the poses seem to be inverted"), HasSubstr("usable"), Not(HasSubstr("fine"))));
  for (const Words& words : {Words{"run", input, "--out", folder / "run"}, Words{"live", input, "--listen", ":0"}}) {
    EXPECT_THAT(run_well(words).errors, HasSubstr("the poses seem to be inverted")) << words.front();
  }
}

TEST_F(UselessInput, InfoNoticesHeadingsInDegrees) {
  const fs::path input{drive(folder, 3)};
  std::ofstream{input / "poses.csv"}
      << "name,stamp_ns,x_m,y_m,yaw_rad\n000000,0,0,0,60\n000001,100000000,0.4,0.693,60\n"
         "000002,200000000,0.8,1.386,60\n";
  EXPECT_THAT(run_well({"info", input}).output, HasSubstr("the headings of the poses seem to be in degrees"));
}

TEST_F(UselessInput, InfoNoticesABaselineThatPutsTheCameraTooLow) {
  const fs::path input{drive(folder, 3)};
  std::ofstream{input / "calibration.yaml"} << "focal_px: 256.25\ncx_px: 160\ncy_px: 100\nbaseline_m: 0.022\n";
  fs::remove(input / "poses.csv");
  EXPECT_THAT(run_well({"info", input}).output,
              AllOf(HasSubstr("the estimated height of the camera is 0.1"), HasSubstr("is the baseline 0.022 m")));
}

TEST_F(UselessInput, InfoNoticesABaselineTenTimesTooLong) {
  const fs::path input{drive(folder, 3)};
  std::ofstream{input / "calibration.yaml"} << "focal_px: 256.25\ncx_px: 160\ncy_px: 100\nbaseline_m: 2.2\n";
  fs::remove(input / "poses.csv");
  EXPECT_THAT(run_tool({"info", input}).output,
              AnyOf(HasSubstr("is the baseline 2.2 m"), HasSubstr("The baseline of 2.2 m is unusual")));
}

// Level ground below a wall, in disparities, depths and inverse depths of both folders.
TEST_F(UselessInput, InfoNoticesReciprocals) {
  const fs::path input{drive(folder, 2)};
  fs::remove_all(input / "right");
  std::ofstream{input / "calibration.yaml"} << "focal_px: 256.25\ncx_px: 160\ncy_px: 100\nbaseline_m: 0.22\n";
  const auto info_with = [&](const char* kind, const std::function<double(double depth_m)>& value_of) {
    for (const char* other : {"depth", "disparity"}) fs::remove_all(input / other);
    fs::create_directories(input / kind);
    std::vector<float> values;
    for (int i{0}; i < 320 * 200; ++i) {
      const double below{(i / 320 - 100) / 256.25};
      values.push_back(static_cast<float>(value_of(below > 0.05 ? 1.25 / below : 25)));
    }
    for (const char* name : {"000000.npz", "000001.npz"}) {
      io::write_npz(input / kind / name, std::vector<io::NpzArray>{{"values", {200, 320}, values}});
    }
    return run_tool({"info", input}).output;
  };
  const auto disparity = [](double z) { return 256.25 * 0.22 / z; };
  EXPECT_THAT(info_with("depth", disparity), HasSubstr("They seem to be disparities in px"));
  EXPECT_THAT(run_tool({"live", input, "--listen", ":0"}).errors, HasSubstr("They seem to be disparities in px"));
  EXPECT_THAT(info_with("depth", [](double z) { return 1 / z; }), HasSubstr("They seem to be inverse depths in 1/m"));
  EXPECT_THAT(info_with("disparity", [](double z) { return z; }), HasSubstr("They seem to be depths in m"));
  EXPECT_THAT(info_with("disparity", disparity), Not(HasSubstr("seem")));
}

// Level ground and a wall, whose depths are distances from the camera's centre or not.
TEST_F(UselessInput, InfoNoticesDistancesInPlaceOfDepths) {
  const fs::path input{drive(folder, 2)};
  fs::remove_all(input / "right");
  fs::create_directories(input / "depth");
  constexpr double focal_px{256.25};
  const auto put_depths = [&](bool are_distances) {
    Image<std::uint16_t> depth{320, 200};
    for (int v{0}; v < 200; ++v) {
      for (int u{0}; u < 320; ++u) {
        const double below{(v - 100) / focal_px};
        const double z{below > 0.05 ? 1.25 / below : 25};
        const double factor{are_distances ? std::hypot(u - 160, v - 100, focal_px) / focal_px : 1};
        depth(u, v) = static_cast<std::uint16_t>(1000 * z * factor);
      }
    }
    for (const char* name : {"000000.png", "000001.png"}) io::write_png(input / "depth" / name, depth);
    return run_tool({"info", input}).output;
  };
  constexpr const char* found{"the depths seem to be distances from the camera's centre"};
  EXPECT_THAT(put_depths(true), HasSubstr(found));
  EXPECT_THAT(put_depths(false), Not(HasSubstr(found)));
}

TEST_F(UselessInput, ARoadThatIsNotFoundIsSaid) {
  const fs::path input{drive(folder, 3, "&pitch_deg=8")};
  set_pitch(input, "0");
  expect_useless(input, "found in 0 of 3 frames");
  expect_useless(input, "extrinsics_disagree: a plane in view does not fit the extrinsics, which are kept");
  const Outcome run{run_well({"run", input, "--out", folder / "run", "--set", "grid.length_m=10"})};
  EXPECT_THAT(run.errors, AllOf(HasSubstr("in 3 of 3 frames the ground plane is unknown"),
                                HasSubstr("pitch 0.0°, roll 0.0° in use"),
                                AnyOf(HasSubstr("pitch 7.9°"), HasSubstr("pitch 8.")), Not(HasSubstr("mount: {"))));
  EXPECT_EQ(json_of(folder / "run" / "run.json")["status"], (Json{{"extrinsics_disagree", 3}, {"road_unknown", 3}}));
  for (const Json& line : lines_of(folder / "run")) {
    EXPECT_EQ(line["status"], Json::array({"road_unknown", "extrinsics_disagree"}));
  }
}

TEST_F(UselessInput, EachStatusOfAFrameHasItsOwnWarning) {
  const Outcome run{run_well(
      {"run", "scene:terrain?kind=edge&depth=0.9&at=1.0&frames=22", "--out", folder / "run", "--device", "cpu"})};
  EXPECT_THAT(run.errors, AllOf(HasSubstr("extrinsics_disagree: a plane in view does not fit"),
                                HasSubstr("too_close: an obstacle is too close")));
}

TEST_F(UselessInput, ExtrinsicsThatWereFoundAreProposed) {
  const fs::path input{drive(folder, 3, "&pitch_deg=8")};
  edit(input / "calibration.yaml", "mount:.*", "");
  EXPECT_THAT(run_well({"info", input}).output,
              AllOf(HasSubstr("mount: {camera_height_m: 1.2"), HasSubstr("found in 3 of 3 frames"), HasSubstr("fine")));
}

TEST_F(UselessInput, RunSaysInHowManyFramesThereAreFewMatches) {
  const fs::path input{drive(folder, 3)};
  replace_pairs(
      input, [](Grey& left, Grey& right) { std::swap(left, right); }, 1);
  const Words words{"run", input, "--out", folder / "run", "--set", "grid.length_m=10"};
  EXPECT_THAT(run_well(words).errors, HasSubstr("in 2 of 3 frames left and right image hardly match"));
  const Json status(json_of(folder / "run" / "run.json")["status"]);
  EXPECT_EQ(status, (Json{{"few_matches", 2}}));
  run_well(joined(words, {"--resume"}));
  EXPECT_EQ(json_of(folder / "run" / "run.json")["status"], status);
}

/// The words of `run` with a small grid.
std::vector<std::string> small_run(const fs::path& drive, const fs::path& out) {
  return {"run", drive, "--out", out, "--set", "grid.length_m=10"};
}

void multiply(Grey& image, double gain) {
  for (std::uint8_t& grey : image) grey = static_cast<std::uint8_t>(std::min(std::lround(gain * grey), 255L));
}

TEST_F(UselessInput, OneImageMayBeBrighterAndThatIsSaid) {
  const fs::path input{drive(folder, 3)};
  replace_pairs(input, [](Grey&, Grey& right) { multiply(right, 2); });
  const auto named{
      ::testing::ContainsRegex("the right image is (1.9|2.0|2.1) × brighter than the left and [0-9]+ % of "
                               "it is saturated: set both cameras to the same exposure")};
  EXPECT_THAT(run_well({"info", input}).output, AllOf(named, HasSubstr("usable")));
  EXPECT_THAT(run_well(small_run(input, folder / "run")).errors, AllOf(named, HasSubstr("in 3 of 3 frames (first: ")));
  EXPECT_EQ(json_of(folder / "run" / "run.json")["status"], Json::object());
  EXPECT_THAT(run_well({"live", input, "--listen", ":0"}).errors, named);
}

TEST_F(UselessInput, RunSaysTheReasonThatInfoSays) {
  const fs::path input{drive(folder, 3)};
  replace_pairs(
      input, [](Grey&, Grey& right) { std::rotate(right.begin(), right.begin() + 12 * right.width(), right.end()); },
      1);
  const std::string fault{"vertical misalignment: the right image lies about 12 rows too high"};
  const std::string count{"in 2 of 3 frames left and right image hardly match"};
  EXPECT_THAT(run_well({"info", input}).output, AllOf(HasSubstr(fault), HasSubstr(count)));
  EXPECT_THAT(
      run_well(small_run(input, folder / "run")).errors,
      AllOf(HasSubstr(fault), HasSubstr(count), HasSubstr("most grids are unknown: those of 2 of 3 frames (67 %)")));
}

TEST_F(UselessInput, AGoodDriveIsFineAndItsRoadIsFound) {
  const Outcome info{run_well({"info", drive(folder, 3, "&pitch_deg=8").string()})};
  EXPECT_THAT(info.output, AllOf(HasSubstr("found in 3 of 3 frames"), HasSubstr("fine")));
  EXPECT_THAT(info.output, ::testing::ContainsRegex("pitch (7.9|8.0|8.1)"));
}

// The first pair is of another size than all the others.
TEST_F(OddSize, OfTheFirstPairDoesNotDecide) {
  const fs::path input{drive(folder, 4)};
  const Grey small{160, 100, 90};
  io::write_png(input / "left" / "000000.png", small);
  io::write_png(input / "right" / "000000.png", small);
  const Outcome info{run_well({"info", input})};
  EXPECT_THAT(info.output, AllOf(HasSubstr("320 × 200 px"), HasSubstr("frame 000000"), HasSubstr("160×100 px"),
                                 HasSubstr("3 can be used"), HasSubstr("usable")));
}

/// Takes the size out of calibration.yaml.
void remove_size(const fs::path& drive) {
  edit(drive / "calibration.yaml", "image: [^\n]*\n", "");
}

Grey halved(const Grey& image) {
  Grey half{image.width() / 2, image.height() / 2};
  for (const auto [u, v] : raster(half)) {
    half(u, v) = static_cast<std::uint8_t>(
        (image(2 * u, 2 * v) + image(2 * u + 1, 2 * v) + image(2 * u, 2 * v + 1) + image(2 * u + 1, 2 * v + 1)) / 4);
  }
  return half;
}

TEST_F(OddSize, OfTheWholeDriveIsRefusedOrScaled) {
  const fs::path input{drive(folder, 3)};
  replace_pairs(input, [](Grey& left, Grey& right) {
    left = halved(left);
    right = halved(right);
  });
  const Words run{"run", input, "--out", folder / "run", "--set", "grid.length_m=10"};
  const Outcome scaled{run_well({"info", input})};
  EXPECT_THAT(scaled.output, AllOf(HasSubstr("320×200"), HasSubstr("scaled by 0.5"), HasSubstr("fine")));
  EXPECT_THAT(run_well(run).errors, HasSubstr("scaled by 0.5"));
  EXPECT_EQ(json_of(folder / "run" / "run.json")["rig"]["width_px"], 160);
  remove_size(input);
  for (const Words& words : {{"info", input}, run}) {
    EXPECT_THAT(errors_of(65, words), AllOf(HasSubstr("principal point"), HasSubstr("about 321×201 px")));
  }
}

TEST_F(OddSize, OfImagesThatWereCroppedIsWarnedOf) {
  const fs::path input{drive(folder, 2)};
  replace_pairs(input, [](Grey& left, Grey& right) {
    for (Grey* image : {&left, &right}) {
      Grey cropped{image->width() - 80, image->height()};
      for (int v{0}; v < cropped.height(); ++v) std::copy_n(image->row(v) + 80, cropped.width(), cropped.row(v));
      *image = cropped;
    }
  });
  remove_size(input);
  const Outcome info{run_tool({"info", input})};
  EXPECT_THAT(info.output, AllOf(HasSubstr("cropped"), HasSubstr("67 % of the width"), Not(HasSubstr("fine"))));
  EXPECT_THAT(run_tool({"run", input, "--out", folder / "run", "--set", "grid.length_m=10"}).errors,
              AllOf(HasSubstr("warning"), HasSubstr("cropped")));
}

}  // namespace
}  // namespace stereogrid::app::testing
