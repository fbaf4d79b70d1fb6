// SPDX-License-Identifier: Apache-2.0
//
// The program on the network: stereogrid run and live with --ros2, live ros2:/….
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/definition.hpp"
#include "stereogrid/messages/geometry_msgs.hpp"
#include "support.hpp"

namespace stereogrid::dds::testing {
namespace {

namespace fs = std::filesystem;

std::string word(const std::string& line, std::size_t index) {
  std::size_t begin{0};
  for (; index > 0; --index) begin = line.find(' ', begin) + 1;
  return line.substr(begin, line.find(' ', begin) - begin);
}

std::string grids(const std::string& topic, int count, int seconds) {
  return bare_peer("grids rt" + topic + " reliable transient_local " + std::to_string(count) + " " +
                   std::to_string(seconds));
}

const std::string scene{"'scene:street?width=192&height=128&frames=8'"};

TEST(DdsTool, ARunPublishes) {
  const fs::path folder{fs::temp_directory_path() / ("stereogrid_dds_" + std::to_string(getpid()))};
  Peer map{grids("/map", 1, 40)};
  Peer observed{grids("/robot/grid/observed_grid", 1, 40)};
  Peer run{tool("run " + scene + " --out " + folder.string() +
                " --ros2 --ros2-node robot/grid --ros2-remap occupancy_grid:=/map")};
  EXPECT_THAT(map.line(), HasSubstr(" odom "));
  EXPECT_THAT(observed.line(), HasSubstr(" base_link "));
  all_of(run);
  EXPECT_EQ(run.exit_code(), 0);
  fs::remove_all(folder);
}

TEST(DdsTool, LiveTakesImagesAndPosesAndGivesTheirStampsBack) {
  Peer map{grids("/stereo_grid/occupancy_grid", 10, 40)};
  Peer live{tool("live ros2:/stereo --poses /stereo/odom --ros2-camera-at 0,0,0 --ros2 --listen :0", 6)};
  Peer cameras{bare_peer("pairs /stereo best_effort 256x160 20 5")};
  const std::vector<std::string> pairs{cameras.rest()};
  const std::vector<std::string> came{map.rest()};
  ASSERT_THAT(came, SizeIs(10));
  for (const std::string& grid : came) EXPECT_THAT(pairs, Contains("pair " + word(grid, 1)));
  const std::string said{all_of(live)};
  EXPECT_THAT(said, AllOf(HasSubstr("CameraInfo of /stereo/left/camera_info"), Not(HasSubstr("no pose"))));
}

/// base_link → left_optical, latched, or other transforms.
class RobotStatePublisher {
 public:
  using Message = messages::tf2_msgs::TFMessage;

  RobotStatePublisher() {
    channel_ = node_->sink().add({"/tf_static", Message::type_name, messages::definition_of<Message>(), true});
  }
  /// `rotation`: by default that of a camera with its axis along x.
  void send(const messages::geometry_msgs::Vector3& place,
            const messages::geometry_msgs::Quaternion& rotation = {-0.5, 0.5, -0.5, 0.5}) {
    Message message;
    add(message, "left_optical", place, rotation);
    send(message);
  }
  static void add(Message& message, const std::string& camera, const messages::geometry_msgs::Vector3& place,
                  const messages::geometry_msgs::Quaternion& rotation) {
    auto& one{message.transforms.emplace_back()};
    one.header.frame_id = "base_link";
    one.child_frame_id = camera;
    one.transform.translation = place;
    one.transform.rotation = rotation;
  }
  void send(const Message& message) {
    messages::CdrWriter writer;
    node_->sink().send(channel_, 0, writer.encode(message));
  }

