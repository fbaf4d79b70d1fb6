// SPDX-License-Identifier: Apache-2.0
//
// Depth and disparities from the network give the grids of the same recording as a bag. A bag that is played to the
// network and recorded at the same time.
#include "../app/bags/depth_bags.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/mcap/bag.hpp"
#include "stereogrid/messages/nav_msgs.hpp"
#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

using dds::testing::all_of, dds::testing::bare_peer, dds::testing::Peer, dds::testing::tool;
using Entries = std::vector<Entry>;

/// Messages of one instant: the first of each topic.
Entries at(const Entries& entries, std::int64_t stamp_ns) {
  Entries first;
  for (const Entry& one : entries) {
    if (std::ranges::find(first, one.topic, &Entry::topic) == first.end()) first.push_back(one);
  }
  const auto sec{static_cast<std::int32_t>(stamp_ns / 1'000'000'000)};
  const auto nanosec{static_cast<std::uint32_t>(stamp_ns % 1'000'000'000)};
  for (Entry& one : first) {  // each message begins with its header
    one.log_ns = stamp_ns;
    std::memcpy(&one.data[4], &sec, sizeof sec);
    std::memcpy(&one.data[8], &nanosec, sizeof nanosec);
  }
  return first;
}

std::int64_t instant_of(std::size_t frame) {
  return 1'000'000'000'000 + static_cast<std::int64_t>(frame) * step_ns;
}

/// Publishes the messages of one instant again and again, with stamps that grow.
class Player {
 public:
  explicit Player(Entries entries)
      : thread_{[this, entries = std::move(entries)](const std::stop_token& stop) {
          for (std::size_t i{0}; !stop.stop_requested(); ++i) {
            for (const Entry& one : at(entries, instant_of(i))) send(one);
            std::this_thread::sleep_for(std::chrono::nanoseconds{step_ns});
          }
        }} {}

 private:
  void send(const Entry& one) {
    static std::set<std::string> types;  // with static lifetime
    const auto [channel, is_new]{channels_.try_emplace(one.topic)};
    if (is_new) channel->second = node_->sink().add({one.topic, *types.insert(one.type).first, ""});
    node_->sink().send(channel->second, one.log_ns, one.data);
  }

  std::unique_ptr<dds::Node> node_{dds::testing::open_node({.name = "camera_driver"})};
  std::map<std::string, std::uint32_t> channels_;
  std::jthread thread_;
};

std::string live(const std::string& words, int seconds) {
  return tool("live " + words + " --poses none --listen :0", seconds);
}

class DdsDepth : public DepthBags {
 protected:
  static messages::sensor_msgs::CompressedImage packed() {
    const messages::sensor_msgs::Image plain_depth{millimetres()};
    Image<std::uint16_t> values{160, 100};
    std::memcpy(values.data(), plain_depth.data.data(), plain_depth.data.size());
    io::write_png(*folder / "depth.png", values);
    const std::string png{text_of(*folder / "depth.png")};
    messages::sensor_msgs::CompressedImage message_of;
    message_of.format = "16UC1; compressedDepth png";
    message_of.data.resize(12);
    message_of.data.insert(message_of.data.end(), png.begin(), png.end());
    return message_of;
  }

  /// Grids of every frame, whatever its stamp.
  static std::vector<std::vector<std::int8_t>> grids_of(const std::string& source, const std::string& words,
                                                        std::string& said) {
    const fs::path recording{*folder / "recording.mcap"};
    fs::remove(recording);
    Peer tool{live(source + " --mcap " + recording.string() + words, 6)};
    said = all_of(tool);
    std::vector<std::vector<std::int8_t>> grids;
    const auto results{mcap::open_bag(recording)};
    const auto cursor{results->messages({.topics = {"/stereo_grid/observed_grid"}})};
    while (const mcap::Message* const message{cursor->next()}) {
      messages::nav_msgs::OccupancyGrid grid;
      messages::decode(message->data, grid);
      grids.push_back(std::move(grid.data));
    }
    return grids;
  }

  /// The network's messages and the same in a bag, each with the SOURCE's first frames.
  static void expect_same_grids(const Entries& entries, const std::string& found, const std::string& source,
                                const std::string& words = "") {
    constexpr std::size_t compared{4};
    Entries all;
    for (std::size_t i{0}; i < 2 * compared; ++i)
      std::ranges::copy(at(entries, instant_of(i)), std::back_inserter(all));
    write_mcap(bag(), all);
    std::string said;
    const auto of_bag{grids_of(bag().string(), words, said)};
    ASSERT_GE(of_bag.size(), compared) << said;
    const Player player{entries};
    const auto of_network{grids_of(source, words, said)};
    ASSERT_GE(of_network.size(), compared) << said;
    EXPECT_THAT(said, HasSubstr(found));
    for (std::size_t i{0}; i < compared; ++i) EXPECT_EQ(of_network[i], of_bag[i]) << i;
    EXPECT_TRUE(std::ranges::any_of(of_bag[0], [](std::int8_t value) { return value > 50; }));
  }
};

TEST_F(DdsDepth, InMetresIsFoundByItsName) {
  expect_same_grids(entries_of("/camera/left/image_rect", "/camera/depth/depth_registered", metres()),
                    "/camera/left/image_rect and depth of /camera/depth/depth_registered", "ros2:/camera");
}

TEST_F(DdsDepth, InMillimetresIsFoundByItsEncoding) {
  expect_same_grids(entries_of("/camera/rgb/image_raw", "/camera/stereo/image_raw", millimetres(), false),
                    "/camera/rgb/image_raw and depth of /camera/stereo/image_raw", "ros2:/camera");
}

TEST_F(DdsDepth, MayBeCompressed) {
  expect_same_grids(
      entries_of("/camera/infra1/image_rect_raw", "/camera/depth/image_rect_raw/compressedDepth", packed(), false),
      "depth of /camera/depth/image_rect_raw/compressedDepth", "ros2:/camera");
}

TEST_F(DdsDepth, MayBeDisparities) {
  expect_same_grids(entries_of("/camera/left/image_rect", "/camera/disparity", disparities()),
                    "/camera/left/image_rect and disparities of /camera/disparity", "ros2:/camera");
}

TEST_F(DdsDepth, MayBeNamed) {
  expect_same_grids(entries_of("/a/images", "/b/measured", millimetres(), false), "/a/images and depth of /b/measured",
                    "ros2:/a", " --left-topic /a/images --right-topic /b/measured");
}

// A bar across free ground, 3 m ahead. It comes before the images of its instant.
TEST_F(DdsDepth, GridsOfTheCameraAreFused) {
  const auto entries_with = [](std::int8_t value) {
    messages::nav_msgs::OccupancyGrid grid;
    grid.header = header(0);
    grid.info.resolution = 0.5F;
    grid.info.width = 2;
    grid.info.height = 8;
    grid.info.origin.position = {3, -2, 0};
    grid.data.assign(16, value);
    Entries entries{entries_of("/camera/left/image_rect", "/camera/depth/depth_registered", metres())};
    entries.insert(entries.begin(), entry("/camera/occupancy", start_ns, grid));
    return entries;
  };
  const auto occupied_with = [&](std::int8_t value) {
    std::string output;
    write_mcap(bag(), at(entries_with(value), instant_of(0)));
    const auto grids{grids_of(bag().string(), " --fuse grids", output)};
    EXPECT_FALSE(grids.empty()) << output;
    return grids.empty() ? 0 : std::ranges::count_if(grids[0], [](std::int8_t cell) { return cell > 50; });
  };
  EXPECT_GT(occupied_with(100), occupied_with(-1) + 10);
  expect_same_grids(entries_with(100), "grids of /camera/occupancy", "ros2:/camera", " --fuse grids");
}

TEST_F(DdsDepth, GridsWithoutAPlaceAreNotGuessed) {
  Entries entries{entries_of("/camera/left/image_rect", "/camera/depth/depth_registered", metres())};
  messages::nav_msgs::OccupancyGrid grid;
  grid.header = header(0);
  grid.header.frame_id = "map";
  grid.info.resolution = 0.5F;
  grid.info.width = grid.info.height = 1;
  grid.data = {100};
  entries.push_back(entry("/camera/occupancy", start_ns, grid));
  const Player player{entries};
  Peer tool{live("ros2:/camera --fuse grids", 5)};
  EXPECT_THAT(all_of(tool), HasSubstr("stereo alone: /tf: map and "));
}

TEST_F(DdsDepth, WithoutImagesIsNamed) {
  Entries entries{entries_of("/camera/left/image_rect", "/camera/disparity", disparities())};
  std::erase_if(entries, [](const Entry& one) { return one.topic == "/camera/left/image_rect"; });
  const Player player{entries};
  Peer tool{live("ros2:/camera", 4)};
  EXPECT_THAT(all_of(tool), AllOf(HasSubstr("there is depth on /camera/disparity, but images have no publisher"),
                                  HasSubstr("--left-topic TOPIC --right-topic TOPIC")));
}

TEST_F(DdsDepth, OfAnotherCameraIsRefused) {
  Entries entries{entries_of("/camera/color/image_raw", "/camera/depth/image_rect_raw", millimetres(), false)};
  CameraInfo other{info(false)};
  other.k[0] *= 1.4;
  entries.push_back(entry("/camera/depth/camera_info", start_ns, other));
  const Player player{entries};
  Peer tool{live("ros2:/camera", 20)};
  EXPECT_THAT(all_of(tool), HasSubstr("depth is of another camera than /camera/color/image_raw"));
  EXPECT_EQ(tool.exit_code(), 65);
}

TEST_F(DdsDepth, WithoutABaselineInTheDisparitiesSaysWhatItWaitsFor) {
  messages::stereo_msgs::DisparityImage none{disparities()};
  none.t = 0;
  const Player player{entries_of("/camera/left/image_rect", "/camera/disparity", none)};
  Peer tool{live("ros2:/camera", 5)};
  EXPECT_THAT(all_of(tool), HasSubstr("the DisparityImage has f 128 px and T 0 m"));
}

TEST_F(Bags, PlayedToTheNetworkIsWhatIsRecorded) {
  write_mcap(bag(), entries({}));
  const fs::path recording{*folder / "recording.mcap"};
  Peer map{bare_peer("grids rt/stereo_grid/occupancy_grid reliable transient_local 8 40")};
  Peer player{live(bag().string() + " --loop --ros2 --mcap " + recording.string(), 5)};
  const std::vector<std::string> came{map.rest()};
  player.rest();

  std::vector<std::string> recorded;
  const auto bag_of_results{mcap::open_bag(recording)};
  const auto cursor{bag_of_results->messages({.topics = {"/stereo_grid/occupancy_grid"}})};
  while (const mcap::Message* const message{cursor->next()}) {
    messages::nav_msgs::OccupancyGrid grid;
    messages::decode(message->data, grid);
    recorded.push_back(dds::testing::line_of(grid));
  }
  ASSERT_THAT(came, SizeIs(8));
  for (const std::string& grid : came) EXPECT_THAT(recorded, Contains(grid.substr(0, grid.find(" at "))));
}

}  // namespace
}  // namespace stereogrid::app::testing
