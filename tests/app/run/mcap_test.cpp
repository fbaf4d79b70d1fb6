// SPDX-License-Identifier: Apache-2.0
//
// Recordings of a run. Their messages equal the content of the run's folder: tests/python/test_peers.py.
#include <signal.h>

#include "stereogrid/io/image_file.hpp"
#include "stereogrid/mcap/bag.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/geometry_msgs.hpp"
#include "stereogrid/messages/nav_msgs.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"
#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

/// The messages of a topic, decoded, and when they were logged.
template <class M>
struct Received {
  std::vector<M> messages;
  std::vector<std::uint64_t> log_ns;
};

template <class M>
Received<M> received(const fs::path& file, const std::string& topic) {
  const auto bag{mcap::open_bag(file)};
  const auto cursor{bag->messages({.topics = {topic}})};
  Received<M> all;
  while (const mcap::Message* const one{cursor->next()}) {
    EXPECT_EQ(bag->topics()[one->channel].type, M::type_name) << topic;
    messages::decode(one->data, all.messages.emplace_back());
    all.log_ns.push_back(one->log_time_ns);
  }
  return all;
}

std::map<std::string, std::uint64_t> counts_of(const fs::path& file) {
  std::map<std::string, std::uint64_t> counts;
  const auto bag{mcap::open_bag(file)};
  for (const mcap::Topic& topic : bag->topics()) counts[topic.name] = topic.message_count;
  return counts;
}

constexpr std::size_t frames{5};

/// One recorded run, looked at by all tests of this file.
class RunMcap : public SharedFolderTest {
 protected:
  static void SetUpTestSuite() {
    SharedFolderTest::SetUpTestSuite();
    run_well({"run", small_scene("crossing", "&frames=5"), "--out", run(), "--save-stages", "--predict", "0.5",
              "--mcap", file()});
  }
  static fs::path run() { return folder->path() / "run"; }
  static fs::path file() { return folder->path() / "new" / "run.mcap"; }
  static Words record(const std::string& name, const Words& more = {}) {
    return joined(
        {"run", small_scene("crossing", "&frames=5"), "--out", *folder / name, "--mcap", *folder / (name + ".mcap")},
        more);
  }
};

TEST_F(RunMcap, HasEveryTopicOfEveryFrame) {
  std::map<std::string, std::uint64_t> expected{{"/tf", frames}, {"/tf_static", 1}, {"/diagnostics", 1}};
  for (const char* topic :
       {"occupancy_grid", "observed_grid", "predicted_grid_0_5", "planning_grid", "grid_map", "packed_grid",
        "obstacles", "detections", "obstacle_markers", "disparity", "points", "left/camera_info",
        "left/image_annotated/compressed", "u_disparity/compressed", "scan", "odometry", "status"}) {
    expected[std::string{"/stereo_grid/"} + topic] = frames;
  }
  EXPECT_EQ(counts_of(file()), expected);
  const auto bag{mcap::open_bag(file())};
  for (const mcap::Topic& topic : bag->topics()) {
    EXPECT_EQ(topic.schema_encoding, "ros2msg");
    const bool is_kept{topic.offered_qos_profiles.find("durability: 1") != std::string::npos};
    const bool is_latched{topic.name == "/tf_static" || topic.type == "nav_msgs/msg/OccupancyGrid" ||
                          topic.type == "grid_map_msgs/msg/GridMap" || topic.type == "foxglove_msgs/msg/Grid"};
    EXPECT_EQ(is_kept, is_latched) << topic.name;
  }
}

TEST_F(RunMcap, ThePictureIsTheLeftImageWithTheRoadInBlue) {
  const auto pictures{
      received<messages::sensor_msgs::CompressedImage>(file(), "/stereo_grid/left/image_annotated/compressed")};
  ASSERT_EQ(pictures.messages.size(), frames);
  const std::vector<std::uint8_t>& bytes{pictures.messages.back().data};
  std::ofstream{*folder / "left.jpg", std::ios::binary}.write(reinterpret_cast<const char*>(bytes.data()),
                                                              static_cast<std::streamsize>(bytes.size()));
  const io::RgbImage picture{io::read_rgb(*folder / "left.jpg")};
  ASSERT_EQ(picture.width, 160);
  ASSERT_EQ(picture.height, 100);
  const auto blue_in = [&](int from, int to) {
    int blue{0};
    for (const auto [u, v] : raster(0, picture.width, from, to))
      blue += picture.pixels(3 * u + 2, v) > picture.pixels(3 * u, v) + 60;
    return blue;
  };
  EXPECT_GT(blue_in(60, 100), 160 * 40 / 3) << "the road";
  EXPECT_EQ(blue_in(0, 30), 0) << "the sky";
}

