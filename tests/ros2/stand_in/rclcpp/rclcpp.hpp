// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <builtin_interfaces/msg/time.hpp>

// The part of rclcpp that the packages in ros2/ use, with the same signatures, in one process: a test passes messages
// and checks publications and logs.

enum rcl_clock_type_t { RCL_SYSTEM_TIME, RCL_ROS_TIME, RCL_STEADY_TIME };

struct rcl_serialized_message_t {
  std::uint8_t* buffer{nullptr};
  std::size_t buffer_length{0};
  std::size_t buffer_capacity{0};
};

namespace rcl_interfaces::msg {

struct IntegerRange {
  std::int64_t from_value{0};
  std::int64_t to_value{0};
  std::uint64_t step{0};
};
struct FloatingPointRange {
  double from_value{0};
  double to_value{0};
  double step{0};
};
struct ParameterDescriptor {
  std::string name;
  std::uint8_t type{0};
  std::string description;
  std::string additional_constraints;
  bool read_only{false};
  bool dynamic_typing{false};
  std::vector<FloatingPointRange> floating_point_range{};
  std::vector<IntegerRange> integer_range{};
};
struct SetParametersResult {
  bool successful{false};
  std::string reason;
};

}  // namespace rcl_interfaces::msg

namespace stand_in {

/// Shared state of all nodes of this process.
struct World {
  struct Published {
    std::string type;
    bool latched{false};
    std::vector<std::vector<std::uint8_t>> messages{};
  };

  std::mutex mutex;
  std::map<std::string, Published> published;
  std::map<std::string, std::function<void(const void*)>> subscribers;
  std::set<std::string> latched_subscribers;
  std::map<std::string, std::size_t> subscriptions;  // subscriptions of other nodes by topic; usually 1
  std::vector<std::string> missing_packages;         // names of message packages
  std::vector<std::string> log;
  bool is_shut_down{false};
  bool publishing_fails{false};
  std::int64_t now_ns{0};                                      // time of all clocks
  std::vector<std::pair<std::string, std::string>> arguments;  // from -p NAME:=TEXT
};
inline World& world() {
  static World all;
  return all;
}

template <class... Arguments>
void log(const char* format, Arguments... arguments) {
  std::array<char, 1000> text{};
  std::snprintf(text.data(), text.size(), format, arguments...);
  const std::scoped_lock lock{world().mutex};
  world().log.emplace_back(text.data());
}

}  // namespace stand_in

#define RCLCPP_INFO(logger, ...) ((void)(logger), stand_in::log(__VA_ARGS__))
#define RCLCPP_WARN(logger, ...) ((void)(logger), stand_in::log(__VA_ARGS__))
#define RCLCPP_ERROR(logger, ...) ((void)(logger), stand_in::log(__VA_ARGS__))
#define RCLCPP_FATAL(logger, ...) ((void)(logger), stand_in::log(__VA_ARGS__))
#define RCLCPP_WARN_THROTTLE(logger, clock, period_ms, ...) \
  ((void)(logger), (void)(clock), (void)(period_ms), stand_in::log(__VA_ARGS__))

namespace rclcpp {

class Logger {};
inline Logger get_logger(const std::string&) {
  return {};
}

class Duration {
 public:
  explicit Duration(std::chrono::nanoseconds duration) : ns_{duration.count()} {}
  [[nodiscard]] std::int64_t nanoseconds() const { return ns_; }

