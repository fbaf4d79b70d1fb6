// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/recording.hpp"

#include <opencv2/imgcodecs.hpp>

#include "stereogrid/io/file.hpp"
#include "stereogrid/io/frame_queue.hpp"
#include "support.hpp"

namespace stereogrid::io::testing {
namespace {

using ::testing::Contains, ::testing::HasSubstr;

struct RecordingTest : FolderTest {
  [[nodiscard]] std::unique_ptr<Recording> open(const std::string& poses = "") const {
    return open_recording({{folder.path()}, {}, poses});
  }
};

TEST_F(RecordingTest, KittiOdometryMayStartAnywhere) {
  put_odometry(folder.path());
  put(folder / "velodyne" / "000047.bin", "");
  const auto recording{open()};
  EXPECT_EQ(recording->contents().kind, "KITTI odometry sequence");
  ASSERT_EQ(recording->size(), 3U);
  EXPECT_EQ(recording->name(0), "000046");
  EXPECT_EQ(recording->rig(), (Rig{65, 33, 60, 32, 16, 0.5, 1.65, 0, 0}));
  EXPECT_TRUE(recording->has_poses());
  EXPECT_TRUE(recording->has_scans());
  EXPECT_TRUE(recording->contents().frames[0].scan.empty());
  EXPECT_FALSE(recording->has_truth());
  const StereoFrame frame{recording->load(1)};
  EXPECT_EQ(frame.name, "000047");
  EXPECT_EQ(frame.index, 1);
  EXPECT_EQ(frame.stamp_ns, 104'128'400);
  EXPECT_EQ(frame.left(64, 32), 11);
  EXPECT_EQ(frame.right(0, 0), 111);
  ASSERT_TRUE(frame.world_from_vehicle);
  EXPECT_DOUBLE_EQ(frame.world_from_vehicle->x_m, 8);
  EXPECT_TRUE(recording->contents().warnings.empty());
  EXPECT_THAT(recording->contents().notes, Contains(HasSubstr("extrinsics: not in the calibration")));
  EXPECT_THAT(recording->contents().notes, Contains(HasSubstr("poses_gt.txt")));
}

/// Folders front and rear of three frames each.
void put_cameras(const fs::path& root) {
  put_plain(root / "front");
  put_plain(root / "rear");
  put(root / "rear" / "calibration.yaml",
      "image: {width_px: 65, height_px: 33}\nfocal_px: 60\ncx_px: 32\ncy_px: 16\nbaseline_m: 0.2\n"
      "mount: {camera_height_m: 1.2, camera_x_m: -1, camera_yaw_rad: 3}\n");
  put(root / "calibration.yaml", "cameras: [front, rear]\n");
}

TEST_F(RecordingTest, CamerasOfOneVehicle) {
  put_cameras(folder.path());
  const auto recording{open()};
  ASSERT_EQ(recording->rigs().size(), 2U);
  EXPECT_EQ(recording->rigs()[1].camera_yaw_rad, 3);
  EXPECT_EQ(recording->camera_names(), (std::vector<std::string>{"front", "rear"}));
  const StereoFrame frame{recording->load(1)};
  ASSERT_EQ(frame.others.size(), 1U);
  EXPECT_EQ(frame.others[0].camera, 1);
  EXPECT_EQ(frame.others[0].stamp_ns, frame.stamp_ns);
  EXPECT_EQ(frame.others[0].left(0, 0), 11);
}

TEST_F(RecordingTest, CamerasHaveNamesOfTopics) {
  for (const char* const name : {"2", "a-b", "a_b"}) put_plain(folder / name);
  put(folder / "calibration.yaml", "cameras: [\"2\", a-b, a_b]\n");
  EXPECT_EQ(open()->camera_names(), (std::vector<std::string>{"camera2", "a_b", "a_b_2"}));
}

TEST_F(RecordingTest, CamerasHaveMasksOfTheirOwn) {
  put_cameras(folder.path());
  cv::Mat1b mask(33, 65, std::uint8_t{255});
  mask.rowRange(20, 33) = 0;
  cv::imwrite((folder / "rear" / "own.png").string(), mask);
  std::string calibration{read_text(folder / "rear" / "calibration.yaml", 1000)};
  put(folder / "rear" / "calibration.yaml", calibration + "mask: own.png\n");
  const auto recording{open()};
  EXPECT_TRUE(recording->contents().mask.empty());
  const Image<std::uint8_t>& of_rear{recording->other_cameras().front()->contents().mask};
  EXPECT_EQ(of_rear(3, 19), 255);
  EXPECT_EQ(of_rear(3, 20), 0);
}

TEST_F(RecordingTest, ACameraMayMissImages) {
  put_cameras(folder.path());
  fs::remove(folder / "front" / "left" / "b.png");
  fs::remove(folder / "rear" / "right" / "c.png");
  const auto recording{open()};
  const StereoFrame frame{recording->load(1)};
  EXPECT_TRUE(frame.left.empty());
  EXPECT_EQ(frame.name, "b");
  EXPECT_EQ(frame.index, 1);
  EXPECT_EQ(frame.stamp_ns, 100'000'005);
  EXPECT_EQ(frame.world_from_vehicle->x_m, 1);
  ASSERT_EQ(frame.others.size(), 1U);
  EXPECT_EQ(frame.others[0].left(0, 0), 11);
  EXPECT_TRUE(recording->load(2).others.empty());
  EXPECT_THAT(recording->load(2).fault, HasSubstr("rear: no usable images; it observes nothing ("));
  FrameQueue queue{*recording, 0, 3};
  EXPECT_FALSE(queue.next()->warning);
  EXPECT_THAT(queue.next()->warning.value(), HasSubstr("front: no usable images"));
  fs::remove(folder / "rear" / "right" / "b.png");
  expect_error([&] { return open()->load(1); }, {"left", "b.png", "missing"});
}

// A frame of the slower camera is used once.
TEST_F(RecordingTest, CamerasMayHaveDifferentRates) {
  put_cameras(folder.path());
  fs::remove(folder / "rear" / "left" / "b.png");
  fs::remove(folder / "rear" / "right" / "b.png");
  put(folder / "rear" / "poses.csv", "name,stamp_ns,x_m,y_m,yaw_rad\na,5,0,0,0\nc,200000005,2,0,0.1\n");
  const auto recording{open()};
  for (const std::size_t index : {0U, 1U, 2U}) EXPECT_EQ(recording->load(index).others.size(), index == 1 ? 0U : 1U);
}

// Half an interval late, where each frame is as near to the next one of the first camera.
TEST_F(RecordingTest, CamerasMayTakeTurns) {
  put_cameras(folder.path());
  put(folder / "rear" / "poses.csv",
      "name,stamp_ns,x_m,y_m,yaw_rad\na,50000005,0,0,0\nb,150000005,1,0,0\nc,250000005,2,0,0.1\n");
  const auto recording{open()};
  for (const std::size_t index : {0U, 1U, 2U}) {
    const StereoFrame frame{recording->load(index)};
    ASSERT_EQ(frame.others.size(), 1U) << index;
    EXPECT_EQ(frame.others[0].stamp_ns - frame.stamp_ns, 50'000'000);
  }
}

TEST_F(RecordingTest, FramesFileSaysWhichFramesTheLinesBelongTo) {
  put_odometry(folder.path());
  put_pairs(folder / "image_0", folder / "image_1", {"000001"});  // a frame that is not listed
  put(folder / "frames.txt", "000046\n000047\n000048\n");
  EXPECT_EQ(open()->size(), 3U);
  put(folder / "frames.txt", "000046\n000046\n");
  expect_error([&] { return open(); }, {"frames.txt", "twice"});
}

TEST_F(RecordingTest, OtherPosesCanBeNamedOrLeftOut) {
  put_odometry(folder.path());
  put(folder / "poses_vo.txt", "1 0 0 0 0 1 0 0 0 0 1 1\n1 0 0 0 0 1 0 0 0 0 1 2\n1 0 0 0 0 1 0 0 0 0 1 3\n");
  EXPECT_THAT(open()->contents().notes, Contains(HasSubstr("not taken: poses_vo.txt")));
  EXPECT_DOUBLE_EQ(open((folder / "poses_vo.txt").string())->load(0).world_from_vehicle->x_m, 1);
  const auto without{open("none")};
  EXPECT_FALSE(without->has_poses());
  EXPECT_FALSE(without->load(0).world_from_vehicle);
  EXPECT_EQ(without->load(2).stamp_ns, 200'000'000);
}

TEST_F(RecordingTest, PosesOfTheUnpackedBenchmark) {
  put_odometry(folder / "sequences" / "04");
  fs::remove(folder / "sequences" / "04" / "poses_gt.txt");
  put(folder / "poses" / "04.txt", "1 0 0 0 0 1 0 0 0 0 1 3\n1 0 0 0 0 1 0 0 0 0 1 4\n1 0 0 0 0 1 0 0 0 0 1 5\n");
  for (const fs::path& root : {folder / "sequences" / "04", folder / "sequences" / "04" / ""}) {
    EXPECT_DOUBLE_EQ(open_recording({{root}, {}, ""})->load(0).world_from_vehicle->x_m, 3);
  }
}

TEST_F(RecordingTest, ColourPairOfKitti) {
  put_pairs(folder / "image_2", folder / "image_3", {"0"});
  put(folder / "calib.txt", small_calib);
  const auto recording{open()};
  EXPECT_DOUBLE_EQ(recording->rig().baseline_m, 0.45);
  EXPECT_EQ(recording->load(0).right(0, 0), 110);
}

TEST_F(RecordingTest, StampsAreTenHertzWhereThereAreNone) {
  put_odometry(folder.path());
  fs::remove(folder / "times.txt");
  const auto recording{open()};
  EXPECT_EQ(recording->load(2).stamp_ns, 200'000'000);
  EXPECT_THAT(recording->contents().notes, Contains(HasSubstr("10 frames a second assumed")));
}

TEST_F(RecordingTest, KittiRawDrive) {
  const fs::path drive{folder / "2011_09_26" / "2011_09_26_drive_0001_sync"};
  put_pairs(drive / "image_00" / "data", drive / "image_01" / "data", {"0000000000", "0000000002"});
  put(drive / "image_00" / "timestamps.txt",
      "2011-09-26 13:02:25.964389445\n2011-09-26 13:02:26.064389445\n2011-09-26 13:02:26.5\n");
  put(drive / "velodyne_points" / "data" / "0000000002.bin", "");
  for (const char* const name : {"0000000000", "0000000002"}) {
    put(drive / "oxts" / "data" / (std::string{name} + ".txt"), "49 8.4 110 0 0 0.5 1 2 3\n");
  }
  put(folder / "2011_09_26" / "calib_cam_to_cam.txt",
      "calib_time: 09-Jan-2012 13:57:47\nS_rect_00: 65 33\nP_rect_00: 60 0 32 0 0 60 16 0 0 0 1 0\n"
      "P_rect_01: 60 0 32 -30 0 60 16 0 0 0 1 0\n");
  const auto recording{open_recording({{drive}, {}, ""})};
  EXPECT_EQ(recording->contents().kind, "KITTI raw drive");
  ASSERT_EQ(recording->size(), 2U);
  EXPECT_EQ(recording->load(0).stamp_ns, 1'317'042'145'964'389'445);
  EXPECT_EQ(recording->load(1).stamp_ns, 1'317'042'146'500'000'000) << "line of the frame's number";
  EXPECT_NEAR(recording->load(1).world_from_vehicle->yaw_rad, 0.5, 1e-9);
  EXPECT_FALSE(recording->contents().frames[1].scan.empty());
  EXPECT_THAT(recording->contents().notes, Contains(HasSubstr("of the IMU")));
  EXPECT_THAT(recording->contents().notes, Not(Contains(HasSubstr("interpolated"))));

  // records at times of their own: the second image lies between records 1 and 2
  put(drive / "oxts" / "data" / "0000000001.txt", "49 8.4 110 0 0 0.4 1 2 3\n");
  put(drive / "oxts" / "timestamps.txt",
      "2011-09-26 13:02:25.964389445\n2011-09-26 13:02:26.4\n2011-09-26 13:02:26.6\n");
  const auto timed{open_recording({{drive}, {}, ""})};
  EXPECT_NEAR(timed->load(0).world_from_vehicle->yaw_rad, 0.5, 1e-9);
  EXPECT_NEAR(timed->load(1).world_from_vehicle->yaw_rad, 0.45, 1e-9);
  EXPECT_THAT(timed->contents().notes, Contains(HasSubstr("interpolated")));
}

TEST_F(RecordingTest, PlainFolder) {
  put_plain(folder.path());
  const auto recording{open()};
  EXPECT_EQ(recording->contents().kind, "plain folder");
  EXPECT_EQ(recording->load(2).stamp_ns, 200'000'005);
  EXPECT_DOUBLE_EQ(recording->load(2).world_from_vehicle->yaw_rad, 0.1);
  EXPECT_DOUBLE_EQ(recording->rig().camera_height_m, 1.2);
  EXPECT_EQ(open("none")->load(2).stamp_ns, 200'000'005) << "stamps are still known";
}

TEST_F(RecordingTest, NamesAreInNaturalOrder) {
  put_pairs(folder / "left", folder / "right", {"frame_10", "frame_9", "frame_100"});
  put(folder / "calibration.yaml", small_yaml);
  const auto recording{open()};
  EXPECT_EQ(recording->name(0), "frame_9");
  EXPECT_EQ(recording->name(1), "frame_10");
  EXPECT_EQ(recording->name(2), "frame_100");
}

TEST_F(RecordingTest, ImagePair) {
  put_pairs(folder / "l", folder / "r", {"x"});
  put(folder / "c.yaml", small_yaml);
  const std::vector<fs::path> paths{folder / "l" / "x.png", folder / "r" / "x.png"};
  const auto recording{open_recording({paths, folder / "c.yaml", ""})};
  EXPECT_EQ(recording->contents().kind, "image pair");
  EXPECT_EQ(recording->load(0).right(3, 3), 110);
  EXPECT_EQ(recording->name(0), "x");
  expect_error([&] { return open_recording({paths, {}, ""}); }, {"no calibration", "--calibration"});
}

TEST_F(RecordingTest, CalibrationCanBeNamed) {
  put_plain(folder.path());
  put(folder / "other.txt", small_calib);
  EXPECT_DOUBLE_EQ(open_recording({{folder.path()}, folder / "other.txt", ""})->rig().baseline_m, 0.5);
}

TEST_F(RecordingTest, SixteenBitImagesShareOneScale) {
  put(folder / "calibration.yaml", small_yaml);
  fs::create_directories(folder / "left");
  fs::create_directories(folder / "right");
  for (const auto& [name, left, right] : {std::tuple{"0", 4000, 2000}, {"1", 500, 16000}}) {
    write_png(folder / "left" / (std::string{name} + ".png"),
              Image<std::uint16_t>{small_width_px, small_height_px, static_cast<std::uint16_t>(left)});
    write_png(folder / "right" / (std::string{name} + ".png"),
              Image<std::uint16_t>{small_width_px, small_height_px, static_cast<std::uint16_t>(right)});
  }
  const auto recording{open()};
  EXPECT_EQ(recording->contents().sample_bits, 14) << "of the right image of frame 1";
  EXPECT_EQ(recording->load(0).left(0, 0), 62);
  EXPECT_EQ(recording->load(0).right(0, 0), 31);
  EXPECT_EQ(recording->load(1).left(0, 0), 7);
  EXPECT_EQ(recording->load(1).right(0, 0), 250);
}

TEST_F(RecordingTest, ADarkFirstImageDoesNotSetTheScaleOfSixteenBits) {
  put(folder / "calibration.yaml", small_yaml);
  const std::vector<int> levels{1500, 60000, 8000, 60000};
  for (std::size_t i{0}; i < levels.size(); ++i) {
    const Image<std::uint16_t> image{small_width_px, small_height_px, static_cast<std::uint16_t>(levels[i])};
    for (const char* side : {"left", "right"}) {
      fs::create_directories(folder / side);
      write_png(folder / side / (std::to_string(i) + ".png"), image);
    }
  }
  const auto recording{open()};
  EXPECT_EQ(recording->contents().sample_bits, 16);
  EXPECT_EQ(recording->load(1).left(0, 0), 234) << "not saturated";
  EXPECT_EQ(recording->load(0).left(0, 0), 1500 >> 5) << "a dark pair keeps 32 levels at least";
  EXPECT_EQ(recording->load(2).right(0, 0), 8000 >> 7);
}

TEST(ShareScale, IsOneForBothImages) {
  const auto shared = [](int left_bits, int right_bits, int usual_bits) {
    ImagePair pair{{1, 1, 200}, {1, 1, 200}, left_bits, right_bits};
    share_scale(pair, usual_bits);
    EXPECT_TRUE(pair.left_bits == pair.right_bits || left_bits == 8 || right_bits == 8);
    return std::pair{int{pair.left(0, 0)}, int{pair.right(0, 0)}};
  };
  EXPECT_EQ(shared(12, 12, 12), (std::pair{200, 200}));
  EXPECT_EQ(shared(11, 12, 12), (std::pair{100, 200}));
  EXPECT_EQ(shared(12, 11, 10), (std::pair{200, 100})) << "brighter than usual: nothing saturates";
  EXPECT_EQ(shared(11, 11, 12), (std::pair{100, 100}));
  EXPECT_EQ(shared(10, 10, 16), (std::pair{50, 50})) << "dark";
  EXPECT_EQ(shared(8, 8, 8), (std::pair{200, 200}));
  EXPECT_EQ(shared(8, 12, 12), (std::pair{200, 200})) << "8-bit samples stay";
}

TEST_F(RecordingTest, ColourJpegAndPgm) {
  put(folder / "calibration.yaml", small_yaml);
  fs::create_directories(folder / "left");
  fs::create_directories(folder / "right");
  const cv::Mat colour(small_height_px, small_width_px, CV_8UC3, cv::Scalar(40, 80, 120));
  cv::imwrite((folder / "left" / "0.jpg").string(), colour);
  cv::imwrite((folder / "right" / "0.JPG").string(), colour);
  const cv::Mat grey(small_height_px, small_width_px, CV_8UC1, cv::Scalar(90));
  cv::imwrite((folder / "left" / "1.pgm").string(), grey);
  cv::imwrite((folder / "right" / "1.pgm").string(), grey);
  const auto recording{open()};
  ASSERT_EQ(recording->size(), 2U);
  EXPECT_NEAR(recording->load(0).left(5, 5), 0.114 * 40 + 0.587 * 80 + 0.299 * 120, 2);
  EXPECT_EQ(recording->load(1).right(5, 5), 90);
}

TEST_F(RecordingTest, EveryDataSetOpens) {
  const auto data{data_folder()};
  if (!data) GTEST_SKIP() << "no data sets on this machine (STEREOGRID_DATA)";
  const std::vector<std::tuple<std::string, std::size_t, bool>> sets{{"kitti_odo04", 41, true},
                                                                     {"kitti_raw0009", 31, true},
                                                                     {"kitti_raw0001", 20, true},
                                                                     {"kitti_pairs/obj_stereo_rcnn", 1, false},
                                                                     {"kitti_pairs/stereo2015_000046", 1, false},
                                                                     {"synthetic/A-static-occlusion", 5, true},
                                                                     {"synthetic/B-crossing", 40, true},
                                                                     {"synthetic/C-street", 60, true},
                                                                     {"synthetic/D-pitched", 20, true},
                                                                     {"synthetic/E-kitti-like", 12, true}};
  for (const auto& [name, count, poses] : sets) {
    const auto recording{open_recording({{*data / name}, {}, ""})};
    EXPECT_EQ(recording->size(), count) << name;
    EXPECT_EQ(recording->has_poses(), poses) << name;
    EXPECT_THAT(recording->contents().warnings, ::testing::IsEmpty()) << name;
    EXPECT_EQ(recording->has_truth(), name.starts_with("synthetic")) << name;
    const StereoFrame first{recording->load(0)};
    EXPECT_FALSE(finding_if_swapped(first)) << name;
    StereoFrame exchanged{first};
    std::swap(exchanged.left, exchanged.right);
    EXPECT_TRUE(finding_if_swapped(exchanged)) << name;
    EXPECT_FALSE(finding_if_shifted(first, recording->rig())) << name;
    EXPECT_FALSE(finding_if_shifted(exchanged, recording->rig())) << name;
    EXPECT_EQ(recording->load(count - 1).left.width(), recording->rig().width_px) << name;
  }
}

TEST_F(RecordingTest, LoadsOnSeveralThreads) {
  put_plain(folder.path());
  const std::string whole{read_file(folder / "left" / "b.png")};
  put(folder / "left" / "b.png", whole.substr(0, whole.size() / 2));
  const auto recording{open()};
  for (int round{0}; round < 10; ++round) {
    FrameQueue queue{*recording, 0, recording->size(), 3, 3};
    EXPECT_EQ(queue.next()->frame->left(0, 0), 10);
    EXPECT_THAT(queue.next()->error, HasSubstr("b.png"));
    EXPECT_EQ(queue.next()->frame->left(0, 0), 12);
    EXPECT_FALSE(queue.next());
  }
}

TEST_F(RecordingTest, PosesOfTheDataSetsPointTheRightWay) {
  const auto data{data_folder()};
  if (!data) GTEST_SKIP() << "no data sets on this machine (STEREOGRID_DATA)";
  for (const char* const name : {"kitti_odo04", "kitti_raw0009", "kitti_raw0001", "synthetic/C-street"}) {
    const auto recording{open_recording({{*data / name}, {}, ""})};
    const auto& frames{recording->contents().frames};
    const Pose2 step{inverse(*frames[4].world_from_vehicle) * *frames[5].world_from_vehicle};
    EXPECT_GT(step.x_m, 0.7) << name << ": the car drives forward";
    EXPECT_NEAR(step.y_m, 0, 0.1) << name;
    EXPECT_NEAR(step.yaw_rad, 0, 0.03) << name;
  }
}

}  // namespace
}  // namespace stereogrid::io::testing