TEST_F(RunMcap, AFolderOfResultsIsNoInput) {
  run_well({"run", small_scene("crossing", "&frames=1"), "--out", *folder / "inside", "--mcap"});
  EXPECT_THAT(errors_of(65, {"info", *folder / "inside"}), HasSubstr("holds results of stereogrid"));
}

TEST_F(RunMcap, ChangesNothingElse) {
  run_well(
      {"run", small_scene("crossing", "&frames=5"), "--out", *folder / "alone", "--save-stages", "--predict", "0.5"});
  expect_equal_runs(*folder / "alone", run());
  EXPECT_EQ(files_in(*folder / "alone"), files_in(run()));
}

TEST_F(RunMcap, OnlyChosenTopics) {
  run_well(record("some", {"--mcap-topics", "occupancy_grid,tf", "--frames", "3:4"}));
  EXPECT_EQ(counts_of(*folder / "some.mcap"),
            (std::map<std::string, std::uint64_t>{{"/stereo_grid/occupancy_grid", 2}, {"/tf", 2}}));
}

TEST_F(RunMcap, HasTheScaleThatWasAskedFor) {
  for (const Words& topics : {Words{}, {"--mcap-topics", "occupancy_grid"}}) {
    const std::string name{topics.empty() ? "scaled" : "scaled_one"};
    run_well(record(name, joined({"--value-scale", "autoware", "--frames", "3:4"}, topics)));
    const auto grids{
        received<messages::nav_msgs::OccupancyGrid>(*folder / (name + ".mcap"), "/stereo_grid/occupancy_grid")};
    ASSERT_EQ(grids.messages.size(), 2U);
    const auto [least, most] = std::ranges::minmax(grids.messages[1].data);
    EXPECT_EQ(least, 1);
    EXPECT_LE(most, 99);
  }
  EXPECT_THAT(errors_of(64, {"run", small_scene("corridor", "&frames=1"), "--out", *folder / "autoware", "--ros2",
                             "--value-scale", "autoware"}),
              HasSubstr("grids would be in the frame odom (allowed map, in which Autoware reads them)"));
}

TEST_F(RunMcap, CountsTheFramesThatWereLeftOut) {
  const fs::path drive{*folder / "drive"};
  run_well({"simulate", small_scene("empty", "&frames=5"), "--out", drive, "--no-truth"});
  std::ofstream{drive / "right" / "000002.png"};
  run_well({"run", drive, "--out", *folder / "left_out", "--mcap", *folder / "left_out.mcap", "--mcap-topics", "status",
            "--frames", "1:"});
  const auto status{
      received<messages::diagnostic_msgs::DiagnosticArray>(*folder / "left_out.mcap", "/stereo_grid/status")};
  ASSERT_EQ(status.messages.size(), 3U);
  std::map<std::string, std::string> values;
  for (const auto& one : status.messages.back().status.front().values) values[one.key] = one.value;
  EXPECT_EQ(values["frames"], "3");
  EXPECT_EQ(values["dropped"], "1");
}

TEST_F(RunMcap, WarnsOnceOfStampsThatMessagesCannotHold) {
  const fs::path drive{*folder / "late"};
  run_well({"simulate", small_scene("empty", "&frames=2"), "--out", drive, "--no-truth"});
  fs::remove(drive / "poses.csv");
  std::ofstream{drive / "times.txt"} << "2500000000.0\n2500000000.1\n";
  const Outcome late{run_well({"run", drive, "--out", *folder / "late_run", "--mcap"})};
  const std::string warning{"messages have no stamps before 1970 or after 2038: 2500000000 s"};
  ASSERT_THAT(late.errors, HasSubstr(warning));
  EXPECT_THAT(late.errors.substr(late.errors.find(warning) + warning.size()), Not(HasSubstr(warning)));
}