 private:
  std::unique_ptr<Node> node_{open_node({.name = "robot_state_publisher"})};
  std::uint32_t channel_{};
};

// The same cameras at the origin of the robot's frame, 10 m ahead by option, and turned to the left by TF.
TEST(DdsTool, TheCameraMayBeElsewhereThanWhatThePosesAreOf) {
  const std::string options{"live ros2:/stereo --poses /stereo/odom --ros2 --listen :0 --ros2-node "};
  RobotStatePublisher robot;
  robot.send({0, 0, 1.1}, {-std::numbers::sqrt2 / 2, 0, 0, std::numbers::sqrt2 / 2});
  Peer here{grids("/a/occupancy_grid", 5, 40)};
  Peer ahead{grids("/b/occupancy_grid", 5, 40)};
  Peer left{grids("/c/occupancy_grid", 5, 40)};
  Peer vehicle{grids("/b/observed_grid", 1, 40)};
  Peer first{tool(options + "a --ros2-camera-at 0,0,0", 6)};
  Peer second{tool(options + "b --ros2-camera-at 10,0,0", 6)};
  Peer third{tool(options + "c", 6)};
  Peer cameras{bare_peer("pairs /stereo best_effort 256x160 10 5")};
  const std::vector<std::string> near{here.rest()};
  const std::vector<std::string> far{ahead.rest()};
  const std::vector<std::string> turned{left.rest()};
  ASSERT_THAT(near, SizeIs(5));
  ASSERT_THAT(far, SizeIs(5));
  ASSERT_THAT(turned, SizeIs(5));
  const auto moved = [&near](const std::vector<std::string>& other, std::size_t coordinate) {
    return std::stod(word(other[4], coordinate)) - std::stod(word(near[4], coordinate));
  };
  constexpr std::size_t origin_x{5};
  constexpr std::size_t origin_y{6};
  EXPECT_NEAR(moved(far, origin_x), 10, 2) << near[4] << far[4];
  EXPECT_NEAR(moved(far, origin_y), 0, 1) << near[4] << far[4];
  EXPECT_NEAR(moved(turned, origin_x), -10, 2) << "half the grid's length" << near[4] << turned[4];
  EXPECT_NEAR(moved(turned, origin_y), 10, 1) << near[4] << turned[4];
  EXPECT_THAT(vehicle.line(), HasSubstr(" stereo_grid "));
}

TEST(DdsTool, APlaceOfTheCameraThatIsUnknownIsWaitedFor) {
  for (const char* poses : {"tf", "/stereo/odom"}) {
    Peer map{grids("/stereo_grid/occupancy_grid", 1, 40)};
    Peer live{tool("live ros2:/stereo --ros2 --listen :0 --poses " + std::string{poses}, 8)};
    Peer cameras{bare_peer("pairs /stereo best_effort 256x160 10 8")};
    std::this_thread::sleep_for(std::chrono::seconds{5});
    const auto sent{std::chrono::system_clock::now().time_since_epoch()};
    RobotStatePublisher robot;
    robot.send({0.5, 0, 1.1});
    const std::vector<std::string> came{map.rest()};
    ASSERT_THAT(came, SizeIs(1)) << poses;
    EXPECT_GT(std::stoll(word(came[0], 1)), std::chrono::nanoseconds{sent}.count() - 1'000'000'000) << "too early";
    EXPECT_THAT(all_of(live), AllOf(HasSubstr("waiting: TF does not connect base_link with left_optical"),
                                    HasSubstr("extrinsics of TF (base_link → left_optical)")));
  }
}

// odom → base_link is the cameras' peer's, base_link → left_optical is latched and 0.5 m ahead, 1.1 m up.
TEST(DdsTool, TfGivesTheCamerasPoseAndItsMounting) {
  RobotStatePublisher robot;
  robot.send({0.5, 0, 1.1});
  Peer map{grids("/stereo_grid/occupancy_grid", 5, 40)};
  Peer observed{grids("/stereo_grid/observed_grid", 1, 40)};
  Peer live{tool("live ros2:/stereo --poses tf --ros2 --listen :0", 7)};
  Peer cameras{bare_peer("pairs /stereo best_effort 256x160 10 6")};
  EXPECT_THAT(map.rest(), SizeIs(5));
  EXPECT_THAT(observed.line(), HasSubstr(" stereo_grid "));
  const std::string said{all_of(live)};
  EXPECT_THAT(said, AllOf(HasSubstr("extrinsics of TF (base_link → left_optical)"), HasSubstr("height 1.10 m"),
                          HasSubstr("poses of the camera: left_optical in odom"), Not(HasSubstr("cannot be used"))));
}

// The rear pair ends after 6 s, the front one after the tool.
TEST(DdsTool, SeveralPairsMakeOneGridAndOneThatStopsIsNamed) {
  RobotStatePublisher robot;
  RobotStatePublisher::Message places;
  RobotStatePublisher::add(places, "front_optical", {0.5, 0, 1.1}, {-0.5, 0.5, -0.5, 0.5});
  RobotStatePublisher::add(places, "rear_optical", {-0.5, 0, 1.1}, {-0.5, -0.5, 0.5, 0.5});
  robot.send(places);
  Peer map{grids("/stereo_grid/occupancy_grid", 40, 60)};
  Peer observed{grids("/stereo_grid/observed_grid", 1, 60)};
  Peer live{tool("live ros2: --cameras /front,rear/ --poses /front/odom --ros2 --listen :0 --set grid.rear_m=10", 14)};
  Peer front{bare_peer("pairs /front best_effort 256x160 10 16 now one_of_several")};
  Peer rear{bare_peer("pairs /rear best_effort 256x160 10 6 now one_of_several")};
  EXPECT_THAT(map.rest(), SizeIs(40)) << "beyond those with both";
  EXPECT_THAT(observed.line(), HasSubstr(" stereo_grid "));
  EXPECT_THAT(all_of(live),
              AllOf(HasSubstr("/front/left/image_rect: 0.50 m ahead, 0.00 m and 0.0° to the left in base_link, 1.10 m"),
                    HasSubstr("/rear/left/image_rect: -0.50 m ahead, 0.00 m and 180.0° to the left in base_link"),
                    HasSubstr("poses of the vehicle: base_link in odom on /front/odom"), HasSubstr("rear: "),
                    Not(HasSubstr("warning: front: No image"))));
}

TEST(DdsTool, SeveralPairsNeedTheirPlaces) {
  Peer live{tool("live ros2: --cameras /front,/rear --poses none --ros2 --listen :0", 8)};
  Peer front{bare_peer("pairs /front best_effort 256x160 10 8 now one_of_several")};
  Peer rear{bare_peer("pairs /rear best_effort 256x160 10 8 now one_of_several")};
  EXPECT_THAT(all_of(live),
              HasSubstr("waiting: TF does not connect base_link with front_optical: the camera's place is "
                        "unknown. Publish it (robot_state_publisher"));
}

/// odom → base_link of a robot at y = 100 m, and what other nodes publish to base_link.
class Robot {
 public:
  Robot() {
    node_->subscribe("/tf", std::string{TFMessage::type_name}, 100, [others = others_](std::span<const std::byte> cdr) {
      TFMessage message;
      messages::decode(cdr, message);
      for (const auto& one : message.transforms) *others += one.child_frame_id == "base_link" ? 1 : 0;
    });
  }
  [[nodiscard]] int others() const { return *others_; }
  void publish_for(std::chrono::milliseconds duration) {
    if (!channel_) {
      channel_ = node_->sink().add({"/tf", TFMessage::type_name, messages::definition_of<TFMessage>(), false});
    }
    TFMessage message;
    auto& one{message.transforms.emplace_back()};
    one.header.frame_id = "odom";
    one.child_frame_id = "base_link";
    one.transform.translation.y = 100;
    messages::CdrWriter writer;
    for (const auto end{std::chrono::steady_clock::now() + duration}; std::chrono::steady_clock::now() < end;) {
      node_->sink().send(*channel_, 0, writer.encode(message));
      std::this_thread::sleep_for(std::chrono::milliseconds{20});
    }
  }

 private:
  using TFMessage = messages::tf2_msgs::TFMessage;

  std::unique_ptr<Node> node_{open_node({.name = "robot"})};
  std::optional<std::uint32_t> channel_{};
  std::shared_ptr<std::atomic<int>> others_{std::make_shared<std::atomic<int>>(0)};
};

const std::string not_published{
    "another node publishes the transform odom → base_link: odom → base_link is not published on /tf."};

TEST(DdsTool, ATransformOfARobotIsNotPublished) {
  Robot robot;
  robot.publish_for(std::chrono::milliseconds{100});
  Peer live{tool("live " + scene + " --loop --ros2 --listen :0", 4)};
  robot.publish_for(std::chrono::seconds{4});
  EXPECT_THAT(all_of(live), HasSubstr(not_published));
  EXPECT_EQ(robot.others(), 0);
}

TEST(DdsTool, ATransformIsPublishedUntilARobotHasIt) {
  Robot robot;
  Peer live{tool("live " + scene + " --loop --ros2 --listen :0", 8)};
  ASSERT_TRUE(becomes([&] { return robot.others() > 3; }));
  robot.publish_for(std::chrono::milliseconds{1000});
  const int before{robot.others()};
  robot.publish_for(std::chrono::milliseconds{1000});
  EXPECT_EQ(robot.others(), before);
  EXPECT_THAT(all_of(live), HasSubstr(not_published));
}

TEST(DdsTool, StaticTransformsOfTheFirstSecondArePublishedAfterIt) {
  std::atomic<bool> has_come{false};
  const auto node{open_node({.name = "listener"})};
  node->subscribe(
      "/tf_static", std::string{messages::tf2_msgs::TFMessage::type_name}, 10,
      [&has_come](std::span<const std::byte>) { has_come = true; }, true);
  Peer live{tool("live " + scene + " --loop --ros2 --listen :0", 4)};
  EXPECT_TRUE(becomes([&] { return has_come.load(); }));
  EXPECT_THAT(all_of(live), Not(HasSubstr("another node")));
}

TEST(DdsTool, LiveTakesCompressedImages) {
  Peer map{grids("/stereo_grid/occupancy_grid", 3, 20)};
  Peer live{tool("live ros2:/stereo --poses none --ros2 --listen :0", 4)};
  Peer cameras{bare_peer("pairs /stereo best_effort 256x160 20 3 1000 compressed")};
  EXPECT_THAT(map.rest(), SizeIs(3));
  EXPECT_THAT(all_of(live), HasSubstr("/stereo/left/image_rect/compressed"));
}

TEST(DdsTool, WhereTimeStepsBackAllRestarts) {
  for (const char* option : {"", " --ros2-sim-time"}) {
    Peer map{grids("/stereo_grid/occupancy_grid", 200, 7)};
    Peer live{tool("live ros2:/stereo --poses tf --ros2-camera-at 0,0,0 --ros2 --listen :0" + std::string{option}, 6)};
    for (int i{0}; i < 2; ++i) Peer{bare_peer("pairs /stereo best_effort 256x160 20 2.5 1000")}.rest();
    std::vector<std::string> stamps;
    for (const std::string& grid : map.rest()) stamps.push_back(word(grid, 1));
    ASSERT_THAT(stamps, Not(IsEmpty()));
    EXPECT_FALSE(std::ranges::is_sorted(stamps)) << option;
    EXPECT_EQ(stamps.back().size(), 13U);  // 1000 s and some
    const std::string said{all_of(live)};
    EXPECT_THAT(said, HasSubstr(*option == '\0' ? "the stamps of the images step back" : "/clock steps back"));
  }
}

TEST(DdsTool, CamerasOfDifferentClocksAreDistinguished) {
  Peer left{bare_peer("pairs /a best_effort 256x160 10 8 1000")};
  Peer right{bare_peer("pairs /b best_effort 256x160 10 8 1005")};
  Peer live{tool("live ros2: --left-topic /a/left/image_rect --right-topic /b/right/image_rect --listen :0", 8)};
  EXPECT_THAT(all_of(live), AllOf(HasSubstr("ms apart"), Not(HasSubstr("restart"))));
}

TEST(DdsTool, FramesWithoutAPoseAreLeftOutAndCounted) {
  Peer live{tool("live ros2:/stereo --poses /nowhere --ros2-camera-at 0,0,0 --listen :0", 5)};
  Peer cameras{bare_peer("pairs /stereo reliable 256x160 10 4")};
  const std::string said{all_of(live)};
  EXPECT_THAT(said, AllOf(HasSubstr("/nowhere: there is no pose yet."), HasSubstr("no pose of its instant: ")));
}

TEST(DdsTool, DroppedPosesAreCountedWithTheirReason) {
  Peer live{tool("live ros2:/stereo --poses /stereo/odom --ros2-camera-at 0,0,0 --listen :0", 5)};
  Peer cameras{bare_peer("pairs /stereo reliable 256x160 10 4 1000 halved")};
  const std::string said{all_of(live)};
  EXPECT_THAT(said,
              AllOf(HasSubstr("/stereo/odom: 1 of "), HasSubstr("poses are dropped: 1 with a quaternion of length 0.5"),
                    HasSubstr("/stereo/odom: 10 of "), Not(HasSubstr("/stereo/odom: 2 of "))));
}

TEST(DdsTool, OneTopicMayHaveTheCameraInfoOfBothCameras) {
  Peer live{tool("live ros2:/stereo --poses none --listen :0", 5)};
  Peer cameras{bare_peer("pairs /stereo reliable 256x160 10 4 1000 shared")};
  EXPECT_THAT(all_of(live), HasSubstr("CameraInfo of both cameras on /stereo/camera_info"));
}

TEST(DdsTool, WhatItWaitsForItSays) {
  Peer cameras{bare_peer("pairs /stereo reliable 64x48 5 6")};
  Peer live{tool("live ros2:/sterep --listen :0", 4)};
  EXPECT_THAT(all_of(live),
              AllOf(HasSubstr("images have no publisher"), HasSubstr("Elsewhere there are: /stereo/left/image_rect")));
}

TEST(DdsTool, TopicsOfAnotherTypeAreNamed) {
  const auto node{open_node({.name = "other"})};
  static_cast<void>(node->sink().add(grid_channel("/wrong/left/image_rect", false)));
  Peer cameras{bare_peer("pairs /stereo reliable 64x48 5 8")};
  Peer images{tool("live ros2:/wrong --listen :0", 4)};
  Peer poses{tool("live ros2:/stereo --poses /stereo/left/image_rect --listen :0", 6)};
  EXPECT_THAT(all_of(images), HasSubstr("/wrong/left/image_rect is of type nav_msgs/msg/OccupancyGrid"));
  EXPECT_THAT(all_of(poses), HasSubstr("It is of type sensor_msgs/msg/Image, not nav_msgs/msg/Odometry"));
}

TEST(DdsTool, WithoutItsLibraryItSaysWhatIsMissing) {
  setenv("STEREOGRID_DDS_LIBRARY", "/nowhere/libstereogrid_dds.so", 1);
  Peer run{tool("run " + scene + " --out never --ros2")};
  EXPECT_THAT(all_of(run),
              AllOf(HasSubstr("/nowhere/libstereogrid_dds.so could not be loaded"), HasSubstr("stereogrid-dds")));
  EXPECT_EQ(run.exit_code(), 75);
  EXPECT_FALSE(fs::exists("never"));
  unsetenv("STEREOGRID_DDS_LIBRARY");
}

TEST(DdsTool, LyricalReadsNodesAsJazzyDoes) {
  for (const char* words : {"export ROS_DISTRO=lyrical; ", ""}) {
    const std::string live{"live " + scene + " --loop --ros2 --listen :0"};
    Peer node{words + tool(*words == '\0' ? live + " --ros2-distro lyrical" : live, 6)};
    Peer peer{bare_peer("node jazzy / stereo_grid rt/stereo_grid/occupancy_grid 10")};
    EXPECT_THAT(peer.rest(), Contains(StartsWith("node / stereo_grid writes"))) << words;
  }
}

TEST(DdsTool, OptionsThatDoNotFitAreRefused) {
  for (const char* words :
       {"live ros2:/a --loop", "live ros2:/a --poses file", "live ros2:/a --disparities d",
        "live ros2:/a --ros2-node 1", "live ros2:/a --ros2-camera-at 1,0,0",
        "live scene:street --ros2 --ros2-camera-at 1,0,0", "live ros2:/a --poses tf --ros2-camera-at 1,x,0",
        "live ros2:/a --ros2-frames odom", "live ros2:/a --poses tf --ros2-frames odom,base_link",
        "live scene:street --ros2 --ros2-frames odom,odom", "live ros2:/a --ros2-remap x",
        "live scene:street --ros2-node a", "live scene:street --ros2 --ros2-sim-time",
        "run scene:street --out never --ros2-leave-tf"}) {
    Peer live{tool(words, 10)};
    EXPECT_THAT(all_of(live), HasSubstr("stereogrid: ")) << words;
    EXPECT_EQ(live.exit_code(), 64) << words;
  }
}

}  // namespace
}  // namespace stereogrid::dds::testing
