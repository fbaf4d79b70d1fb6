// SPDX-License-Identifier: Apache-2.0
//
// Peers of Fast DDS.
#include "stereogrid/messages/cdr.hpp"
#include "support.hpp"

namespace stereogrid::dds::testing {
namespace {

using messages::nav_msgs::OccupancyGrid;

std::string fast_peer(const std::string& words) {
  return "exec timeout 60 " STEREOGRID_FAST_PEER " " + words;
}

TEST(DdsFast, WhoComesLaterGetsTheLastGrid) {
  const auto node{open_node()};
  const std::uint32_t channel{node->sink().add(grid_channel("/map", true))};
  for (const int offset : {1, 2}) send(node->sink(), channel, some_grid(403, 401, offset));
  for (const char* qos : {"reliable transient_local", "reliable transient_local"}) {
    Peer peer{fast_peer("grids rt/map " + std::string{qos} + " 1 15")};
    EXPECT_THAT(peer.rest(), ElementsAre(StartsWith(line_of(some_grid(403, 401, 2)))));
  }
}

TEST(DdsFast, BestEffortSubscribersGetWhatComes) {
  const auto node{open_node()};
  const std::uint32_t channel{node->sink().add(grid_channel("/map", false))};
  Peer peer{fast_peer("grids rt/map best_effort volatile 1 15")};
  ASSERT_TRUE(becomes([&] { return node->sink().wants(channel); }));
  const std::jthread sender{[&](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      send(node->sink(), channel, some_grid(21, 11, 3));
      std::this_thread::sleep_for(std::chrono::milliseconds{50});
    }
  }};
  EXPECT_THAT(peer.rest(), ElementsAre(StartsWith(line_of(some_grid(21, 11, 3)))));
}

TEST(DdsFast, WhoAsksForMoreThanIsOfferedIsReported) {
  Warned warned;
  const auto node{open_node({.warn = warned.taker()})};
  const std::uint32_t channel{node->sink().add(grid_channel("/map", false))};
  Peer peer{fast_peer("grids rt/map reliable transient_local 1 3")};
  EXPECT_TRUE(becomes([&] { return !warned.sentences().empty(); }));
  EXPECT_FALSE(node->sink().wants(channel));
  EXPECT_THAT(peer.rest(), IsEmpty());
  EXPECT_THAT(warned.sentences(), ElementsAre(HasSubstr("transient local")));
}

TEST(DdsFast, ItsGridsComeToUs) {
  for (const char* reliability : {"best_effort", "reliable"}) {
    std::mutex mutex;
    std::vector<std::string> lines;
    const auto node{open_node()};
    Peer peer{fast_peer("publish rt/map " + std::string{reliability} + " volatile 401 3")};
    node->subscribe("/map", std::string{OccupancyGrid::type_name}, 5, [&](std::span<const std::byte> cdr) {
      OccupancyGrid grid;
      messages::decode(cdr, grid);
      const std::scoped_lock lock{mutex};
      lines.push_back(line_of(grid));
    });
    peer.rest();
    const std::scoped_lock lock{mutex};
    ASSERT_THAT(lines, ::testing::Not(IsEmpty())) << reliability;
    EXPECT_EQ(lines.front(), line_of(some_grid(401, 401, 1)));
  }
}

}  // namespace
}  // namespace stereogrid::dds::testing
