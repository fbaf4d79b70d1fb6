// SPDX-License-Identifier: Apache-2.0
//
// Bags of ROS 2 as input: what a plain folder gives, they give, too.
#include "bag_drive.hpp"
#include "stereogrid/io/calibration.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/io/poses.hpp"
#include "stereogrid/messages/nav_msgs.hpp"

namespace stereogrid::app::testing {
namespace {

TEST_F(Bags, ACameraInfoOfALargerImageIsScaled) {
  const auto doubled = [](CameraInfo& left, CameraInfo& right) {
    for (CameraInfo* info : {&left, &right}) {
      info->width *= 2;
      info->height *= 2;
      for (const std::size_t i : {0, 3, 5}) info->p.at(i) *= 2;
      for (const std::size_t i : {2, 6}) info->p.at(i) = 2 * info->p.at(i) + 0.5;
    }
  };
  EXPECT_THAT(expect_plain(entries({.spoil_infos = doubled})),
              HasSubstr("is for images of 320×200 px, but the images have 160×100: scaled by 0.5"));
}

TEST_F(Bags, GiveWhatThePlainFolderGives) {
  for (const char* encoding : {"mono8", "png", "rgb8", "bgr8", "mono16"}) {
    SCOPED_TRACE(encoding);
    const std::string more{std::string{encoding} == "png" ? "/compressed" : ""};
    EXPECT_THAT(expect_plain(entries(
                    {.encoding = encoding, .left = "/left/image_rect" + more, .right = "/right/image_rect" + more})),
                HasSubstr("ROS 2 bag, /left/image_rect"));
  }
  write_db3(*folder / "rosbag2", entries({}));
  const Outcome outcome{run_bag(*folder / "rosbag2")};
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  expect_equal_runs(plain(), *folder / "out");
}

/// Lessens the 16-bit samples of an image to a sixteenth.
void darken(Entry& image, std::size_t sample_bytes) {
  for (std::size_t i{image.data.size() - sample_bytes}; i + 1 < image.data.size(); i += 2) {
    image.data[i] = image.data[i] >> 4 | image.data[i + 1] << 4;
    image.data[i + 1] >>= 4;
  }
}

TEST_F(Bags, ADarkFirstFrameDoesNotSetTheScaleOfSixteenBits) {
  std::vector<Entry> all{entries({.encoding = "mono16"})};
  constexpr std::size_t sample_bytes{100 * (2 * 160 + 2)};
  for (std::size_t i{0}; i < 4; ++i) {
    if (all[i].data.size() > sample_bytes) darken(all[i], sample_bytes);
  }
  write_mcap(bag(), all);
  EXPECT_THAT(run_well({"info", bag()}).output, HasSubstr("12 bits in 16"));
  ASSERT_EQ(run_bag(bag()).exit_code, 0);
  const auto lines{lines_of(out())};
  const auto bright{lines_of(plain())};
  ASSERT_EQ(lines.size(), bright.size());
  for (std::size_t i{1}; i < lines.size(); ++i) EXPECT_EQ(lines[i]["density"], bright[i]["density"]);
}

TEST_F(Bags, ZedsKindsOfImagesAreOneCamera) {
  const std::vector<Entry> plain_entries{entries({})};
  for (const std::vector<std::string>& kinds :  // the first one is taken; wrapper 5.1 and before
       {Words{"/gray/rect/image", "/color/rect/image", "/color/raw/image", "/gray/raw/image"},
        Words{"_gray/image_rect_gray", "/image_rect_color", "_raw/image_raw_color", "_raw_gray/image_raw_gray"}}) {
    std::vector<Entry> all;
    for (const std::string& kind : kinds) {
      for (Entry one : plain_entries) {
        const bool is_left{one.topic.starts_with("/left")};
        const bool is_info{one.type == CameraInfo::type_name};
        const bool is_swapped{kind != kinds.front() && !is_info};
        const std::string camera{std::string{is_left != is_swapped ? "/zed/left" : "/zed/right"} + kind};
        one.topic = is_info ? camera.substr(0, camera.rfind('/')) + "/camera_info" : camera;
        all.push_back(one);
      }
    }
    expect_plain(all);
  }
}

TEST_F(Bags, FramesAreTakenFromTheMiddleAndARunGoesOn) {
  write_mcap(bag(), entries({}));
  ASSERT_EQ(run_bag(bag(), {"--poses", "none", "--frames", "0:1"}).exit_code, 0);
  run_well({"run", bag(), "--out", *folder / "out", "--poses", "none", "--resume"});
  expect_equal_runs(plain(), *folder / "out");
  ASSERT_EQ(run_bag(bag(), {"--poses", "none", "--frames", "3:"}).exit_code, 0);
  EXPECT_EQ(lines_of(*folder / "out").front()["stamp_ns"], stamp_of(3));
}

// The same pair in a bag and in calibration.yaml: R turns each camera into the rectified pair, the right one alone
// here, by 0.02 rad about y.
TEST_F(Bags, ARawPairIsThatOfItsCameraInfo) {
  struct Lens {
    const char* model;
    const char* in_file;
    std::vector<double> left;
    std::vector<double> right;
  };
  const double s{std::sin(0.02)};
  const double c{std::cos(0.02)};
  for (const Lens& lens : {Lens{"plumb_bob", "perspective", {-0.1, 0.02, 0.001, 0, 0}, {0, 0, 0, 0, 0}},
                           Lens{"equidistant", "fisheye", {-0.02, 0.004, 0, 0}, {0.01, 0, 0, 0}}}) {
    write_mcap(bag(), entries({.left = "/left/image_raw",
                               .right = "/right/image_raw",
                               .spoil_infos = [&](CameraInfo& left, CameraInfo& right) {
                                 left.distortion_model = right.distortion_model = lens.model;
                                 left.d = lens.left;
                                 right.d = lens.right;
                                 right.r = {c, 0, s, 0, 1, 0, -s, 0, c};
                               }}));
    // right_from_left = Rᵀ, translation Rᵀ (−0.25, 0, 0)
    const fs::path file{*folder / "raw.yaml"};
    const CameraInfo k{info(false)};
    std::ofstream yaml{file};
    yaml.precision(17);
    for (const auto& [side, numbers] : {std::pair{"left", lens.left}, std::pair{"right", lens.right}}) {
      yaml << side << ": {lens: " << lens.in_file << ", focal_u_px: 128, focal_v_px: 128, cx_px: " << k.k[2]
           << ", cy_px: " << k.k[5] << ", distortion: [" << numbers[0];
      for (std::size_t i{1}; i < numbers.size(); ++i) yaml << ", " << numbers[i];
      yaml << "]}\n";
    }
    yaml << "right_from_left:\n  rotation: [" << c << ", 0, " << -s << ", 0, 1, 0, " << s << ", 0, " << c
         << "]\n  translation_m: [" << -0.25 * c << ", 0, " << -0.25 * s << "]\n";
    yaml.close();
    const auto camera_of = [](const Outcome& outcome) {
      const std::size_t at{outcome.output.find("camera ")};
      return outcome.output.substr(at, outcome.output.find('\n', at) - at);
    };
    const Outcome by_bag{run_tool({"info", bag()})};
    const Outcome by_file{run_tool({"info", bag(), "--calibration", file})};
    EXPECT_THAT(by_bag.output, HasSubstr("raw images: rectified on loading"));
    EXPECT_THAT(camera_of(by_bag), HasSubstr("baseline 0.25 m"));
    EXPECT_EQ(camera_of(by_bag), camera_of(by_file)) << by_bag.output << by_bag.errors << by_file.errors;
    EXPECT_THAT(camera_of(by_bag), Not(HasSubstr("focal length 128 px"))) << "turned and undistorted";
  }
}

messages::geometry_msgs::Quaternion turned_by(double yaw_rad) {
  return {0, 0, std::sin(yaw_rad / 2), std::cos(yaw_rad / 2)};
}

TEST_F(Bags, PosesAreThoseOfOdometryOrTf) {
  const std::vector<io::NamedPose> driven{io::read_poses_csv(drive() / "poses.csv")};
  ASSERT_EQ(driven.size(), frames);
  std::vector<Entry> with_odometry{entries({})};
  std::vector<Entry> with_tf{with_odometry};
  for (const io::NamedPose& pose : driven) {
    const Pose2& place{pose.world_from_vehicle};
    messages::nav_msgs::Odometry odometry;
    odometry.header = header(pose.stamp_ns);
    odometry.pose.pose.position = {place.x_m, place.y_m, 0.3};
    odometry.pose.pose.orientation = turned_by(place.yaw_rad);
    with_odometry.push_back(entry("/odom", start_ns + pose.stamp_ns, odometry));
    messages::tf2_msgs::TFMessage tf{
        {transform("", "wheel", {}),
         transform("odom", "base_link", {place.x_m, place.y_m, 0.3}, turned_by(place.yaw_rad))}};
    tf.transforms[1].header.stamp = header(pose.stamp_ns).stamp;
    with_tf.push_back(entry("/tf", start_ns + pose.stamp_ns, tf));
  }
  run_well({"run", drive(), "--out", *folder / "driven"});
  const std::vector<Json> expected = lines_of(*folder / "driven");
  for (const auto& [content, source] :
       {std::pair{with_odometry, "/odom (nav_msgs/Odometry)"}, {with_tf, "/tf (odom"}}) {
    write_mcap(bag(), content);
    const Outcome outcome{run_bag(bag(), {})};
    ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
    EXPECT_THAT(outcome.errors, HasSubstr(source));
    const std::vector<Json> lines = lines_of(*folder / "out");
    ASSERT_EQ(lines.size(), frames);
    for (std::size_t i{0}; i < frames; ++i) {
      EXPECT_NEAR(lines[i]["pose"]["x_m"].get<double>(), expected[i]["pose"]["x_m"].get<double>(), 1e-9);
      EXPECT_NEAR(lines[i]["pose"]["yaw_rad"].get<double>(), expected[i]["pose"]["yaw_rad"].get<double>(), 1e-9);
    }
  }
  EXPECT_GT(expected.back()["pose"]["x_m"].get<double>(), 1);
}

TEST_F(Bags, ImagesArePairedByTheirStamps) {
  std::vector<Entry> late{entries({.right_late_ns = 4'000'000})};
  late.pop_back();  // the last right image
  write_mcap(bag(), late);
  const Outcome outcome{run_bag(bag())};
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_THAT(outcome.errors, HasSubstr("/left/image_rect: 1 of 4 images have no partner within 10 ms"));
  EXPECT_THAT(outcome.errors, Not(HasSubstr("warning: /right")));
  EXPECT_EQ(lines_of(*folder / "out").size(), 3U);
  expect_error(late, "none of the 4 images on /left/image_rect and 3 on", {"--pair-tolerance-ms", "3"});
}

TEST_F(Bags, WithTwoPairsOfCamerasItIsAskedWhich) {
  std::vector<Entry> two{entries({})};
  for (Entry& one : entries({.left = "/rear_left/image_rect", .right = "/rear_right/image_rect"})) two.push_back(one);
  expect_error(two, "more than one pair of cameras: /left/image_rect, /right/image_rect, /rear_left/image_rect");
  const Outcome outcome{run_bag(bag(), {"--poses", "none", "--left-topic", "/rear_left/image_rect"})};
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_THAT(outcome.errors, HasSubstr("/rear_left/image_rect and /rear_right/image_rect: 4 frames"));
  expect_equal_runs(plain(), *folder / "out");
  expect_error(two, "has no images on /front", {"--left-topic", "/front", "--right-topic", "/right/image_rect"});
  const Outcome no_bag{run_tool({"info", drive(), "--left-topic", "/left/image_rect"})};
  EXPECT_EQ(no_bag.exit_code, 64);
}

TEST_F(Bags, ACameraMayBeCalledAsASide) {
  std::vector<Entry> two;
  for (const std::string camera : {"/left", "/right"}) {
    for (Entry& one :
         entries({.left = camera + "/left/image_rect", .right = camera + "/right/image_rect", .has_infos = false}))
      two.push_back(one);
    two.push_back(entry(camera + "/left/camera_info", start_ns, info(false)));
    two.push_back(entry(camera + "/right/camera_info", start_ns, info(true)));
  }
  write_mcap(bag(), two);
  for (const std::string camera : {"/left", "/right"}) {
    const Outcome done{run_bag(bag(), {"--poses", "none", "--left-topic", camera + "/left/image_rect"})};
    ASSERT_EQ(done.exit_code, 0) << done.errors;
    EXPECT_THAT(done.errors, HasSubstr(camera + "/left/image_rect and " + camera + "/right/image_rect: 4 frames"));
    expect_equal_runs(plain(), out());
  }
}

TEST_F(Bags, RectifiedImagesComeBeforeRawOnes) {
  std::vector<Entry> both{entries({})};
  for (std::size_t i{0}; i < frames; ++i) {
    both.push_back(image("/left/image_raw", "left", i, "mono8", 0));
    both.push_back(image("/right/image_raw", "right", i, "mono8", 0));
    both.push_back(image("/left/image_rect/compressed", "left", i, "png", 0));
    both.push_back(image("/right/image_rect/compressed", "right", i, "png", 0));
  }
  write_mcap(bag(), both);
  EXPECT_THAT(run_bag(bag()).errors, HasSubstr("ROS 2 bag, /left/image_rect and /right/image_rect:"));
}

/// Two cameras, back to back, of a static vehicle as folders, and the same as topics.
class SeveralPairs : public Bags {
 protected:
  static constexpr std::array names{"front", "rear"};

