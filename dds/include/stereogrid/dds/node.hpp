// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "stereogrid/export.hpp"
#include "stereogrid/messages/sink.hpp"

// Interface of libstereogrid_dds.so. A program loads it with dlopen and calls its function `library_function`.

namespace stereogrid::dds {

/// Layout of ros_discovery_info, the source of node names for tools of ROS.
enum class Distro {
  automatic,  ///< layout of the peers; humble where both are present, and until a peer is found
  humble,     ///< endpoint ids of 24 bytes; peers since Iron read a message without nodes
  jazzy       ///< 16 bytes (Iron and later); tools of Humble fail on such a message
};

struct NodeOptions {
  std::string name{"stereo_grid"};        ///< with its namespace, such as "robot/stereo_grid"
  std::vector<std::string> remappings{};  ///< "FROM:=TO"; without a slash in front: below the node
  std::vector<std::string> left_out{};    ///< topics that are not published: "/tf"
  Distro distro{Distro::automatic};
  /// Receives warnings about peers without messages, each once. Called by threads of the network.
  std::function<void(const std::string&)> warn{};
};

struct PublishedTopic {
  std::string name;  ///< "/stereo/left/image_rect"
  std::string type;  ///< "sensor_msgs/msg/Image"
  int publishers{0};
};

/// Receives a message as CDR with its header of 4 bytes. `cdr` is valid until the function returns.
using Take = std::function<void(std::span<const std::byte> cdr)>;

/// A node of ROS 2, based on DDS alone. Functions may be called from any thread, those of the publisher from one at a
/// time.
class STEREOGRID_EXPORT Node {
 public:
  Node() = default;
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;
  virtual ~Node() = default;

  /// Publisher of the node. Latched channels: reliable, transient local, depth 1; others: reliable, volatile, depth 10.
  /// The name of this node replaces "/stereo_grid" in topics. Its functions throw DeviceError.
  [[nodiscard]] virtual messages::Sink& sink() = 0;
  /// Topics of other publishers discovered so far, sorted by name.
  [[nodiscard]] virtual std::vector<PublishedTopic> topics() const = 0;
  /// Subscribes as best effort and volatile, which matches every publisher; `is_latched`: reliable and transient local,
  /// as for /tf_static. One thread calls `take` for all subscriptions; its exceptions are passed to `warn`.
  /// Throws DeviceError.
  virtual void subscribe(const std::string& topic, const std::string& type, std::size_t depth, Take take,
                         bool is_latched = false) = 0;
  /// Ends all subscriptions of a topic. One more call of `take` may follow.
  virtual void unsubscribe(const std::string& topic) = 0;
};

struct Library {
  const char* version;  ///< version of stereogrid, which must be equal on both sides
  std::size_t sizes;    ///< interface_sizes() of the library
  /// Throws ConfigError: a name, remapping or variable of ROS is invalid.
  void (*check)(const NodeOptions& options);
  /// Opens a node in the domain ROS_DOMAIN_ID. ROS_LOCALHOST_ONLY, ROS_AUTOMATIC_DISCOVERY_RANGE and ROS_STATIC_PEERS
  /// limit its peers. Throws as check(); DeviceError: no network.
  std::unique_ptr<Node> (*open)(const NodeOptions& options);
};

constexpr const char* library_function{"stereogrid_dds_library_4"};

/// Number that depends on the structures of the interface.
constexpr std::size_t interface_sizes() {
  return (sizeof(NodeOptions) * 1024 + sizeof(PublishedTopic)) * 1024 + sizeof(messages::Channel);
}

}  // namespace stereogrid::dds
