// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <rclcpp/rclcpp.hpp>
#include <string>

namespace rclcpp_lifecycle {

/// Primary states by the numbers of lifecycle_msgs/msg/State.
class State {
 public:
  explicit State(std::uint8_t id) : id_{id} {}
  [[nodiscard]] std::uint8_t id() const { return id_; }

 private:
  std::uint8_t id_;
};

namespace node_interfaces {

class LifecycleNodeInterface {
 public:
  enum class CallbackReturn : std::uint8_t { SUCCESS = 97, FAILURE = 98, ERROR = 99 };

  virtual ~LifecycleNodeInterface() = default;
  virtual CallbackReturn on_configure(const State&) { return CallbackReturn::SUCCESS; }
  virtual CallbackReturn on_cleanup(const State&) { return CallbackReturn::SUCCESS; }
  virtual CallbackReturn on_shutdown(const State&) { return CallbackReturn::SUCCESS; }
  virtual CallbackReturn on_activate(const State&) { return CallbackReturn::SUCCESS; }
  virtual CallbackReturn on_deactivate(const State&) { return CallbackReturn::SUCCESS; }
};

}  // namespace node_interfaces

/// No rclcpp::Node, as in ROS. A transition that the state does not allow leaves it.
class LifecycleNode : public node_interfaces::LifecycleNodeInterface, private rclcpp::Node {
 public:
  explicit LifecycleNode(const std::string& name, const rclcpp::NodeOptions& options) : rclcpp::Node{name, options} {}

  using rclcpp::Node::add_on_set_parameters_callback;
  using rclcpp::Node::create_generic_publisher;
  using rclcpp::Node::create_subscription;
  using rclcpp::Node::declare_parameter;
  using rclcpp::Node::get_clock;
  using rclcpp::Node::get_logger;
  using rclcpp::Node::get_node_base_interface;
  using rclcpp::Node::get_node_parameters_interface;
  using rclcpp::Node::get_parameter;
  using rclcpp::Node::has_parameter;
  using rclcpp::Node::parameters;
  using rclcpp::Node::set_parameter;

  [[nodiscard]] const State& get_current_state() const { return state_; }
  const State& configure() { return change(unconfigured, inactive, &LifecycleNode::on_configure); }
  const State& cleanup() { return change(inactive, unconfigured, &LifecycleNode::on_cleanup); }
  const State& activate() { return change(inactive, active, &LifecycleNode::on_activate); }
  const State& deactivate() { return change(active, inactive, &LifecycleNode::on_deactivate); }
  const State& shutdown() { return change(state_.id(), finalized, &LifecycleNode::on_shutdown); }

 private:
  static constexpr std::uint8_t unconfigured{1};
  static constexpr std::uint8_t inactive{2};
  static constexpr std::uint8_t active{3};
  static constexpr std::uint8_t finalized{4};

  const State& change(std::uint8_t from, std::uint8_t to, CallbackReturn (LifecycleNode::*callback)(const State&)) {
    if (state_.id() == from && (this->*callback)(state_) == CallbackReturn::SUCCESS) state_ = State{to};
    return state_;
  }

  State state_{unconfigured};
};

}  // namespace rclcpp_lifecycle
