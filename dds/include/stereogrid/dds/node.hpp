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

// What libstereogrid_dds.so offers. A program loads it with dlopen and calls its function `library_function`.

namespace stereogrid::dds {

/// Layout of ros_discovery_info, from which tools of ROS read names of nodes.
enum class Distro {
  automatic,  ///< that of the peers; humble where both are present, and until a peer is seen
  humble,     ///< 24 bytes of an endpoint's number; peers since Iron read a message without nodes
  jazzy       ///< 16 bytes (Iron and later); tools of Humble fail on such a message
};

struct NodeOptions {
  std::string name{"stereo_grid"};        ///< with its namespace, such as "robot/stereo_grid"
  std::vector<std::string> remappings{};  ///< "FROM:=TO"; without a slash in front: below the node
  std::vector<std::string> left_out{};    ///< topics of the sink that are not published: "/tf"
  Distro distro{Distro::automatic};
  /// Takes sentences about peers that do not get messages, each once. Called by threads of the network.
  std::function<void(const std::string&)> warn{};
};

struct PublishedTopic {
  std::string name;  ///< "/stereo/left/image_rect"
  std::string type;  ///< "sensor_msgs/msg/Image"
  int publishers{0};
};

/// Bytes as they came, CDR with its first four bytes; they last until the function returns.
using Take = std::function<void(std::span<const std::byte> cdr)>;

/// A node of ROS 2, made of DDS alone. Functions may be called from any thread, the sink's from one at a time.
class STEREOGRID_EXPORT Node {
 public:
  Node() = default;
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;
  virtual ~Node() = default;

  /// Latched channels become reliable and transient local with depth 1, the others reliable and volatile with depth 10.
  /// A topic "/stereo_grid/…" becomes one of this node's name. Its functions throw DeviceError.
  [[nodiscard]] virtual messages::Sink& sink() = 0;
  /// What others publish at present, as far as it has been found, in the order of the names.
  [[nodiscard]] virtual std::vector<PublishedTopic> topics() const = 0;
  /// Best effort and volatile, which every publisher can serve; `is_latched`: reliable and transient local, as for
  /// /tf_static. One thread calls `take` for all subscriptions; its exceptions are passed to `warn`.
  /// Throws DeviceError.
  virtual void subscribe(const std::string& topic, const std::string& type, std::size_t depth, Take take,
                         bool is_latched = false) = 0;
  /// Ends all subscriptions of a topic. A message that is being taken may still arrive.
  virtual void unsubscribe(const std::string& topic) = 0;
};

struct Library {
  const char* version;  ///< stereogrid's: both sides must be of the same
  std::size_t sizes;    ///< interface_sizes() there
  /// Throws ConfigError: a name or remapping that ROS does not take, one of ROS's variables that makes no sense.
  void (*check)(const NodeOptions& options);
  /// In the domain ROS_DOMAIN_ID; peers as ROS_LOCALHOST_ONLY, ROS_AUTOMATIC_DISCOVERY_RANGE and ROS_STATIC_PEERS
  /// limit them. Throws as check(); DeviceError: no network.
  std::unique_ptr<Node> (*open)(const NodeOptions& options);
};

constexpr const char* library_function{"stereogrid_dds_library_4"};

/// A number that changes with the structures that cross the interface.
constexpr std::size_t interface_sizes() {
  return (sizeof(NodeOptions) * 1024 + sizeof(PublishedTopic)) * 1024 + sizeof(messages::Channel);
}

}  // namespace stereogrid::dds