 private:
  std::int64_t ns_;
};

class Time {
 public:
  Time(std::int32_t seconds, std::uint32_t nanoseconds, rcl_clock_type_t)
      : ns_{seconds * std::int64_t{1'000'000'000} + nanoseconds} {}
  explicit Time(std::int64_t nanoseconds, rcl_clock_type_t = RCL_SYSTEM_TIME) : ns_{nanoseconds} {}
  explicit(false) Time(const builtin_interfaces::msg::Time& message, rcl_clock_type_t = RCL_ROS_TIME)
      : Time{message.sec, message.nanosec, RCL_ROS_TIME} {}
  [[nodiscard]] std::int64_t nanoseconds() const { return ns_; }

 private:
  std::int64_t ns_;
};

class Clock {
 public:
  using SharedPtr = std::shared_ptr<Clock>;
  [[nodiscard]] Time now() const { return Time{stand_in::world().now_ns}; }
};

namespace exceptions {

class InvalidParameterValueException : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace exceptions

enum class ParameterType {
  PARAMETER_NOT_SET,
  PARAMETER_BOOL,
  PARAMETER_INTEGER,
  PARAMETER_DOUBLE,
  PARAMETER_STRING,
  PARAMETER_BYTE_ARRAY,
  PARAMETER_BOOL_ARRAY,
  PARAMETER_INTEGER_ARRAY,
  PARAMETER_DOUBLE_ARRAY,
  PARAMETER_STRING_ARRAY
};

class ParameterValue {
 public:
  ParameterValue() = default;
  explicit ParameterValue(bool value) : value_{value} {}
  explicit ParameterValue(int value) : value_{std::int64_t{value}} {}
  explicit ParameterValue(std::int64_t value) : value_{value} {}
  explicit ParameterValue(double value) : value_{value} {}
  explicit ParameterValue(const char* value) : value_{std::string{value}} {}
  explicit ParameterValue(const std::string& value) : value_{value} {}
  explicit ParameterValue(const std::vector<double>& value) : value_{value} {}
  explicit ParameterValue(const std::vector<std::string>& value) : value_{value} {}

  [[nodiscard]] ParameterType get_type() const {
    constexpr std::array types{ParameterType::PARAMETER_NOT_SET,     ParameterType::PARAMETER_BOOL,
                               ParameterType::PARAMETER_INTEGER,     ParameterType::PARAMETER_DOUBLE,
                               ParameterType::PARAMETER_STRING,      ParameterType::PARAMETER_DOUBLE_ARRAY,
                               ParameterType::PARAMETER_STRING_ARRAY};
    return types.at(value_.index());
  }
  template <class T>
  [[nodiscard]] const T& get() const {
    return std::get<T>(value_);
  }

 private:
  std::variant<std::monostate, bool, std::int64_t, double, std::string, std::vector<double>, std::vector<std::string>>
      value_;
};
inline std::string to_string(const ParameterValue& value) {
  return "type " + std::to_string(static_cast<int>(value.get_type()));
}

class Parameter {
 public:
  template <class T>
  Parameter(std::string name, T value) : name_{std::move(name)}, value_{value} {}
  [[nodiscard]] const std::string& get_name() const { return name_; }
  [[nodiscard]] const ParameterValue& get_parameter_value() const { return value_; }
  [[nodiscard]] bool as_bool() const { return value_.get<bool>(); }
  [[nodiscard]] std::int64_t as_int() const { return value_.get<std::int64_t>(); }
  [[nodiscard]] double as_double() const { return value_.get<double>(); }
  [[nodiscard]] std::string as_string() const { return value_.get<std::string>(); }

 private:
  std::string name_;
  ParameterValue value_;
};

class NodeOptions {
 public:
  NodeOptions& parameter_overrides(const std::vector<Parameter>& parameters) {
    parameters_ = parameters;
    return *this;
  }
  [[nodiscard]] const std::vector<Parameter>& parameter_overrides() const { return parameters_; }

 private:
  std::vector<Parameter> parameters_;
};

class QoS {
 public:
  explicit(false) QoS(std::size_t) {}
  QoS& transient_local() {
    is_latched_ = true;
    return *this;
  }
  [[nodiscard]] bool is_latched() const { return is_latched_; }

 private:
  bool is_latched_{false};
};
class SensorDataQoS : public QoS {
 public:
  SensorDataQoS() : QoS{5} {}
};

class SerializedMessage {
 public:
  void reserve(std::size_t capacity) {
    memory_.resize(capacity);
    message_.buffer = memory_.data();
    message_.buffer_capacity = capacity;
  }
  [[nodiscard]] rcl_serialized_message_t& get_rcl_serialized_message() { return message_; }
  [[nodiscard]] const rcl_serialized_message_t& get_rcl_serialized_message() const { return message_; }

 private:
  std::vector<std::uint8_t> memory_;
  rcl_serialized_message_t message_;
};

class GenericPublisher {
 public:
  using SharedPtr = std::shared_ptr<GenericPublisher>;
  explicit GenericPublisher(std::string topic) : topic_{std::move(topic)} {}
  void publish(const SerializedMessage& message) {
    const rcl_serialized_message_t& bytes{message.get_rcl_serialized_message()};
    const std::scoped_lock lock{stand_in::world().mutex};
    if (stand_in::world().publishing_fails) throw std::runtime_error{"failed to publish message"};
    stand_in::world().published.at(topic_).messages.emplace_back(bytes.buffer, bytes.buffer + bytes.buffer_length);
  }
  [[nodiscard]] std::size_t get_subscription_count() const {
    const std::scoped_lock lock{stand_in::world().mutex};
    const auto found{stand_in::world().subscriptions.find(topic_)};
    return found == stand_in::world().subscriptions.end() ? 1 : found->second;
  }

 private:
  std::string topic_;
};

class SubscriptionBase {
 public:
  using SharedPtr = std::shared_ptr<SubscriptionBase>;
  explicit SubscriptionBase(std::string topic) : topic_{std::move(topic)} {}
  SubscriptionBase(const SubscriptionBase&) = delete;
  SubscriptionBase& operator=(const SubscriptionBase&) = delete;
  ~SubscriptionBase() {
    const std::scoped_lock lock{stand_in::world().mutex};
    stand_in::world().subscribers.erase(topic_);
  }

 private:
  std::string topic_;
};

template <class Message>
class Subscription : public SubscriptionBase {
 public:
  using SharedPtr = std::shared_ptr<Subscription>;
  using SubscriptionBase::SubscriptionBase;
};

namespace node_interfaces {

class NodeBaseInterface {
 public:
  using SharedPtr = std::shared_ptr<NodeBaseInterface>;
  explicit NodeBaseInterface(std::string full_name) : full_name_{std::move(full_name)} {}
  [[nodiscard]] const char* get_fully_qualified_name() const { return full_name_.c_str(); }

 private:
  std::string full_name_;
};

class NodeParametersInterface {
 public:
  using SharedPtr = std::shared_ptr<NodeParametersInterface>;
  explicit NodeParametersInterface(std::map<std::string, ParameterValue> overrides)
      : overrides_{std::move(overrides)} {}
  [[nodiscard]] const std::map<std::string, ParameterValue>& get_parameter_overrides() const { return overrides_; }

 private:
  std::map<std::string, ParameterValue> overrides_;
};

/// The callback is removed with its last handle.
struct OnSetParametersCallbackHandle {
  using SharedPtr = std::shared_ptr<OnSetParametersCallbackHandle>;
  using OnSetParametersCallbackType =
      std::function<rcl_interfaces::msg::SetParametersResult(const std::vector<Parameter>&)>;
  OnSetParametersCallbackType callback;
};

}  // namespace node_interfaces

class Node {
 public:
  Node(const std::string& name, const NodeOptions& options)
      : base_{std::make_shared<node_interfaces::NodeBaseInterface>("/" + name)} {
    std::map<std::string, ParameterValue> given;
    for (const Parameter& one : options.parameter_overrides()) given[one.get_name()] = one.get_parameter_value();
    for (const auto& [parameter, text] : stand_in::world().arguments) given[parameter] = ParameterValue{text};
    parameters_ = std::make_shared<node_interfaces::NodeParametersInterface>(std::move(given));
  }
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;
  virtual ~Node() = default;

  [[nodiscard]] node_interfaces::NodeBaseInterface::SharedPtr get_node_base_interface() { return base_; }
  [[nodiscard]] node_interfaces::NodeParametersInterface::SharedPtr get_node_parameters_interface() {
    return parameters_;
  }
  [[nodiscard]] Logger get_logger() const { return {}; }
  [[nodiscard]] Clock::SharedPtr get_clock() { return std::make_shared<Clock>(); }

  const ParameterValue& declare_parameter(const std::string& name, const ParameterValue& usual,
                                          const rcl_interfaces::msg::ParameterDescriptor& descriptor) {
    const auto given{parameters_->get_parameter_overrides().find(name)};
    const ParameterValue value{given == parameters_->get_parameter_overrides().end() ? usual : given->second};
    if (!descriptor.dynamic_typing && value.get_type() != usual.get_type()) throw std::invalid_argument{name};
    if (!is_within(value, descriptor)) throw exceptions::InvalidParameterValueException{name + " is out of range"};
    if (const auto result{ask({{name, value}})}; !result.successful) {
      throw exceptions::InvalidParameterValueException{result.reason};
    }
    const auto [place, is_new]{declared_.emplace(name, Declared{value, descriptor})};
    if (!is_new) throw std::logic_error{"parameter " + name + " is declared twice"};
    return place->second.value;
  }
  [[nodiscard]] bool has_parameter(const std::string& name) const { return declared_.contains(name); }
  [[nodiscard]] Parameter get_parameter(const std::string& name) const { return {name, declared_.at(name).value}; }
  rcl_interfaces::msg::SetParametersResult set_parameter(const Parameter& changed) {
    Declared& declared{declared_.at(changed.get_name())};
    const ParameterValue& value{changed.get_parameter_value()};
    const bool is_type{declared.descriptor.dynamic_typing || value.get_type() == declared.value.get_type()};
    const bool is_allowed{!declared.descriptor.read_only && is_type && is_within(value, declared.descriptor)};
    if (!is_allowed) return {false, changed.get_name() + " is read-only, of another type or out of range"};
    const auto result{ask({changed})};
    if (result.successful) declared.value = value;
    return result;
  }
  using OnSetParametersCallbackHandle = node_interfaces::OnSetParametersCallbackHandle;
  [[nodiscard]] OnSetParametersCallbackHandle::SharedPtr add_on_set_parameters_callback(
      OnSetParametersCallbackHandle::OnSetParametersCallbackType callback) {
    const auto handle{std::make_shared<OnSetParametersCallbackHandle>()};
    handle->callback = std::move(callback);
    on_set_.push_back(handle);
    return handle;
  }
  [[nodiscard]] std::size_t parameters() const { return declared_.size(); }

  GenericPublisher::SharedPtr create_generic_publisher(const std::string& topic, const std::string& type,
                                                       const QoS& qos) {
    const std::scoped_lock lock{stand_in::world().mutex};
    for (const std::string& package : stand_in::world().missing_packages) {
      if (type.starts_with(package + "/")) throw std::runtime_error{"package '" + package + "' not found"};
    }
    stand_in::world().published[topic] = {type, qos.is_latched()};
    return std::make_shared<GenericPublisher>(topic);
  }

  template <class Message, class Callback>
  typename Subscription<Message>::SharedPtr create_subscription(const std::string& topic, const QoS& qos,
                                                                Callback callback) {
    const std::scoped_lock lock{stand_in::world().mutex};
    if (qos.is_latched()) stand_in::world().latched_subscribers.insert(topic);
    stand_in::world().subscribers[topic] = [callback](const void* message) {
      callback(*static_cast<const Message*>(message));
    };
    return std::make_shared<Subscription<Message>>(topic);
  }

 private:
  struct Declared {
    ParameterValue value;
    rcl_interfaces::msg::ParameterDescriptor descriptor;
  };

  [[nodiscard]] rcl_interfaces::msg::SetParametersResult ask(const std::vector<Parameter>& parameters) const {
    for (const auto& one : on_set_) {
      const auto handle{one.lock()};
      if (!handle) continue;
      if (auto result{handle->callback(parameters)}; !result.successful) return result;
    }
    return {true, ""};
  }

  static bool is_within(const ParameterValue& value, const rcl_interfaces::msg::ParameterDescriptor& descriptor) {
    for (const auto& range : descriptor.integer_range) {
      if (value.get<std::int64_t>() < range.from_value || value.get<std::int64_t>() > range.to_value) return false;
    }
    for (const auto& range : descriptor.floating_point_range) {
      if (value.get<double>() < range.from_value || value.get<double>() > range.to_value) return false;
    }
    return true;
  }

  node_interfaces::NodeBaseInterface::SharedPtr base_;
  node_interfaces::NodeParametersInterface::SharedPtr parameters_;
  std::map<std::string, Declared> declared_;
  std::vector<std::weak_ptr<OnSetParametersCallbackHandle>> on_set_;
};

inline void init(int argc, char** argv) {
  for (int i{1}; i + 1 < argc; ++i) {
    const std::string word{argv[i + 1]};
    if (std::string{argv[i]} != "-p") continue;
    stand_in::world().arguments.emplace_back(word.substr(0, word.find(":=")), word.substr(word.find(":=") + 2));
  }
}
inline void shutdown() {
  const std::scoped_lock lock{stand_in::world().mutex};
  stand_in::world().is_shut_down = true;
}
/// Ends at once: nothing comes.
inline void spin(const node_interfaces::NodeBaseInterface::SharedPtr&) {}

}  // namespace rclcpp
