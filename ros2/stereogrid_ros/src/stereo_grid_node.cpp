// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Copyright 2026 The stereogrid authors
//
// Licensed under the Apache License, Version 2.0 (the "License");
// you may not use this file except in compliance with the License.
// You may obtain a copy of the License at
//
//     http://www.apache.org/licenses/LICENSE-2.0
//
// Unless required by applicable law or agreed to in writing, software
// distributed under the License is distributed on an "AS IS" BASIS,
// WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
// See the License for the specific language governing permissions and
// limitations under the License.
#include "stereo_grid_node.hpp"

#include <algorithm>
#include <cctype>
#include <chrono>
#include <iterator>
#include <utility>

#include <rclcpp_components/register_node_macro.hpp>

#include "settings.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid_ros {
namespace {

using namespace std::chrono_literals;
using stereogrid::InputError;
using stereogrid::capture::Clock;

constexpr std::size_t warnings_max{100};
constexpr auto warn_again_after{1min};

template <class T>
std::int64_t nanoseconds(T instant) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(instant.time_since_epoch()).count();
}

std::chrono::nanoseconds duration_of(double seconds) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>{seconds});
}

}  // namespace

StereoGridNode::StereoGridNode(const rclcpp::NodeOptions& options)
    : LifecycleNode{"stereo_grid", options},
      clock_ns_{nanoseconds(std::chrono::system_clock::now()) - nanoseconds(Clock::now())} {
  if (!is_autostarted(*this)) return;
  static_cast<void>(read_settings(*this));  // throws, so that a container's client receives the reason
  configure();
  activate();
}

StereoGridNode::~StereoGridNode() {
  stop();
}

StereoGridNode::CallbackReturn StereoGridNode::on_configure(const rclcpp_lifecycle::State& /*previous*/) {
  try {
    settings_ = read_settings(*this);
  } catch (const stereogrid::ConfigError& error) {
    RCLCPP_ERROR(get_logger(), "%s", error.what());
    return CallbackReturn::FAILURE;
  }
  thresholds_ = settings_.thresholds;
  on_set_ = add_on_set_parameters_callback([this](const auto& parameters) { return set(parameters); });
  transforms_.emplace(get_clock());
  listener_.emplace(*transforms_, this);  // with the node's remappings
  return CallbackReturn::SUCCESS;
}

rcl_interfaces::msg::SetParametersResult StereoGridNode::set(const std::vector<rclcpp::Parameter>& parameters) {
  rcl_interfaces::msg::SetParametersResult result;
  try {
    Thresholds changed{thresholds()};
    for (const rclcpp::Parameter& parameter : parameters) {
      if (set_threshold(changed, parameter) || !settings_.names.contains(parameter.get_name())) continue;
      throw stereogrid::ConfigError{"parameter " + parameter.get_name() +
                                    " is read by configure: deactivate and clean up the node first."};
    }
    const std::scoped_lock lock{mutex_};
    thresholds_ = changed;
    result.successful = true;
  } catch (const stereogrid::ConfigError& error) {
    result.successful = false;
    result.reason = error.what();
  }
  return result;
}

// The mutex is locked.
stereogrid::capture::PairingOptions StereoGridNode::pairing() const {
  return {.tolerance = duration_of(thresholds_.pair_tolerance_s), .has_depth = settings_.input != "stereo"};
}

Thresholds StereoGridNode::thresholds() {
  const std::scoped_lock lock{mutex_};
  return thresholds_;
}

void StereoGridNode::set_failure_handler(std::function<void()> handler) {
  const std::scoped_lock lock{mutex_};
  failure_handler_ = std::move(handler);
}

std::function<void()> StereoGridNode::failure_handler() {
  const std::scoped_lock lock{mutex_};
  return failure_handler_;
}

StereoGridNode::CallbackReturn StereoGridNode::on_activate(const rclcpp_lifecycle::State& /*previous*/) {
  is_to_stop_ = false;
  has_failed_ = false;
  thread_ = std::thread{[this] { work(); }};
  subscribe_all();
  return CallbackReturn::SUCCESS;
}

StereoGridNode::CallbackReturn StereoGridNode::on_deactivate(const rclcpp_lifecycle::State& /*previous*/) {
  stop();
  return CallbackReturn::SUCCESS;
}

StereoGridNode::CallbackReturn StereoGridNode::on_cleanup(const rclcpp_lifecycle::State& /*previous*/) {
  on_set_.reset();
  listener_.reset();
  transforms_.reset();
  return CallbackReturn::SUCCESS;
}

