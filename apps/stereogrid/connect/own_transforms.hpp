// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "stereogrid/dds/node.hpp"
#include "stereogrid/messages/sink.hpp"

namespace stereogrid::app {

/// Publisher of a node of ROS 2 that never publishes a transform beside another node: a frame has one parent.
/// Transforms are withheld for the first second, in which those of others are received, and from the moment on when
/// another node publishes one to the same frame. A warning names it, once for each frame.
class OwnTransforms final : public messages::Sink {
 public:
  explicit OwnTransforms(std::shared_ptr<dds::Node> node);

  std::uint32_t add(const messages::Channel& channel) override;
  [[nodiscard]] bool wants(std::uint32_t channel) const override { return node_->sink().wants(channel); }
  void send(std::uint32_t channel, std::int64_t stamp_ns, std::span<const std::byte> cdr) override;

 private:
  using Clock = std::chrono::steady_clock;
  struct Others {
    std::mutex mutex;
    std::map<std::string, std::string> parents;  ///< parent of each frame that another node publishes
  };
  struct Held {
    std::uint32_t channel;
    std::int64_t stamp_ns;
    std::vector<std::byte> cdr;
  };

  [[nodiscard]] bool is_published_by_others(const std::string& topic, std::span<const std::byte> cdr);

  std::shared_ptr<dds::Node> node_;
  std::shared_ptr<Others> others_{std::make_shared<Others>()};  // the node has it, too
  std::map<std::uint32_t, std::string> transforms_;             // topics by channel
  std::optional<Held> held_;                                    // static transforms of the first second
  std::set<std::string> reported_;
  Clock::time_point opened_{Clock::now()};
};

}  // namespace stereogrid::app
