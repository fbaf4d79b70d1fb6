// SPDX-License-Identifier: Apache-2.0
//
// Bags of ROS 2 as input: what a plain folder gives, they give, too.
#include "bag_drive.hpp"
#include "stereogrid/io/poses.hpp"
#include "stereogrid/messages/geometry_msgs.hpp"
#include "stereogrid/messages/nav_msgs.hpp"

namespace stereogrid::app::testing {
namespace {

TEST_F(Bags, ACameraInfoOfALargerImageIsScaled) {
  EXPECT_THAT(expect_plain(entries({.spoil_infos =
                                        [](CameraInfo& left, CameraInfo& right) {
                                          for (CameraInfo* info : {&left, &right}) {
                                            info->width *= 2;
                                            info->height *= 2;
                                            for (const std::size_t i : {0, 3, 5}) info->p.at(i) *= 2;
                                            for (const std::size_t i : {2, 6}) info->p.at(i) = 2 * info->p.at(i) + 0.5;
                                          }
                                        }})),
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
       {std::vector<std::string>{"/gray/rect/image", "/color/rect/image", "/color/raw/image", "/gray/raw/image"},
        std::vector<std::string>{"_gray/image_rect_gray", "/image_rect_color", "_raw/image_raw_color",
                                 "_raw_gray/image_raw_gray"}}) {
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
    messages::tf2_msgs::TFMessage tf;
    tf.transforms.resize(2);
    tf.transforms[0].child_frame_id = "wheel";
    tf.transforms[1].header = header(pose.stamp_ns);
    tf.transforms[1].header.frame_id = "odom";
    tf.transforms[1].child_frame_id = "base_link";
    tf.transforms[1].transform.translation = {place.x_m, place.y_m, 0.3};
    tf.transforms[1].transform.rotation = turned_by(place.yaw_rad);
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

}  // namespace
}  // namespace stereogrid::app::testing