StereoGridNode::CallbackReturn StereoGridNode::on_shutdown(const rclcpp_lifecycle::State& previous) {
  stop();
  return on_cleanup(previous);
}

void StereoGridNode::stop() {
  if (!thread_.joinable()) return;
  subscriptions_.clear();
  {
    const std::scoped_lock lock{mutex_};
    is_to_stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
  sink_.clear();
  const std::scoped_lock lock{mutex_};
  infos_ = {};
  baseline_m_ = 0;
  newest_ns_ = {};
  pair_.reset();
}

void StereoGridNode::warn(const std::string& sentence) {
  std::string text;
  std::ranges::remove_copy_if(sentence, std::back_inserter(text),
                              [](unsigned char letter) { return std::isdigit(letter) != 0; });
  const std::scoped_lock lock{mutex_};
  if (warned_.size() > warnings_max) warned_.clear();
  const auto [last, is_new]{warned_.try_emplace(std::move(text), Clock::now())};
  if (!is_new && Clock::now() - last->second < warn_again_after) return;
  last->second = Clock::now();
  RCLCPP_WARN(get_logger(), "%s", sentence.c_str());
}

void StereoGridNode::work() {
  try {
    while (!is_to_stop_) {
      if (open_pair()) return go_on();
    }
  } catch (const std::exception& error) {
    RCLCPP_FATAL(get_logger(), "stopped: %s. Deactivate and activate the node to try again.", error.what());
    has_failed_ = true;
    if (const auto notify{failure_handler()}) notify();
  }
}

// The mutex is locked.
bool StereoGridNode::has_infos() const {
  if (!infos_[0]) return false;
  return settings_.input == "depth" || (settings_.input == "disparity" ? baseline_m_ > 0 : infos_[1].has_value());
}

bool StereoGridNode::open_pair() {
  std::unique_lock lock{mutex_};
  if (!changed_.wait_for(lock, 5s, [this] { return is_to_stop_ || has_infos(); })) {
    lock.unlock();
    warn(settings_.input == "stereo" ? "waiting for the CameraInfo of both cameras: left/camera_info, right/camera_info"
         : settings_.input == "depth" ? "waiting for left/camera_info"
                                      : "waiting for left/camera_info and disparity");
    return false;
  }
  if (is_to_stop_) return false;
  const auto left{*std::exchange(infos_[0], std::nullopt)};
  const auto right{std::exchange(infos_[1], std::nullopt)};
  lock.unlock();
  try {
    stereogrid::io::Calibration calibration{calibration_of(left, right)};
    set_extrinsics_from_tf(calibration.rig, left.header.frame_id);
    lock.lock();
    camera_frame_ = left.header.frame_id;
    calibration_ = calibration;
    pair_ = std::make_shared<Pair>(calibration, pairing());
    return true;
  } catch (const InputError& error) {
    warn(error.what());
    return false;  // the next CameraInfo may do
  }
}

stereogrid::io::Calibration StereoGridNode::calibration_of(
    const sensor_msgs::msg::CameraInfo& left, const std::optional<sensor_msgs::msg::CameraInfo>& right) const {
  const stereogrid::io::RosCamera left_camera{camera_of(left, "left/camera_info")};
  stereogrid::io::RosCamera right_camera{right ? camera_of(*right, "right/camera_info") : left_camera};
  if (!right) {
    const double focal_px{left_camera.p[0]};
    const double known_m{baseline_m_};
    right_camera.p[3] =
        -focal_px * (known_m > 0 ? known_m : stereogrid::io::virtual_baseline_m(focal_px, left_camera.width_px));
  }
  return stereogrid::io::ros_calibration(left_camera, right_camera, settings_.are_rectified);
}

void StereoGridNode::set_extrinsics_from_tf(stereogrid::Rig& rig, const std::string& camera_frame) {
  if (settings_.robot_base_frame.empty()) return;
  set_extrinsics(rig, look_up(settings_.robot_base_frame, camera_frame, rclcpp::Time{0, 0, RCL_ROS_TIME}));
}

// Waits in wall time: the buffer's own wait is in ROS time, which stands still while a simulation is paused.
geometry_msgs::msg::Transform StereoGridNode::look_up(const std::string& target, const std::string& source,
                                                      const rclcpp::Time& instant) {
  const Clock::time_point end{Clock::now() + duration_of(thresholds().transform_tolerance_s)};
  for (;;) {
    try {
      return transforms_->lookupTransform(target, source, instant, rclcpp::Duration{0ns}).transform;
    } catch (const tf2::TransformException& error) {
      if (is_to_stop_ || Clock::now() >= end) {
        throw InputError{"TF", error.what(), "Publish it, or set robot_base_frame to \"\" and poses to images."};
      }
    }
    std::this_thread::sleep_for(2ms);
  }
}

std::shared_ptr<StereoGridNode::Pair> StereoGridNode::current_pair() {
  const std::scoped_lock lock{mutex_};
  return pair_;
}

void StereoGridNode::place(PreparedFrame& prepared, std::optional<stereogrid::VisualOdometry>& odometry,
                           const stereogrid::Rig& rig) {
  stereogrid::StereoFrame& frame{prepared.frame};
  if (settings_.poses == "images") {
    if (!odometry) odometry.emplace(rig);
    stereogrid::OdometryStep step{odometry->update(frame)};
    frame.world_from_vehicle = step.world_from_vehicle;
    prepared.covariances = step.covariances;
    prepared.warning = std::move(step.warning);
  } else if (settings_.poses == "tf") {
    frame.world_from_vehicle =
        pose_of(look_up(settings_.global_frame, camera_frame_, rclcpp::Time{frame.stamp_ns, RCL_ROS_TIME}));
  }
}

/// Frames of the camera pair that the node has now, for its pipeline.
class StereoGridNode::Frames final : public stereogrid::capture::FrameHandler {
 public:
  Frames(StereoGridNode& node, stereogrid::Rig rig)
      : node_{node}, rig_{rig}, messages_{node.sink_, rig, node.settings_.messages} {}

  [[nodiscard]] bool has_ended() const override { return node_.is_to_stop_; }

  [[nodiscard]] std::optional<PreparedFrame> next() override {
    const std::shared_ptr<Pair> now{node_.current_pair()};
    if (now != pair_) {
      pair_ = now;
      odometry_.reset();
      resets_before_ = true;
    }
    pair_->set_tolerance(duration_of(node_.thresholds().pair_tolerance_s));
    const std::string fault{pair_->fault()};
    if (!fault.empty()) node_.warn(fault);
    std::optional<stereogrid::capture::LiveFrame> live{pair_->next(100ms)};
    if (!live) return std::nullopt;
    PreparedFrame prepared{.frame = std::move(live->frame), .captured = live->captured};
    prepared.frame.stamp_ns = nanoseconds(live->captured) + node_.clock_ns_;
    node_.place(prepared, odometry_, pair_->rig());
    prepared.resets_before = std::exchange(resets_before_, false);
    return prepared;
  }

  void deliver(PreparedFrame& prepared, stereogrid::FrameResult& result) override {
    if (result.rig != rig_) messages_.set_rig(rig_ = result.rig);  // found in an earlier frame
    for (const stereogrid::Warning& warning : result.warnings) node_.warn(warning.text);
    const std::vector<stereogrid::messages::Dropped> dropped{node_.dropped_by(*pair_)};
    messages_.set_points_voxel(node_.thresholds().points_voxel_m);
    messages_.send(result, {.stamp_ns = prepared.frame.stamp_ns,
                            .frames = ++frames_,
                            .dropped = dropped,
                            .covariances = prepared.covariances});
  }

  void refuse(const std::string& reason) override {
    ++node_.refused_;
    node_.warn(reason);
  }

 private:
  StereoGridNode& node_;
  stereogrid::Rig rig_;
  stereogrid::messages::FrameMessages messages_;
  std::shared_ptr<Pair> pair_;
  bool resets_before_{false};
  std::optional<stereogrid::VisualOdometry> odometry_;
  std::int64_t frames_{0};
};

void StereoGridNode::go_on() {
  const stereogrid::Rig rig{current_pair()->rig()};
  stereogrid::Pipeline pipeline{settings_.config, rig, settings_.pipeline};
  Frames frames{*this, rig};
  stereogrid::capture::run_frames(pipeline, frames);
}

std::vector<stereogrid::messages::Dropped> StereoGridNode::dropped_by(const Pair& pair) const {
  std::vector<stereogrid::messages::Dropped> dropped;
  for (const stereogrid::capture::Drop& drop : pair.dropped()) dropped.push_back({drop.reason, drop.frames});
  if (refused_ > 0) dropped.push_back({"no transform of its instant, or refused by the pipeline", refused_});
  return dropped;
}

}  // namespace stereogrid_ros

RCLCPP_COMPONENTS_REGISTER_NODE(stereogrid_ros::StereoGridNode)
