// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../prelude.hpp"
#include "stereogrid/dds/node.hpp"
#include "stereogrid/messages/nav_msgs.hpp"

namespace stereogrid::dds::testing {

using ::testing::AllOf, ::testing::Contains, ::testing::Each, ::testing::ElementsAre, ::testing::HasSubstr,
    ::testing::IsEmpty, ::testing::Not, ::testing::Optional, ::testing::SizeIs, ::testing::StartsWith,
    ::testing::ThrowsMessage;

/// A program beside the test, whose output is read.
class Peer {
 public:
  /// `words`: of a shell.
  explicit Peer(const std::string& words);
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;
  ~Peer();

  /// The next line; "": there is none.
  std::string line();
  /// The lines until its end, and then its exit code.
  std::vector<std::string> rest();
  [[nodiscard]] int exit_code() const { return exit_code_; }

 private:
  FILE* pipe_;
  int exit_code_{-1};
};

/// Its lines until its end.
std::string all_of(Peer& peer);

/// The program with what it says on both streams, ended by one Ctrl-C after `seconds` (a second one would end it at
/// once).
[[nodiscard]] std::string tool(const std::string& words, double seconds = 60);
/// tests/dds/bare_peer.cpp.
[[nodiscard]] std::string bare_peer(const std::string& words);

/// Warnings of a node.
class Warned {
 public:
  [[nodiscard]] std::function<void(const std::string&)> taker();
  [[nodiscard]] std::vector<std::string> sentences() const;

 private:
  struct State {
    std::mutex mutex;
    std::vector<std::string> sentences;
  };
  std::shared_ptr<State> state_{std::make_shared<State>()};
};

/// libstereogrid_dds.so's, as the tool loads it.
[[nodiscard]] std::unique_ptr<Node> open_node(const NodeOptions& options = {});
void check_options(const NodeOptions& options);

/// Within 20 s.
[[nodiscard]] bool becomes(const std::function<bool()>& is_true);

/// Whose cells are (7·index + offset) mod 101.
[[nodiscard]] messages::nav_msgs::OccupancyGrid some_grid(std::uint32_t width, std::uint32_t height, int offset);
/// As bare_peer prints it, but for what follows "at".
[[nodiscard]] std::string line_of(const messages::nav_msgs::OccupancyGrid& grid);
void send(messages::Sink& sink, std::uint32_t channel, const messages::nav_msgs::OccupancyGrid& grid);
[[nodiscard]] messages::Channel grid_channel(const std::string& topic, bool is_latched);

}  // namespace stereogrid::dds::testing
