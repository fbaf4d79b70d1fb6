// SPDX-License-Identifier: Apache-2.0
//
// Messages sent by the node, read by a bare DDS participant with its own types.
#include <signal.h>

#include "support.hpp"

namespace stereogrid::dds::testing {
namespace {

const std::string topic{"/stereo_grid/occupancy_grid"};

std::string grids(const std::string& qos, int count, int seconds = 15) {
  return bare_peer("grids rt" + topic + " " + qos + " " + std::to_string(count) + " " + std::to_string(seconds));
}

TEST(DdsSend, WhoComesLaterGetsTheLastGrid) {
  const auto node{open_node()};
  const std::uint32_t channel{node->sink().add(grid_channel(topic, true))};
  EXPECT_TRUE(node->sink().wants(channel));
  for (const int offset : {1, 2, 3}) send(node->sink(), channel, some_grid(40, 30, offset));
  for (int i{0}; i < 2; ++i) {  // and who comes after that, too
    Peer peer{grids("reliable transient_local", 2, 2)};
    EXPECT_THAT(peer.rest(), ElementsAre(StartsWith(line_of(some_grid(40, 30, 3)))));
    EXPECT_EQ(peer.exit_code(), 2);  // there was one only
  }
}

TEST(DdsSend, ALargeGridArrivesWhole) {
  const auto node{open_node()};
  const std::uint32_t channel{node->sink().add(grid_channel(topic, true))};
  const auto grid{some_grid(1201, 999, 5)};  // as many bytes as do not fill whole words
  send(node->sink(), channel, grid);
  Peer peer{grids("reliable transient_local", 1)};
  EXPECT_THAT(peer.rest(), ElementsAre(StartsWith(line_of(grid))));
}

TEST(DdsSend, BestEffortSubscribersOfLatchedTopicsGetWhatComes) {
  const auto node{open_node()};
  const std::uint32_t channel{node->sink().add(grid_channel(topic, true))};
  std::jthread sender{[&](const std::stop_token& stop) {
    for (int i{0}; !stop.stop_requested(); ++i) {
      send(node->sink(), channel, some_grid(20, 10, i));
      std::this_thread::sleep_for(std::chrono::milliseconds{50});
    }
  }};
  Peer peer{grids("best_effort volatile", 5)};
  EXPECT_EQ(peer.rest().size(), 5U);
  EXPECT_EQ(peer.exit_code(), 0);
}

TEST(DdsSend, WithoutSubscribersNothingIsWanted) {
  const auto node{open_node()};
  const std::uint32_t channel{node->sink().add(grid_channel(topic, false))};
  EXPECT_FALSE(node->sink().wants(channel));
  Peer peer{grids("reliable volatile", 1)};
  ASSERT_TRUE(becomes([&] { return node->sink().wants(channel); }));
  send(node->sink(), channel, some_grid(4, 3, 9));
  EXPECT_THAT(peer.rest(), ElementsAre(StartsWith(line_of(some_grid(4, 3, 9)))));
  EXPECT_TRUE(becomes([&] { return !node->sink().wants(channel); }));
}

TEST(DdsSend, WhoAsksForMoreThanIsOfferedIsReportedOnce) {
  Warned warned;
  const auto node{open_node({.warn = warned.taker()})};
  const std::uint32_t channel{node->sink().add(grid_channel(topic, false))};
  for (int i{0}; i < 2; ++i) {
    Peer peer{grids("reliable transient_local", 1, 2)};
    EXPECT_TRUE(becomes([&] { return !warned.sentences().empty(); }));
    EXPECT_FALSE(node->sink().wants(channel));
    send(node->sink(), channel, some_grid(4, 3, 9));
    EXPECT_THAT(peer.rest(), IsEmpty());
  }
  EXPECT_THAT(warned.sentences(), ElementsAre(AllOf(HasSubstr("a subscriber of " + topic + " receives nothing"),
                                                    HasSubstr("transient local"))));
}

TEST(DdsSend, ASubscriberThatHangsHoldsNothingUp) {
  using Clock = std::chrono::steady_clock;
  const auto node{open_node()};
  const std::uint32_t channel{node->sink().add(grid_channel(topic, false))};
  Peer peer{"echo $$; exec " STEREOGRID_BARE_PEER " grids rt" + topic + " reliable volatile 1000 6"};
  const pid_t id{std::stoi(peer.line())};
  ASSERT_TRUE(becomes([&] { return node->sink().wants(channel); }));
  send(node->sink(), channel, some_grid(7, 5, 1));
  ASSERT_THAT(peer.line(), StartsWith("grid"));
  kill(id, SIGSTOP);
  constexpr int sent{50};
  const auto begun{Clock::now()};
  for (int i{0}; i < sent; ++i) send(node->sink(), channel, some_grid(700, 500, i));
  EXPECT_LT(Clock::now() - begun, std::chrono::seconds{5});
  kill(id, SIGCONT);
  // then it receives the last ones that are stored
  const std::vector<std::string> received{peer.rest()};
  EXPECT_LT(received.size(), static_cast<std::size_t>(sent));
  for (int i{sent - 10}; i < sent; ++i)
    EXPECT_THAT(received, Contains(StartsWith(line_of(some_grid(700, 500, i))))) << i;
}

TEST(DdsSend, SubscribersComeAndGoAndNoneMissesTheLastGrid) {
  const auto node{open_node()};
  const std::uint32_t channel{node->sink().add(grid_channel(topic, true))};
  for (int i{0}; i < 25; ++i) {
    send(node->sink(), channel, some_grid(400, 400, i));
    Peer peer{grids("reliable transient_local", 1)};
    ASSERT_THAT(peer.rest(), ElementsAre(StartsWith(line_of(some_grid(400, 400, i))))) << i;
  }
}

struct Seen {
  std::vector<std::string> lines;
  int exit_code;
};

Seen seen_by(const std::string& distro) {
  const auto node{open_node({.name = "robot/grid",
                             .remappings = {"occupancy_grid:=/map"},
                             .distro = distro == "humble" ? Distro::humble : Distro::jazzy})};
  static_cast<void>(node->sink().add(grid_channel(topic, true)));
  Peer peer{bare_peer("node " + distro + " /robot grid rt/map 10")};
  std::vector<std::string> lines{peer.rest()};
  return {lines, peer.exit_code()};
}

TEST(DdsSend, ToolsOfRosSeeTheNodeAndWhatItWrites) {
  for (const char* distro : {"humble", "jazzy"}) {
    const Seen seen{seen_by(distro)};
    ASSERT_EQ(seen.exit_code, 0) << distro;
    const std::string writer{seen.lines.at(0)};  // "writer NUMBER TYPE"
    EXPECT_THAT(writer, HasSubstr(" nav_msgs::msg::dds_::OccupancyGrid_"));
    EXPECT_THAT(seen.lines, Contains("node /robot grid writes " + writer.substr(7, 32)));
    EXPECT_THAT(seen.lines, Contains("participant enclave=/;"));
  }
}

/// Lines of a peer that reads names of nodes in the layout of that distribution.
std::vector<std::string> names_for(const std::string& distro, double seconds) {
  Peer peer{bare_peer("node " + distro + " / stereo_grid rt" + topic + " " + std::to_string(seconds))};
  return peer.rest();
}

TEST(DdsSend, NamesOfNodesAreInTheLayoutOfThePeers) {
  const auto node{open_node()};
  static_cast<void>(node->sink().add(grid_channel(topic, true)));
  const auto has_node{Contains(StartsWith("node / stereo_grid writes "))};
  EXPECT_THAT(names_for("humble", 10), has_node) << "no peer is seen yet";
  Peer jazzy{bare_peer("announce jazzy 12")};
  ASSERT_EQ(jazzy.line(), "announced");
  EXPECT_THAT(names_for("jazzy", 10), has_node);
  Peer humble{bare_peer("announce humble 5")};
  ASSERT_EQ(humble.line(), "announced");
  EXPECT_THAT(names_for("humble", 10), has_node) << "tools of Humble fail on the layout of Jazzy";
}

// A node of this kind announces Humble's layout before it sees a peer: no reason for another one to stay there.
TEST(DdsSend, NodesOfItsOwnKindDoNotDecideTheLayout) {
  const auto node{open_node()};
  static_cast<void>(node->sink().add(grid_channel(topic, true)));
  const auto other{open_node({.name = "other"})};
  static_cast<void>(other->sink().add(grid_channel("/stereo_grid/scan", false)));
  EXPECT_THAT(names_for("humble", 10), Contains(StartsWith("node / stereo_grid writes ")));
  Peer jazzy{bare_peer("announce jazzy 5")};
  ASSERT_EQ(jazzy.line(), "announced");
  EXPECT_THAT(names_for("jazzy", 10), Contains(StartsWith("node / stereo_grid writes ")));
}

TEST(DdsSend, TheHashOfTheTypeIsInTheUserData) {
  for (const char* distro : {"humble", "jazzy"}) {
    EXPECT_THAT(seen_by(distro).lines,
                Contains("endpoint typehash=RIHS01_8d348150c12913a31ee0ec170fbf25089e4745d17035792a1ba94d6f0bc0cfc7;"));
  }
}

TEST(DdsSend, OnThisMachineOnlyWhereTheVariableSaysSo) {
  unsetenv("CYCLONEDDS_URI");
  setenv("ROS_LOCALHOST_ONLY", "1", 1);
  const auto node{open_node()};
  const std::uint32_t channel{node->sink().add(grid_channel(topic, true))};
  send(node->sink(), channel, some_grid(4, 3, 1));
  setenv("CYCLONEDDS_URI",
         "<CycloneDDS><Domain><General><Interfaces><NetworkInterface address=\"127.0.0.1\"/></Interfaces></General>"
         "<Discovery><ParticipantIndex>auto</ParticipantIndex><Peers><Peer address=\"127.0.0.1\"/></Peers></Discovery>"
         "</Domain></CycloneDDS>",
         1);
  Peer peer{grids("reliable transient_local", 1)};
  EXPECT_EQ(peer.rest().size(), 1U);
}

/// Lines of a reader in this machine's loopback without multicast, which contacts the first participants one by one.
std::vector<std::string> grids_without_multicast() {
  setenv("CYCLONEDDS_URI",
         "<CycloneDDS><Domain><General><Interfaces><NetworkInterface address=\"127.0.0.1\"/></Interfaces>"
         "<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
         "<Peers><Peer address=\"127.0.0.1\"/></Peers></Discovery></Domain></CycloneDDS>",
         1);
  Peer peer{grids("reliable transient_local", 1, 3)};
  return peer.rest();
}

TEST(DdsSend, StaticPeersAreFoundWithoutMulticast) {
  setenv("CYCLONEDDS_URI",
         "<CycloneDDS><Domain><General><Interfaces><NetworkInterface address=\"127.0.0.1\"/></Interfaces>"
         "<AllowMulticast>false</AllowMulticast></General></Domain></CycloneDDS>",
         1);
  setenv("ROS_STATIC_PEERS", "127.0.0.1", 1);
  const auto node{open_node()};
  const std::uint32_t channel{node->sink().add(grid_channel(topic, true))};
  send(node->sink(), channel, some_grid(4, 3, 1));
  EXPECT_THAT(grids_without_multicast(), ::testing::SizeIs(1));
}

TEST(DdsSend, NobodyIsFoundWhereDiscoveryIsOff) {
  unsetenv("CYCLONEDDS_URI");
  setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF", 1);
  const auto node{open_node()};
  const std::uint32_t channel{node->sink().add(grid_channel(topic, true))};
  send(node->sink(), channel, some_grid(4, 3, 1));
  EXPECT_THAT(grids_without_multicast(), IsEmpty());
}

}  // namespace
}  // namespace stereogrid::dds::testing