  static fs::path cameras() { return *folder / "cameras"; }
  static void SetUpTestSuite() {
    Bags::SetUpTestSuite();
    run_well({"simulate", "scene:around?cameras=2&turn_deg=180&focal=96&frames=4", "--width", "160", "--height", "100",
              "--out", cameras(), "--no-truth"});
  }

  static Rig rig(std::size_t camera) {
    return io::read_calibration(cameras() / ("camera" + std::to_string(camera)) / "calibration.yaml", 160, 100).rig;
  }
  static std::string frame_of(std::size_t camera) { return std::string{names.at(camera)} + "_optical"; }

  /// base_footprint → base_link 0.3 m above it → the cameras' optical frames ahead or behind, level.
  static Entry transforms(std::size_t count = names.size()) {
    messages::tf2_msgs::TFMessage message{{transform("base_footprint", "base_link", {0, 0, 0.25})}};
    for (std::size_t i{0}; i < count; ++i) {
      message.transforms.push_back(
          transform("base_link", frame_of(i), {rig(i).camera_x_m, rig(i).camera_y_m, rig(i).camera_height_m - 0.25},
                    i == 0 ? ahead : messages::geometry_msgs::Quaternion{-0.5, -0.5, 0.5, 0.5}));
    }
    return entry("/tf_static", start_ns, message);
  }

