// SPDX-License-Identifier: Apache-2.0
//
// Poses in bags that cannot be used: they are dropped, counted and reported.
#include "bag_drive.hpp"
#include "stereogrid/messages/nav_msgs.hpp"

namespace stereogrid::app::testing {
namespace {

using messages::geometry_msgs::Quaternion;
using messages::nav_msgs::Odometry;
using messages::tf2_msgs::TFMessage;

constexpr double yaw_step_rad{0.02};
constexpr double infinite{std::numeric_limits<double>::infinity()};

Quaternion turned(std::size_t frame, double length) {
  const double half_rad{yaw_step_rad * static_cast<double>(frame) / 2};
  return {0, 0, length * std::sin(half_rad), length * std::cos(half_rad)};
}

class BagPoses : public Bags {
 protected:
  /// The drive with a message of odometry for each image.
  static std::vector<Entry> with_odometry(const std::function<void(std::size_t frame, Odometry&)>& spoil) {
    std::vector<Entry> all{entries({})};
    for (std::size_t i{0}; i < frames; ++i) {
      Odometry message;
      message.header = header(stamp_of(i));
      message.pose.pose.position.x = 0.5 * static_cast<double>(i);
      message.pose.pose.orientation = turned(i, 1);
      spoil(i, message);
      all.push_back(entry("/odom", start_ns + stamp_of(i), message));
    }
    return all;
  }
  static void cut(std::vector<Entry>& all, const std::string& topic, std::size_t bytes) {
    for (Entry& one : all) {
      if (one.topic == topic) one.data.resize(bytes);
    }
  }
  static std::vector<double> yaws_rad() {
    std::vector<double> yaws;
    for (const Json& line : lines_of(out())) yaws.push_back(line["pose"]["yaw_rad"].get<double>());
    return yaws;
  }
  /// Both commands report it; the run finds its poses in the images.
  static void expect_none_used(const std::vector<Entry>& content, const std::string& reason,
                               const std::string& source = "/odom (nav_msgs/Odometry)") {
    const std::string said{source + ": " + reason};
    write_mcap(bag(), content);
    const Outcome info{run_tool({"info", bag()})};
    EXPECT_EQ(info.exit_code, 0) << info.errors;
    EXPECT_THAT(info.output, AllOf(HasSubstr("problem"), HasSubstr(said), HasSubstr("none: visual odometry")));
    const Outcome run{run_bag(bag(), {})};
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    EXPECT_THAT(run.errors, AllOf(HasSubstr("warning"), HasSubstr(said)));
    EXPECT_EQ(json_of(out() / "run.json").at("input").at("poses"), "odometry");
    const Outcome asked{run_bag(bag(), {"--poses", "file"})};
    EXPECT_EQ(asked.exit_code, 65);
    EXPECT_THAT(asked.errors, HasSubstr("no poses to be used: " + source + ", " + reason));
  }
};

TEST_F(BagPoses, WithQuaternionsOfAnotherLengthAreDropped) {
  for (const auto& [length, said] : {std::pair{0.5, "length 0.5"},
                                     {0.0, "length 0 "},
                                     {2.0, "length 2 "},
                                     {0.985, "length 0.985"},
                                     {1.015, "length 1.015"}}) {
    const double of_all{length};
    expect_none_used(
        with_odometry([&](std::size_t i, Odometry& one) { one.pose.pose.orientation = turned(i, of_all); }),
        "4 of 4 poses are dropped: 4 with a quaternion of " + std::string{said});
  }
}

TEST_F(BagPoses, WithNumbersThatAreNotFiniteAreDropped) {
  const std::pair<std::function<void(Odometry&)>, const char*> ways[]{
      {[](Odometry& one) { one.pose.pose.orientation.x = std::nan(""); }, "4 not finite"},
      {[](Odometry& one) { one.pose.pose.orientation.w = infinite; }, "4 not finite"},
      {[](Odometry& one) { one.pose.pose.position.x = std::nan(""); }, "4 not finite"},
      {[](Odometry& one) { one.pose.pose.position.y = -infinite; }, "4 not finite"},
      {[](Odometry& one) { one.pose.pose.position.y = 1e200; }, "4 with a position above 100 million m"}};
  for (const auto& [spoil, said] : ways) {
    expect_none_used(with_odometry([&](std::size_t, Odometry& one) { spoil(one); }),
                     "4 of 4 poses are dropped: " + std::string{said});
  }
}

TEST_F(BagPoses, InMessagesThatAreCutShortAreCounted) {
  std::vector<Entry> all{with_odometry([](std::size_t, Odometry&) {})};
  for (const std::size_t bytes : {100U, 4U, 0U}) {
    cut(all, "/odom", bytes);
    expect_none_used(all, "4 of 4 poses are dropped: 4 cannot be decoded");
  }
}

TEST_F(BagPoses, OfAQuaternionNearlyOfLengthOneAreNormalised) {
  write_mcap(bag(), with_odometry([](std::size_t i, Odometry& one) { one.pose.pose.orientation = turned(i, 1.009); }));
  const Outcome outcome{run_bag(bag(), {})};
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_THAT(outcome.errors, Not(HasSubstr("dropped")));
  const std::vector<double> yaws{yaws_rad()};
  for (std::size_t i{0}; i < frames; ++i) EXPECT_NEAR(yaws[i], yaw_step_rad * static_cast<double>(i), 1e-9);
}

TEST_F(BagPoses, SomeDroppedLeaveTheOthers) {
  write_mcap(bag(), with_odometry([](std::size_t i, Odometry& one) {
               if (i == 1) one.pose.pose.orientation = turned(i, 0.5);
               if (i == 2) one.pose.pose.position.x = std::nan("");
             }));
  const char* const said{
      "/odom (nav_msgs/Odometry): 2 of 4 poses are dropped: 1 not finite (NaN or infinity), 1 with a quaternion of "
      "length 0.5 (allowed 0.99 to 1.01). The others are used, interpolated over short gaps."};
  const Outcome outcome{run_bag(bag(), {})};
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_THAT(outcome.errors, HasSubstr(said));
  const std::vector<double> yaws{yaws_rad()};
  for (std::size_t i{0}; i < frames; ++i) EXPECT_NEAR(yaws[i], yaw_step_rad * static_cast<double>(i), 1e-9);
  const Outcome info{run_tool({"info", bag()})};
  EXPECT_THAT(info.output, AllOf(HasSubstr(said), HasSubstr("poses        /odom (nav_msgs/Odometry)")));
}

TEST_F(BagPoses, DroppedAtTheEndAreNamedWhereTheyAreMissed) {
  write_mcap(bag(), with_odometry([](std::size_t i, Odometry& one) {
               if (i >= 2) one.pose.pose.orientation = {0, 0, 0, 0};
             }));
  const Outcome outcome{run_bag(bag(), {})};
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_THAT(outcome.errors,
              AllOf(HasSubstr("/odom (nav_msgs/Odometry), 2 of 4 poses are dropped: 2 with a quaternion"),
                    HasSubstr("1 of 4 images have no pose: they are from before the first or after the last one")));
}

TEST_F(BagPoses, ThatContradictEachOtherAreCounted) {
  std::vector<Entry> all{with_odometry([](std::size_t, Odometry&) {})};
  for (const Entry& one : with_odometry([](std::size_t i, Odometry&pose) { pose.pose.pose.position.y = i == 1; })) {
    if (one.topic == "/odom") all.push_back(one);
  }
  write_mcap(bag(), all);
  EXPECT_THAT(run_tool({"info", bag()}).output,
              HasSubstr("1 of 8 poses are dropped: 1 with the stamp of another pose"));
}

/// Transforms of a tree: those of wheels are never looked at.
std::vector<Entry> with_tf(std::vector<Entry> all, const char* parent, const char* child, double length) {
  for (std::size_t i{0}; i < frames; ++i) {
    TFMessage message{
        {transform("base_link", "wheel", {}, {0, 0, 0, 0}), transform(parent, child, {}, turned(i, length))}};
    message.transforms[1].header.stamp = header(static_cast<std::int64_t>(i) * step_ns).stamp;
    all.push_back(entry("/tf", start_ns + static_cast<std::int64_t>(i) * step_ns, message));
  }
  return all;
}

TEST_F(BagPoses, OfTfAreTheOnesLookedAt) {
  write_mcap(bag(), with_tf(entries({}), "odom", "base_link", 1));
  const Outcome outcome{run_bag(bag(), {})};
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_THAT(outcome.errors, AllOf(HasSubstr("/tf (odom → base_link)"), Not(HasSubstr("dropped"))));
  expect_none_used(with_tf(entries({}), "odom", "base_link", 0.5),
                   "4 of 4 poses are dropped: 4 with a quaternion of length 0.5", "/tf (odom → base_link)");
}

TEST_F(BagPoses, OfTheVehicleAreMovedToTheCamera) {
  std::vector<Entry> all{with_odometry([](std::size_t i, Odometry& message) {
    message.pose.pose.position.x = 0;
    message.pose.pose.orientation = turned(i, 1);
    message.child_frame_id = "base_link";
  })};
  all.push_back(
      entry("/tf_static", start_ns, TFMessage{{transform("base_link", header(0).frame_id, {0.9, 0, 1.2}, ahead)}}));
  write_mcap(bag(), all);
  const Outcome outcome{run_bag(bag(), {})};
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_THAT(outcome.errors, HasSubstr("moved from base_link to the left camera by /tf_static (0.90 m ahead, 0.00 m"));
  const auto lines = lines_of(out());
  const double yaw_rad{yaw_step_rad * (frames - 1)};
  EXPECT_NEAR(lines.back()["pose"]["x_m"].get<double>(), 0.9 * (std::cos(yaw_rad) - 1), 1e-4);
  EXPECT_NEAR(lines.back()["pose"]["y_m"].get<double>(), 0.9 * std::sin(yaw_rad), 1e-4);
}

TEST_F(BagPoses, WithoutTheTransformTheOthersAreNamed) {
  write_mcap(bag(), with_tf(entries({}), "odom", "base_footprint", 1));
  const char* const said{"/tf (odom → base_link) is not there, only base_link → wheel, odom → base_footprint"};
  EXPECT_THAT(run_tool({"info", bag()}).output, HasSubstr(said));
  EXPECT_THAT(run_bag(bag(), {}).errors, HasSubstr(said));
}

TEST_F(BagPoses, OverALongGapThereAreNone) {
  std::vector<Entry> all{with_odometry([](std::size_t, Odometry&) {})};
  std::erase_if(all, [](const Entry& one) { return one.topic == "/odom"; });
  for (const std::int64_t ms : {-3200, -3100, -3000, -2900, -2800, -2700, -2600, 50, 150, 250, 350}) {
    Odometry message;
    message.header = header(ms * 1'000'000);
    if (ms < 0) message.header.stamp = {-4, static_cast<std::uint32_t>(4'000'000'000 + ms * 1'000'000)};
    message.pose.pose.orientation.w = 1;
    all.push_back(entry("/odom", start_ns + ms * 1'000'000, message));
  }
  write_mcap(bag(), all);
  const Outcome outcome{run_bag(bag(), {})};
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_THAT(outcome.errors, AllOf(HasSubstr("/odom (nav_msgs/Odometry): 1 of 4 images have no pose"),
                                    HasSubstr("gaps of up to 2.65 s between the poses (interpolated up to 1 s)")));
  EXPECT_THAT(lines_of(out())[0]["status"].dump(), HasSubstr("pose_missing"));
  EXPECT_THAT(lines_of(out())[1]["status"].dump(), Not(HasSubstr("pose_missing")));
}

}  // namespace
}  // namespace stereogrid::app::testing
