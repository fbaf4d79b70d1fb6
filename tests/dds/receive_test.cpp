// SPDX-License-Identifier: Apache-2.0
//
// Messages of other participants, received by the node.
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"
#include "support.hpp"

namespace stereogrid::dds::testing {
namespace {

using messages::sensor_msgs::CameraInfo;
using messages::sensor_msgs::Image;

const std::string grid_type{messages::nav_msgs::OccupancyGrid::type_name};

/// Messages of one topic.
template <class M>
class Inbox {
 public:
  Inbox(Node& node, const std::string& topic) {
    node.subscribe(topic, std::string{M::type_name}, 10, [state = state_](std::span<const std::byte> cdr) {
      M message;
      messages::decode(cdr, message);
      const std::scoped_lock lock{state->mutex};
      state->messages.push_back(std::move(message));
    });
  }
  [[nodiscard]] std::vector<M> messages() const {
    const std::scoped_lock lock{state_->mutex};
    return state_->messages;
  }

 private:
  struct State {
    std::mutex mutex;
    std::vector<M> messages;
  };
  std::shared_ptr<State> state_{std::make_shared<State>()};
};

/// As publish_pairs.cpp draws it.
std::uint8_t pixel(const Image& image, std::size_t index, int frame) {
  const auto u{static_cast<int>(index % image.width)}, v{static_cast<int>(index / image.width)};
  return static_cast<std::uint8_t>((u * 2654435761U ^ (v * 40503U) ^ (frame * 7919U)) >> 13);
}

TEST(DdsReceive, FindsWhatOthersPublish) {
  const auto node{open_node()};
  static_cast<void>(node->sink().add(grid_channel("/stereo_grid/occupancy_grid", true)));
  EXPECT_THAT(node->topics(), IsEmpty());  // not what it publishes itself
  Peer peer{bare_peer("pairs /stereo best_effort 64x48 10 2")};
  ASSERT_TRUE(becomes([&] { return node->topics().size() == 7; }));
  const std::vector<PublishedTopic> topics{node->topics()};
  EXPECT_EQ(topics[0].name, "/clock");
  EXPECT_EQ(topics[1].name, "/stereo/left/camera_info");
  EXPECT_EQ(topics[1].type, CameraInfo::type_name);
  EXPECT_EQ(topics[2].name, "/stereo/left/image_rect");
  EXPECT_EQ(topics[2].type, Image::type_name);
  EXPECT_EQ(topics[2].publishers, 1);
  EXPECT_EQ(topics[6].name, "/tf");
  peer.rest();
  EXPECT_TRUE(becomes([&] { return node->topics().empty(); }));
}

TEST(DdsReceive, ImagesOfEveryPublisherArriveWhole) {
  for (const char* reliability : {"best_effort", "reliable"}) {
    const auto node{open_node()};
    const Inbox<Image> images{*node, "/stereo/left/image_rect"};
    const Inbox<CameraInfo> infos{*node, "/stereo/right/camera_info"};
    Peer peer{bare_peer("pairs /stereo " + std::string{reliability} + " 641x367 10 1.5")};
    ASSERT_TRUE(becomes([&] { return !images.messages().empty() && !infos.messages().empty(); })) << reliability;
    std::vector<std::string> pairs{peer.rest()};
    const Image image{images.messages().back()};
    const std::string stamp{std::to_string(image.header.stamp.sec * 1'000'000'000LL + image.header.stamp.nanosec)};
    const auto pair{std::ranges::find(pairs, "pair " + stamp)};
    ASSERT_NE(pair, pairs.end()) << reliability;
    EXPECT_EQ(image.encoding, "mono8");
    ASSERT_EQ(image.data.size(), 641U * 367U);
    const auto frame{static_cast<int>(5 * (pair - pairs.begin()))};
    for (std::size_t i{0}; i < image.data.size(); i += 101) ASSERT_EQ(image.data[i], pixel(image, i, frame)) << i;
    EXPECT_DOUBLE_EQ(infos.messages().back().p[3], -25);
  }
}

TEST(DdsReceive, OneNodeReceivesTheOtherButNotItself) {
  const auto sender{open_node({.name = "a"})};
  const auto receiver{open_node({.name = "b"})};
  const Inbox<messages::nav_msgs::OccupancyGrid> echo{*sender, "/map"};
  const Inbox<messages::nav_msgs::OccupancyGrid> grids{*receiver, "/map"};
  const std::uint32_t channel{sender->sink().add(grid_channel("/map", false))};
  ASSERT_TRUE(becomes([&] { return sender->sink().wants(channel); }));
  send(sender->sink(), channel, some_grid(300, 200, 4));
  ASSERT_TRUE(becomes([&] { return !grids.messages().empty(); }));
  EXPECT_EQ(line_of(grids.messages().front()), line_of(some_grid(300, 200, 4)));
  EXPECT_THAT(echo.messages(), IsEmpty());
}

TEST(DdsReceive, WhatCannotBeReadIsReportedOnceAndTheRestGoesOn) {
  Warned warned;
  const auto sender{open_node({.name = "a"})};
  const auto receiver{open_node({.name = "b", .warn = warned.taker()})};
  const auto count{std::make_shared<std::atomic<int>>(0)};
  receiver->subscribe("/map", grid_type, 10, [count](std::span<const std::byte> cdr) {
    ++*count;
    if (cdr.size() < 100) throw std::runtime_error{"cut off"};
  });
  const std::uint32_t channel{sender->sink().add(grid_channel("/map", false))};
  ASSERT_TRUE(becomes([&] { return sender->sink().wants(channel); }));
  const std::vector<std::byte> damaged(5);
  for (int i{0}; i < 3; ++i) sender->sink().send(channel, 0, damaged);
  send(sender->sink(), channel, some_grid(30, 20, 4));
  EXPECT_TRUE(becomes([&] { return *count == 4; }));
  EXPECT_THAT(warned.sentences(), ElementsAre(AllOf(HasSubstr("/map"), HasSubstr("cut off"))));
}

TEST(DdsReceive, NothingArrivesAfterUnsubscribing) {
  const auto sender{open_node({.name = "a"})};
  const auto receiver{open_node({.name = "b"})};
  const Inbox<messages::nav_msgs::OccupancyGrid> first{*receiver, "/map"};
  const std::uint32_t channel{sender->sink().add(grid_channel("/map", false))};
  ASSERT_TRUE(becomes([&] { return sender->sink().wants(channel); }));
  send(sender->sink(), channel, some_grid(30, 20, 1));
  ASSERT_TRUE(becomes([&] { return first.messages().size() == 1; }));
  receiver->unsubscribe("/map");
  receiver->unsubscribe("/map");
  ASSERT_TRUE(becomes([&] { return !sender->sink().wants(channel); }));
  const Inbox<messages::nav_msgs::OccupancyGrid> second{*receiver, "/map"};
  ASSERT_TRUE(becomes([&] { return sender->sink().wants(channel); }));
  send(sender->sink(), channel, some_grid(30, 20, 2));
  EXPECT_TRUE(becomes([&] { return second.messages().size() == 1; }));
  EXPECT_THAT(first.messages(), SizeIs(1));
}

TEST(DdsReceive, WhatIsNoMessageIsNotSent) {
  const auto node{open_node()};
  const std::uint32_t channel{node->sink().add(grid_channel("/map", true))};
  EXPECT_ANY_THROW(node->sink().send(channel, 0, std::vector<std::byte>(3)));
}

TEST(DdsReceive, NodesComeAndGo) {
  const auto receiver{open_node({.name = "b"})};
  const Inbox<messages::nav_msgs::OccupancyGrid> grids{*receiver, "/map"};
  for (int i{0}; i < 20; ++i) {
    const auto sender{open_node({.name = "a"})};
    const std::uint32_t channel{sender->sink().add(grid_channel("/map", false))};
    ASSERT_TRUE(becomes([&] { return sender->sink().wants(channel); })) << i;
    send(sender->sink(), channel, some_grid(30, 20, i));
    ASSERT_TRUE(becomes([&] { return grids.messages().size() == static_cast<std::size_t>(i + 1); })) << i;
  }
}

}  // namespace
}  // namespace stereogrid::dds::testing