  /// Without transforms. `rear_late_ns`: the rear camera's images after the front camera's.
  static std::vector<Entry> images(std::int64_t rear_late_ns = 0) {
    std::vector<Entry> all;
    for (std::size_t camera{0}; camera < names.size(); ++camera) {
      const std::string name_space{"/robot/" + std::string{names.at(camera)}};
      for (const char* side : {"left", "right"}) {
        const std::string topic{name_space + "/" + side};
        all.push_back(entry(topic + "/camera_info", start_ns, info(std::string{side} == "right", rig(camera))));
        for (std::size_t i{0}; i < frames; ++i) {
          const std::int64_t stamp_ns{stamp_of(i) + (camera == 1 ? rear_late_ns : 0)};
          const fs::path file{cameras() / ("camera" + std::to_string(camera)) / side /
                              ("00000" + std::to_string(i) + ".png")};
          messages::sensor_msgs::Image message{image_of(io::read_grey(file), "mono8")};
          message.header = header(stamp_ns);
          message.header.frame_id = frame_of(camera);
          all.push_back(entry(topic + "/image_rect", start_ns + stamp_ns, message));
        }
      }
    }
    return all;
  }
};

TEST_F(SeveralPairs, GiveWhatTheirFoldersGive) {
  const fs::path by_folders{*folder / "by_folders"};
  run_well({"run", cameras(), "--out", by_folders, "--poses", "none", "--set", "grid.rear_m=10"});
  std::vector<Entry> all{images()};
  all.push_back(transforms());
  write_mcap(bag(), all);
  write_db3(*folder / "several", all);
  for (const fs::path& recorded : {bag(), *folder / "several"}) {
    const Outcome done{
        run_bag(recorded, {"--poses", "none", "--set", "grid.rear_m=10", "--cameras", "/robot/front,robot/rear/"})};
    ASSERT_EQ(done.exit_code, 0) << done.errors;
    EXPECT_THAT(done.errors, Not(HasSubstr("warning: rear")));
    expect_equal_runs(by_folders, out());
    EXPECT_EQ(json_of(out() / "run.json").at("other_rigs"), json_of(by_folders / "run.json").at("other_rigs"));
    EXPECT_EQ(json_of(out() / "run.json").at("input").at("cameras"), Json({"/robot/front", "robot/rear/"}));
  }
  const Outcome folders{
      run_bag(cameras(), {"--poses", "none", "--set", "grid.rear_m=10", "--cameras", "camera0,camera1"})};
  ASSERT_EQ(folders.exit_code, 0) << folders.errors;
  expect_equal_runs(by_folders, out());
  EXPECT_EQ(json_of(by_folders / "run.json").at("input").at("cameras"), Json({"camera0", "camera1"}));
  run_well({"run", cameras(), "--out", by_folders, "--poses", "none", "--set", "grid.rear_m=10", "--cameras",
            "camera0,./camera1", "--resume"});
}

TEST_F(SeveralPairs, HaveTheFrameOfTheNearestStamp) {
  std::vector<Entry> all{images(40'000'000)};
  all.push_back(transforms());
  write_mcap(bag(), all);
  const Outcome done{run_bag(bag(), {"--poses", "none", "--cameras", "/robot/front,/robot/rear"})};
  ASSERT_EQ(done.exit_code, 0) << done.errors;
  EXPECT_THAT(done.errors, Not(HasSubstr("have a frame of it within half an interval")));
  EXPECT_EQ(lines_of(out()).size(), frames);
}

TEST_F(SeveralPairs, HavePosesOfTheRobot) {
  std::vector<Entry> all{images()};
  all.push_back(transforms());
  for (std::size_t i{0}; i < frames; ++i) {
    messages::nav_msgs::Odometry odometry;
    odometry.header = header(stamp_of(i));
    odometry.child_frame_id = "base_link";
    odometry.pose.pose.position.x = 0.5 * static_cast<double>(i);
    odometry.pose.pose.orientation.w = 1;
    all.push_back(entry("/odom", start_ns + stamp_of(i), odometry));
  }
  write_mcap(bag(), all);
  const Outcome done{run_bag(bag(), {"--cameras", "/robot/front,/robot/rear"})};
  ASSERT_EQ(done.exit_code, 0) << done.errors;
  const std::vector<Json> lines = lines_of(out());
  EXPECT_NEAR(lines.at(3)["pose"]["x_m"].get<double>(), 1.5, 1e-9) << "not of the front camera, 0.5 m ahead";
}

TEST_F(SeveralPairs, AreRefusedWhereAPlaceOrImagesAreMissing) {
  std::vector<Entry> all{images()};
  expect_error(all, "more than one pair of cameras: /robot/front/left/image_rect");
  expect_error(all, "--cameras /front,/rear");
  all.push_back(transforms(1));
  expect_error(all, "/tf_static does not connect base_link with 'rear_optical'",
               {"--cameras", "/robot/front,/robot/rear"});
  expect_error(all, "has no images below /robot/side. There are: /robot/front/left/image_rect",
               {"--cameras", "/robot/side"});
  for (const auto& [listed, text] : {std::pair{"/a,/b,/a", "lists /a twice"},
                                     {"/a,a/", "lists /a twice"},
                                     {"/1,/2,/3,/4,/5,/6,/7,/8,/9", "9 stereo pairs (allowed 1 to 8)"}}) {
    EXPECT_THAT(errors_of(64, {"info", bag(), "--cameras", listed}), HasSubstr(text));
  }
  EXPECT_THAT(errors_of(64, {"info", bag(), "--cameras", "/a,/b", "--left-topic", "/a/left"}),
              HasSubstr("are of one camera"));
  EXPECT_EQ(run_tool({"info", "scene:street", "--cameras", "a,b"}).exit_code, 64);
}

}  // namespace
}  // namespace stereogrid::app::testing