TEST_F(RunMcap, EstimatedExtrinsicsArePublished) {
  const fs::path drive{*folder / "pitched"};
  run_well({"simulate", "scene:terrain?kind=bank&at=5&width=320&height=200&frames=6&camera_height=1.2&pitch_deg=8",
            "--out", drive, "--no-truth"});
  edit(drive / "calibration.yaml", "mount.*\n", "");
  run_well({"run", drive, "--out", *folder / "found", "--mcap", *folder / "found.mcap", "--poses", "none"});
  const auto extrinsics{received<messages::tf2_msgs::TFMessage>(*folder / "found.mcap", "/tf_static")};
  ASSERT_EQ(extrinsics.messages.size(), 1U);
  EXPECT_EQ(extrinsics.log_ns[0], 0U);
  EXPECT_NEAR(extrinsics.messages[0].transforms[0].transform.translation.z, 1.2, 0.03);
  ASSERT_EQ(extrinsics.messages[0].transforms.size(), 2U) << "the level camera, too";
  // the image is the camera's, with the road projected back into it
  EXPECT_EQ(counts_of(*folder / "found.mcap")["/stereo_grid/left/image_annotated/compressed"], 6U);
}

TEST_F(RunMcap, RefusesWhatCannotBe) {
  std::ofstream{*folder / "there.mcap"} << "mine";
  for (const Refused& refused : std::vector<Refused>{
           {record("there"), "it is there already"},
           {record("never", {"--resume"}), "--mcap does not support --resume"},
           {record("never", {"--mcap-topics", "occupancy_grid,speed"}),
            "There is no topic \"speed\". There are: occupancy"},
           {{"run", small_scene("empty", "&frames=1"), "--out", *folder / "never", "--mcap-topics", "tf"},
            "Give --mcap FILE, too"}}) {
    expect_refused(refused);
  }
  EXPECT_EQ(text_of(*folder / "there.mcap"), "mine");
  EXPECT_FALSE(fs::exists(*folder / "there"));
  EXPECT_FALSE(fs::exists(*folder / "never"));
}

TEST_F(RunMcap, AFullDiskEndsTheRunAndTheFolderGoesOn) {
  std::string line{"(ulimit -f 2400; " + quoted(STEREOGRID_TOOL)};
  for (const std::string& word : record("full", {"--save-stages", "--predict", "0.5"})) line += " " + quoted(word);
  EXPECT_EQ(shell(line + " 2>" + quoted((*folder / "errors").string()) + ")"), 75);
  EXPECT_THAT(text_of(*folder / "errors"), HasSubstr("full.mcap: cannot be written"));
  EXPECT_FALSE(counts_of(*folder / "full.mcap").empty());
  EXPECT_LT(lines_of(*folder / "full").size(), frames);
  run_well({"run", small_scene("crossing", "&frames=5"), "--out", *folder / "full", "--resume", "--save-stages",
            "--predict", "0.5"});
  expect_equal_runs(*folder / "full", run());
}

TEST_F(RunMcap, AKilledRunLeavesWhatWasRecorded) {
  const fs::path out{*folder / "killed.mcap"};
  Process process{{"run", small_scene("street", "&frames=1000"), "--out", *folder / "killed", "--mcap", out}};
  const auto deadline{std::chrono::steady_clock::now() + std::chrono::seconds{30}};
  std::error_code error;
  while ((!fs::exists(out) || fs::file_size(out, error) < 500'000) && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(std::chrono::milliseconds{5});
  }
  process.send(SIGKILL);
  EXPECT_EQ(process.wait(), 128 + SIGKILL);
  const auto odometry{received<messages::nav_msgs::Odometry>(out, "/stereo_grid/odometry")};
  EXPECT_GT(odometry.messages.size(), 0U);
  EXPECT_LT(odometry.messages.size(), 1000U);
  EXPECT_THAT(mcap::open_bag(out)->damage(), ::testing::SizeIs(::testing::Le(1U)));
}

TEST_F(RunMcap, AnInterruptedRunLeavesAWholeFile) {
  const fs::path out{*folder / "stopped.mcap"};
  Process process{{"run", small_scene("street", "&frames=1000"), "--out", *folder / "stopped", "--mcap", out,
                   "--mcap-topics", "odometry"}};
  wait_for_frames(*folder / "stopped", 1);
  process.send(SIGINT);
  EXPECT_EQ(process.wait(), 128 + SIGINT);
  EXPECT_THAT(mcap::open_bag(out)->damage(), IsEmpty());
  EXPECT_EQ(counts_of(out)["/stereo_grid/odometry"], lines_of(*folder / "stopped").size());
}

}  // namespace
}  // namespace stereogrid::app::testing
