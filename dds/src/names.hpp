// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "stereogrid/dds/node.hpp"

namespace stereogrid::dds {

/// Names of a node and its topics in ROS.
class Names {
 public:
  /// Throws ConfigError: a name or remapping that is invalid in ROS.
  explicit Names(const NodeOptions& options);

  [[nodiscard]] const std::string& node() const { return node_; }                 ///< "stereo_grid"
  [[nodiscard]] const std::string& node_namespace() const { return namespace_; }  ///< "/", "/robot"
  /// Published name of a topic: below this node instead of /stereo_grid, and remapped.
  [[nodiscard]] std::string topic(std::string_view given) const;
  /// Name of another node's topic: remapped only.
  [[nodiscard]] std::string remapped(const std::string& name) const;

 private:
  [[nodiscard]] std::string below_node(std::string_view name) const;
  void add_remapping(const std::string& text);

  std::string namespace_;
  std::string node_;
  std::vector<std::pair<std::string, std::string>> remappings_;
};

/// "/a/b" is "rt/a/b" in DDS, "pkg/msg/T" is "pkg::msg::dds_::T_".
[[nodiscard]] std::string dds_topic(std::string_view ros_topic);
[[nodiscard]] std::string dds_type(std::string_view ros_type);
/// The inverse of both; empty: no topic of ROS.
[[nodiscard]] std::optional<PublishedTopic> ros_topic(std::string_view dds_topic, std::string_view dds_type);

/// Hash of a type by rosidl's rule (REP 2011, since Iron): "RIHS01_" and the SHA-256 of its type description.
/// `definition`: schema encoding "ros2msg" with bool, byte, numbers, string, and arrays without a bound.
/// Throws InputError: another kind of field.
[[nodiscard]] std::string type_hash(std::string_view ros_type, std::string_view definition);

/// Definition of a type that this library's users subscribe to; "": none of them.
[[nodiscard]] std::string_view definition_of_subscribed(std::string_view ros_type);

}  // namespace stereogrid::dds
