// SPDX-License-Identifier: Apache-2.0
// What is wrong with an input: each error_text names the file, what is wrong, and what would mend it.
#include <sys/wait.h>
#include <unistd.h>
#include <array>

#include "stereogrid/io/file.hpp"
#include "stereogrid/io/recording.hpp"
#include "support.hpp"

namespace stereogrid::io::testing {
namespace {

using namespace std::string_literals;
using ::testing::AllOf, ::testing::Contains, ::testing::ElementsAre, ::testing::HasSubstr, ::testing::IsEmpty,
    ::testing::Not;

struct Opening : FolderTest {
  [[nodiscard]] std::unique_ptr<Recording> open() const { return open_recording({{folder.path()}, {}, ""}); }
  void expect_refused(std::initializer_list<std::string_view> parts) const {
    expect_error([&] { return open(); }, parts);
  }
  void cut_in_half(const fs::path& path) const {
    const std::string whole{read_file(path)};
    put(path, whole.substr(0, whole.size() / 2));
  }
};

TEST_F(Opening, NothingThere) {
  expect_no_recording({{folder / "none"}, {}, ""}, {"none", "no such file or folder", "INPUT is", "left/"});
  expect_no_recording({}, {"INPUT"});
  expect_refused({"no stereo recording", "image_0"});
  put(folder / "file.png", "");
  expect_no_recording({{folder / "file.png"}, {}, ""}, {"file.png", "one file", "LEFT RIGHT"});
}

TEST_F(Opening, TheCalibrationHasAnyOfItsNames) {
  put_plain(folder.path());
  const fs::path yaml{folder / "calibration.yaml"};
  for (const char* const name : {"calibration.yml", "calib.yaml", "calib.yml"}) {
    fs::rename(yaml, folder / name);
    EXPECT_EQ(open()->contents().calibration_file, folder / name);
    fs::rename(folder / name, yaml);
  }
}

TEST_F(Opening, RecordingsInsideAreSuggested) {
  put_plain(folder / "drive_7");
  expect_refused({"no stereo recording", "drive_7"});
}

TEST_F(Opening, CamerasAreFoldersOfOneVehicle) {
  put_plain(folder / "front");
  put_plain(folder / "rear");
  put(folder / "calibration.yaml", "cameras: [front, rear]\n");
  const auto recording{open()};
  EXPECT_EQ(recording->rigs().size(), 2U);
  ASSERT_EQ(recording->load(0).others.size(), 1U);
  EXPECT_EQ(recording->load(0).others.front().camera, 1);
  EXPECT_THAT(recording->contents().warnings, IsEmpty());
  fs::remove(folder / "rear" / "right" / "b.png");
  EXPECT_THAT(open()->contents().warnings, Contains(HasSubstr("an image is missing in 1 of")));
  put(folder / "rear" / "calibration.yaml",
      std::string{small_yaml}.substr(0, std::string_view{small_yaml}.find("mount")));
  expect_refused({"rear", "has no mount", "camera_yaw_rad"});
  put(folder / "rear" / "calibration.yaml", "cameras: [back]\n");
  expect_refused({"rear", "lists cameras itself"});
  fs::rename(folder / "rear", folder / "back");
  expect_refused({"rear", "no such file or folder"});
  put(folder / "calibration.yaml", "cameras: [front, ./front/]\n");
  expect_refused({"front twice"});
  put(folder / "calibration.yaml", "cameras: []\n");
  expect_refused({"0 stereo pairs", "1 to 8"});
  put(folder / "calibration.yaml", "cameras: [{camera_name: left}, {camera_name: right}]\n");  // ost.txt as YAML
  expect_refused({"no stereo recording"});
}

TEST_F(Opening, FolderMissingOrEmpty) {
  put_plain(folder.path());
  fs::remove_all(folder / "right");
  expect_refused({"right", "the folder is missing"});
  fs::create_directories(folder / "right");
  expect_refused({"right", "holds no images"});
  fs::remove_all(folder / "left");
  fs::create_directories(folder / "left");
  expect_refused({"left", "holds no images"});
}

/// Opens `root`, a path within `folder`, as another user, since root may read everything. 0: refused with these words.
/// The user need not be able to enter the folders above `folder`, such as a home of mode 700.
int open_as_nobody(const fs::path& folder, const fs::path& root, std::string_view words) {
  const pid_t child{::fork()};
  if (child == 0) {
    if (::chdir(folder.c_str()) != 0 || (::geteuid() == 0 && ::setuid(65534) != 0)) ::_exit(3);
    try {
      static_cast<void>(open_recording({{root}, {}, ""}));
      ::_exit(1);
    } catch (const InputError& error) {
      ::_exit(std::string_view{error.what()}.find(words) != std::string_view::npos ? 0 : 2);
    } catch (...) {
      ::_exit(4);
    }
  }
  int status{0};
  ::waitpid(child, &status, 0);
  return WEXITSTATUS(status);
}

TEST_F(Opening, UnreadableFolder) {
  put_plain(folder / "drive");
  fs::permissions(folder.path(), fs::perms::all);
  fs::permissions(folder / "drive" / "left", fs::perms::none);
  EXPECT_EQ(open_as_nobody(folder.path(), "drive", "left/data: cannot be read (Permission denied)"), 0);
  fs::permissions(folder / "drive" / "left", fs::perms::owner_all);
  fs::permissions(folder / "drive", fs::perms::none);
  EXPECT_EQ(open_as_nobody(folder.path(), "drive", "drive: the folder cannot be read"), 0);
  EXPECT_EQ(open_as_nobody(folder.path(), "drive/left", "cannot be read"), 0);
  fs::permissions(folder / "drive", fs::perms::owner_all);
}

TEST_F(Opening, VideosThatAreNone) {
  const std::string avi{"RIFF\x10\0\0\0AVI LIST"s};
  put(folder / "left.avi", avi);
  put(folder / "the right.bin", avi);
  put(folder / "sbs.mp4", "\0\0\0\x1c"s + "ftypisom");
  put(folder / "c" / "calibration.yaml", small_yaml);
  const auto refused = [&](const std::vector<fs::path>& paths, std::initializer_list<std::string_view> said) {
    expect_error([&] { return open_recording({paths, folder / "c" / "calibration.yaml", ""}); }, said);
  };
  refused({folder / "left.avi", folder / "the right.bin"}, {"left.avi: ", "cannot be decoded", "ffmpeg -i"});
  refused({folder / "sbs.mp4"}, {"sbs.mp4: ", "cannot be decoded"});
  refused({folder.path()}, {"left.avi, ", "sbs.mp4 and 1 more: videos", "LEFT RIGHT"});
  expect_no_recording({{folder / "sbs.mp4"}, {}, ""},
                      {"sbs.mp4: there is no calibration beside the video", "--calibration"});
}

TEST_F(Opening, OfAPairTheImageIsNamed) {
  const fs::path before{fs::current_path()};
  fs::current_path(folder.path());  // names without a folder
  put(folder / "left.png", "no image");
  put(folder / "right.png", "no image");
  const InputArguments pair{{"left.png", "right.png"}, {}, ""};
  expect_no_recording(pair, {"left.png: is not an image"});
  put_plain(folder.path());
  fs::copy(folder / "left" / "a.png", folder / "left.png", fs::copy_options::overwrite_existing);
  fs::copy(folder / "right" / "a.png", folder / "right.png", fs::copy_options::overwrite_existing);
  expect_no_recording(pair, {"left.png: there is no calibration. Name a file with --calibration"});
  fs::current_path(before);
}

TEST_F(Opening, NoPairs) {
  put_plain(folder.path());
  for (const char* const name : {"a", "b", "c"}) {
    fs::rename(folder / "right" / (std::string{name} + ".png"), folder / "right" / (std::string{name} + "_r.png"));
  }
  expect_refused({"no left image has a right one of the same name"});
}

TEST_F(Opening, TwoImagesOfOneName) {
  put_plain(folder.path());
  fs::copy(folder / "left" / "a.png", folder / "left" / "a.jpg");
  expect_refused({"another image of the same name"});
}

TEST_F(Opening, MissingRightImageIsThatFramesError) {
  put_plain(folder.path());
  fs::remove(folder / "right" / "b.png");
  const auto recording{open()};
  ASSERT_EQ(recording->size(), 3U);
  EXPECT_THAT(recording->contents().warnings, ElementsAre(HasSubstr("frame b: the right image is missing")));
  expect_error([&] { return recording->load(1); }, {"b.png", "right image", "missing"});
  EXPECT_EQ(recording->load(2).left(0, 0), 12) << "the other frames work";
}

TEST_F(Opening, MissingLeftImageIsThatFramesError) {
  put_odometry(folder.path());
  fs::remove(folder / "image_0" / "000046.png");
  const auto recording{open()};
  ASSERT_EQ(recording->size(), 3U) << "poses and times still belong to their frames";
  expect_error([&] { return recording->load(0); }, {"000046.png", "left image", "missing"});
  EXPECT_DOUBLE_EQ(recording->load(1).world_from_vehicle->x_m, 8);
}

TEST_F(Opening, ManyMissingImagesAreSummedUp) {
  std::vector<std::string> names;
  for (int i{100}; i < 110; ++i) names.push_back(std::to_string(i));
  put_pairs(folder / "left", folder / "right", names);
  put(folder / "calibration.yaml", small_yaml);
  for (int i{101}; i < 110; ++i) fs::remove(folder / "right" / (std::to_string(i) + ".png"));
  const auto warnings{open()->contents().warnings};
  ASSERT_EQ(warnings.size(), 6U);
  EXPECT_THAT(warnings.back(), HasSubstr("4 more"));
}

TEST_F(Opening, TruncatedImageIsThatFramesError) {
  put_plain(folder.path());
  cut_in_half(folder / "left" / "a.png");
  const auto recording{open()};
  expect_error([&] { return recording->load(0); }, {"a.png", "truncated"});
  EXPECT_EQ(recording->load(1).left(0, 0), 11);
  cut_in_half(folder / "left" / "b.png");
  cut_in_half(folder / "left" / "c.png");
  expect_refused({"none of the left images can be read", "a.png", "truncated"});
}

// Models a network file system that is away for a moment: the frames are not damaged.
TEST_F(Opening, AListedFileThatIsGoneIsADeviceError) {
  put_plain(folder.path());
  put(folder / "velodyne" / "b.bin", std::string(16, 'x'));
  const auto recording{open()};
  for (const char* const file : {"left/b.png", "right/b.png"}) {
    fs::rename(folder / file, folder / "away");
    expect_error<DeviceError>([&] { return recording->load(1); },
                              {file, "no such file", "file system was away, try again"});
    fs::rename(folder / "away", folder / file);
    EXPECT_EQ(recording->load(1).left(0, 0), 11);
  }
  fs::remove(folder / "velodyne" / "b.bin");
  expect_error<DeviceError>([&] { return recording->load_scan(1); }, {"b.bin", "no such file"});
  for (const char* const name : {"a.png", "b.png", "c.png"}) {
    fs::remove(folder / "left" / name);
    fs::create_symlink("nowhere", folder / "left" / name);
  }
  expect_error<DeviceError>([&] { return open(); }, {"left/a.png", "no such file"});
}

TEST_F(Opening, UnequalSizesAreThatFramesError) {
  put_plain(folder.path());
  write_png(folder / "right" / "b.png", Image<std::uint8_t>{64, 33});
  write_png(folder / "left" / "c.png", Image<std::uint8_t>{31, 33});
  write_png(folder / "right" / "c.png", Image<std::uint8_t>{31, 33});
  const auto recording{open()};
  expect_error([&] { return recording->load(1); }, {"left/b.png", "65×33", "right/b.png", "64×33", "same size"});
  expect_error([&] { return recording->load(2); }, {"c.png", "31×33", "calibration is for 65×33"});
}

TEST_F(Opening, Calibration) {
  put_plain(folder.path());
  fs::remove(folder / "calibration.yaml");
  expect_refused({"no calibration", "calibration.yaml", "--calibration"});
  std::string other{small_yaml};
  other.replace(other.find("65"), 2, "66");
  put(folder / "calibration.yaml", other);
  expect_refused({"calibration.yaml", "66×33", "65×33"});
}

TEST_F(Opening, PoseCount) {
  put_odometry(folder.path());
  put(folder / "poses_gt.txt", "1 0 0 0 0 1 0 0 0 0 1 7\n");
  expect_refused({"poses_gt.txt", "1 poses", "3 frames", "--poses none"});
  fs::remove_all(folder.path());
  put_plain(folder.path());
  put(folder / "poses.csv", "name,stamp_ns,x_m,y_m,yaw_rad\na,0,0,0,0\nc,2,0,0,0\n");
  expect_refused({"poses.csv", "2 poses", "3 frames", "frame b has none"});
  put(folder / "poses.csv", "name,stamp_ns,x_m,y_m,yaw_rad\na,0,0,0,0\nb,1,0,0,0\nc,2,0,0,0\nd,3,0,0,0\n");
  EXPECT_THAT(open()->contents().warnings, ElementsAre(HasSubstr("4 poses, but there are 3 frames")));
}

TEST_F(Opening, DistancesToTheCameraAreNoDepths) {
  put_plain(folder.path());
  for (const char* const name : {"distance_to_camera", "DepthPerspective"}) {
    fs::copy(folder / "right", folder / name);
    expect_no_recording({{folder.path()}, {}, "", {}, folder / name},
                        {name, "distances from the camera's centre", "DepthPlanar"});
  }
}

TEST_F(Opening, PosesInMillimetresAreWarnedOf) {
  put_plain(folder.path());
  fs::remove(folder / "poses.csv");
  const std::size_t count{open()->size()};
  const auto warnings = [&](double step) {
    std::string text;
    for (std::size_t i{0}; i < count; ++i)
      text += "1 0 0 0 0 1 0 0 0 0 1 " + std::to_string(step * static_cast<double>(i)) + "\n";
    put(folder / "poses.txt", text);
    return open()->contents().warnings;
  };
  EXPECT_THAT(warnings(1), Not(Contains(HasSubstr("millimetres"))));
  EXPECT_THAT(warnings(1000), Contains(HasSubstr("poses: half of the steps are faster than 10000 m/s")));
}

TEST_F(Opening, PosesWithTimesOfTheirOwn) {
  put_plain(folder.path());
  const std::string log{"stamp_ns,x_m,y_m,yaw_rad\n50000000,0,0,0\n150000000,1,0,0\n250000000,2,4,0\n"};
  put(folder / "poses.csv", log);
  expect_refused({"poses.csv", "the images have no stamps", "times.txt", "column 'name'"});
  put(folder / "times.txt", "0.05\n0.1\n0.2\n");
  const auto recording{open()};
  EXPECT_EQ(recording->load(1).stamp_ns, 100'000'000);
  EXPECT_DOUBLE_EQ(recording->load(0).world_from_vehicle->x_m, 0);
  EXPECT_DOUBLE_EQ(recording->load(1).world_from_vehicle->x_m, 0.5);
  EXPECT_DOUBLE_EQ(recording->load(2).world_from_vehicle->y_m, 2);
  EXPECT_THAT(recording->contents().notes, Contains(HasSubstr("interpolated to the times of the images")));
  put(folder / "times.txt", "0.05\n0.1\n0.36\n");
  const auto beyond{open()};
  EXPECT_FALSE(beyond->load(2).world_from_vehicle);
  EXPECT_THAT(beyond->contents().warnings, Contains(HasSubstr("poses.csv: 1 of 3 images have no pose")));
  put(folder / "times.txt", "0.05\n0.36\n0.46\n");
  expect_refused({"poses.csv", "image of 0.360 s", "0.110 s after the last pose, 0.250 s"});
}

TEST_F(Opening, PosesWithALongGap) {
  put_plain(folder.path());
  put(folder / "times.txt", "0.1\n1.5\n2.9\n");
  const auto put_poses = [&](double period_s, const std::string& rest) {
    std::string log{"stamp_ns,x_m,y_m,yaw_rad\n"};
    for (int i{0}; i < 3; ++i) log += std::to_string(std::llround(i * period_s * 1e9)) + ",0,0,0\n";
    put(folder / "poses.csv", log + rest);
  };
  put_poses(0.1, "2800000000,1,0,0\n2900000000,1,0,0\n");
  const auto recording{open()};
  EXPECT_TRUE(recording->load(0).world_from_vehicle);
  EXPECT_FALSE(recording->load(1).world_from_vehicle);
  EXPECT_TRUE(recording->load(2).world_from_vehicle);
  EXPECT_THAT(recording->contents().warnings,
              ElementsAre(AllOf(HasSubstr("poses.csv: 1 of 3 images have no pose"), HasSubstr("gaps of up to 2.6 s"),
                                HasSubstr("up to 1 s"))));
  put_poses(0.5, "2400000000,1,0,0\n2900000000,1,0,0\n");  // 1.4 s, less than three usual intervals
  EXPECT_TRUE(open()->load(1).world_from_vehicle);
  EXPECT_TRUE(open()->contents().warnings.empty());
}

TEST_F(Opening, PosesThatAreNotFinite) {
  put_odometry(folder.path());
  put(folder / "poses_gt.txt", "1 0 0 0 0 1 0 0 0 0 1 7\n1 0 0 nan 0 1 0 0 0 0 1 7\n1 0 0 0 0 1 0 0 0 0 1 7\n");
  expect_refused({"poses_gt.txt", "line 2", "not finite"});
}

TEST_F(Opening, ACalibrationThatHardlyAnyVehicleHasIsWarnedOf) {
  put_plain(folder.path());
  EXPECT_TRUE(open()->contents().warnings.empty());
  std::string odd{small_yaml};
  odd.replace(odd.find("0.2"), 3, "0.0002");
  odd.replace(odd.find("1.2"), 3, "12");
  put(folder / "calibration.yaml", odd);
  EXPECT_THAT(open()->contents().warnings,
              ElementsAre(AllOf(HasSubstr("calibration.yaml: "), HasSubstr("baseline is 0.0002 m")),
                          HasSubstr("camera height is 12 m")));
}

TEST_F(Opening, FramesThatComeAsNoCamerasDoAreWarnedOf) {
  put_odometry(folder.path());
  for (const char* const usual : {"0\n0.1\n0.2\n", "0\n9\n18\n", "0\n0.0011\n0.0022\n", "0\n0.1\n1e6\n"}) {
    put(folder / "times.txt", usual);
    EXPECT_TRUE(open()->contents().warnings.empty()) << usual;
  }
  put(folder / "times.txt", "0\n3e3\n6e3\n");
  EXPECT_THAT(open()->contents().warnings, ElementsAre(AllOf(HasSubstr("times.txt: "), HasSubstr("0.000333 Hz"))));
  put(folder / "times.txt", "1\n2\n3\n");
  EXPECT_THAT(open()->contents().warnings, ElementsAre(HasSubstr("times.txt: the stamps count the frames")));
  put(folder / "times.txt", "0\n1e-6\n2e-6\n");
  expect_refused({"times.txt", "1e+06 Hz", "no other unit"});
  for (const auto& [times, unit] :
       {std::array{"0\n33\n66\n", "milliseconds"}, std::array{"0\n1e5\n2e5\n", "microseconds"},
        std::array{"1700000000000000000\n1700000000100000000\n1700000000200000000\n", "nanoseconds"}}) {
    put(folder / "times.txt", times);
    EXPECT_THAT(open()->contents().warnings, IsEmpty());
    EXPECT_THAT(open()->contents().notes, Contains(HasSubstr(std::string{"stamps: taken as "} + unit)));
  }
  put(folder / "times.txt", "0\n1e-9\n2e-9\n");
  EXPECT_THAT(open()->contents().warnings, IsEmpty());
  EXPECT_THAT(open()->contents().notes, Contains(HasSubstr("as if frames had been counted")));
}

TEST_F(Opening, Stamps) {
  put_odometry(folder.path());
  put(folder / "times.txt", "0\n0.1\n");
  expect_refused({"times.txt", "2 times", "3 frames"});
  put(folder / "times.txt", "0\n0.2\n0.1\n");
  expect_refused({"times.txt", "line 3", "not later"});
  put(folder / "times.txt", "0\nnan\n0.1\n");
  expect_refused({"times.txt", "line 2", "not a number"});
  fs::remove_all(folder.path());
  put_plain(folder.path());
  put(folder / "poses.csv", "name,stamp_ns,x_m,y_m,yaw_rad\nb,0,0,0,0\na,1,0,0,0\nc,2,0,0,0\n");
  expect_refused({"poses.csv", "frame b is not later than frame a"});
}

TEST_F(Opening, RawTimestamps) {
  put_pairs(folder / "image_00" / "data", folder / "image_01" / "data", {"0", "1"});
  put(folder / "calibration.yaml", small_yaml);
  put(folder / "image_00" / "timestamps.txt", "2011-09-26 13:02:25.9\n2011-13-26 13:02:25.9\n");
  expect_refused({"timestamps.txt", "line 2", "not a time stamp"});
  put(folder / "image_00" / "timestamps.txt", "2011-09-26 13:02:25.9\n2011-09-26 13:02:25.8\n");
  expect_refused({"timestamps.txt", "line 2", "not later"});
}

TEST_F(Opening, NamedPosesThatAreNotThere) {
  put_plain(folder.path());
  expect_no_recording({{folder.path()}, {}, "nowhere.csv"}, {"nowhere.csv", "no such file"});
}

}  // namespace
}  // namespace stereogrid::io::testing
