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
#include <memory>
#include <string>
#include <utility>
#include <vector>

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
  for (const auto& [name, value] : get_node_parameters_interface()->get_parameter_overrides()) {
    if (has_parameter(name) || name.starts_with("qos_overrides.")) continue;
    RCLCPP_WARN(get_logger(), "parameter %s is unknown, and has no effect.", name.c_str());
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
  const std::vector<std::string>& names{settings_.cameras};
  for (std::size_t i{0}; i < std::max<std::size_t>(1, names.size()); ++i) {
    cameras_.push_back(std::make_shared<Camera>());
    if (!names.empty()) cameras_.back()->prefix = names[i] + "/";
  }
  thread_ = std::thread{[this] { work(); }};
  for (const auto& camera : cameras_) subscribe_all(camera);
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
  cameras_.clear();
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
    for (const auto& camera : cameras_) {
      while (!is_to_stop_ && !open_pair(*camera)) {
      }
    }
    if (!is_to_stop_) go_on();
  } catch (const std::exception& error) {
    RCLCPP_FATAL(get_logger(), "stopped: %s. Deactivate and activate the node to try again.", error.what());
    has_failed_ = true;
    if (const auto notify{failure_handler()}) notify();
  }
}

// The mutex is locked.
bool StereoGridNode::has_infos(const Camera& camera) const {
  if (!camera.infos[0]) return false;
  return settings_.input == "depth" ||
         (settings_.input == "disparity" ? camera.baseline_m > 0 : camera.infos[1].has_value());
}

bool StereoGridNode::open_pair(Camera& camera) {
  std::unique_lock lock{mutex_};
  if (!changed_.wait_for(lock, 5s, [&] { return is_to_stop_ || has_infos(camera); })) {
    lock.unlock();
    const std::string left{camera.prefix + "left/camera_info"};
    warn(settings_.input == "stereo"
             ? "waiting for the CameraInfo of both cameras: " + left + ", " + camera.prefix + "right/camera_info"
         : settings_.input == "depth" ? "waiting for " + left
                                      : "waiting for " + left + " and " + camera.prefix + "disparity");
    return false;
  }
  if (is_to_stop_) return false;
  const auto left{*std::exchange(camera.infos[0], std::nullopt)};
  const auto right{std::exchange(camera.infos[1], std::nullopt)};
  lock.unlock();
  try {
    stereogrid::io::Calibration calibration{calibration_of(camera, left, right)};
    set_extrinsics_from_tf(calibration.rig, left.header.frame_id);
    lock.lock();
    camera.frame = left.header.frame_id;
    camera.calibration = calibration;
    camera.pair = std::make_shared<Pair>(calibration, pairing());
    return true;
  } catch (const InputError& error) {
    warn(error.what());
    return false;  // the next CameraInfo may do
  }
}

stereogrid::io::Calibration StereoGridNode::calibration_of(
    const Camera& camera, const sensor_msgs::msg::CameraInfo& left,
    const std::optional<sensor_msgs::msg::CameraInfo>& right) const {
  const stereogrid::io::RosCamera left_camera{camera_of(left, camera.prefix + "left/camera_info")};
  stereogrid::io::RosCamera right_camera{right ? camera_of(*right, camera.prefix + "right/camera_info") : left_camera};
  if (!right) {
    const double focal_px{left_camera.p[0]};
    const double known_m{camera.baseline_m};
    right_camera.p[3] =
        -focal_px * (known_m > 0 ? known_m : stereogrid::io::virtual_baseline_m(focal_px, left_camera.width_px));
  }
  return stereogrid::io::ros_calibration(left_camera, right_camera, settings_.are_rectified);
}

void StereoGridNode::set_extrinsics_from_tf(stereogrid::Rig& rig, const std::string& camera_frame) {
  if (settings_.robot_base_frame.empty()) return;
  const auto base_from_camera{look_up(settings_.robot_base_frame, camera_frame, rclcpp::Time{0, 0, RCL_ROS_TIME})};
  set_extrinsics(rig, base_from_camera);
  if (settings_.cameras.empty()) return;
  const stereogrid::Pose2 place{pose_of(base_from_camera)};
  rig.camera_x_m = place.x_m;
  rig.camera_y_m = place.y_m;
  rig.camera_yaw_rad = place.yaw_rad;
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

std::shared_ptr<StereoGridNode::Pair> StereoGridNode::current_pair(const Camera& camera) {
  const std::scoped_lock lock{mutex_};
  return camera.pair;
}

/// Frames of the pair that a camera has now, with their stamps and the poses of TF.
class StereoGridNode::CameraSource final : public stereogrid::capture::LiveSource {
 public:
  CameraSource(StereoGridNode& node, const Camera& camera)
      : node_{node}, camera_{camera}, rig_{camera.calibration.rig}, pair_{node.current_pair(camera)} {}

  [[nodiscard]] const stereogrid::Rig& rig() const override { return rig_; }
  [[nodiscard]] bool has_ended() const override { return node_.is_to_stop_; }
  [[nodiscard]] std::string fault() const override { return pair_->fault(); }
  [[nodiscard]] std::vector<stereogrid::capture::Drop> dropped() const override { return pair_->dropped(); }

  [[nodiscard]] std::optional<stereogrid::capture::LiveFrame> next(std::chrono::milliseconds patience) override {
    const std::shared_ptr<Pair> now{node_.current_pair(camera_)};
    if (now != pair_) {
      pair_ = now;
      resets_before_ = true;
    }
    pair_->set_tolerance(duration_of(node_.thresholds().pair_tolerance_s));
    std::optional<stereogrid::capture::LiveFrame> live{pair_->next(patience)};
    if (!live) return std::nullopt;
    live->frame.stamp_ns = nanoseconds(live->captured) + node_.clock_ns_;
    if (node_.settings_.poses == "tf") live->frame.world_from_vehicle = pose_at(live->frame.stamp_ns);
    live->resets_before = std::exchange(resets_before_, false);
    return live;
  }

 private:
  [[nodiscard]] stereogrid::Pose2 pose_at(std::int64_t stamp_ns) {
    const rclcpp::Time instant{stamp_ns, RCL_ROS_TIME};
    return pose_of(node_.look_up(node_.settings_.global_frame, camera_.frame, instant)) * inverse(camera_place(rig_));
  }

  StereoGridNode& node_;
  const Camera& camera_;
  const stereogrid::Rig rig_;
  std::shared_ptr<Pair> pair_;
  bool resets_before_{false};
};

/// Frames of all cameras, for the node's pipeline.
class StereoGridNode::Frames final : public stereogrid::capture::FrameHandler {
 public:
  Frames(StereoGridNode& node, stereogrid::capture::LiveSource& source)
      : node_{node}, source_{source}, rig_{source.rig()}, messages_{node.sink_, rig_, node.settings_.messages} {}

  [[nodiscard]] bool has_ended() const override { return node_.is_to_stop_; }

  [[nodiscard]] std::optional<PreparedFrame> next() override {
    const std::string fault{source_.fault()};
    if (!fault.empty()) node_.warn(fault);
    std::optional<stereogrid::capture::LiveFrame> live{source_.next(100ms)};
    if (!live) return std::nullopt;
    if (live->resets_before) odometry_.reset();
    PreparedFrame prepared{.frame = std::move(live->frame), .captured = live->captured};
    prepared.resets_before = live->resets_before;
    if (node_.settings_.poses == "images" && !prepared.frame.left.empty()) find_pose(prepared);
    return prepared;
  }

  void deliver(PreparedFrame& prepared, stereogrid::FrameResult& result) override {
    if (result.rig != rig_) messages_.set_rig(rig_ = result.rig);  // found in an earlier frame
    for (const stereogrid::Warning& warning : result.warnings) node_.warn(warning.text);
    const std::vector<stereogrid::messages::Dropped> dropped{dropped_frames()};
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
  /// By visual odometry, which is of the first camera.
  void find_pose(PreparedFrame& prepared) {
    if (!odometry_) odometry_.emplace(source_.rig());
    stereogrid::OdometryStep step{odometry_->update(prepared.frame)};
    const stereogrid::Pose2 place{camera_place(source_.rig())};
    const bool is_at_origin{place == stereogrid::Pose2{}};
    prepared.frame.world_from_vehicle =
        is_at_origin ? step.world_from_vehicle : place * step.world_from_vehicle * inverse(place);
    if (is_at_origin) prepared.covariances = step.covariances;  // they are of the camera
    prepared.warning = std::move(step.warning);
  }

  [[nodiscard]] std::vector<stereogrid::messages::Dropped> dropped_frames() const {
    std::vector<stereogrid::messages::Dropped> dropped;
    for (const stereogrid::capture::Drop& drop : source_.dropped()) dropped.push_back({drop.reason, drop.frames});
    if (node_.refused_ > 0) {
      dropped.push_back({"no transform of its instant, or refused by the pipeline", node_.refused_});
    }
    return dropped;
  }

  StereoGridNode& node_;
  stereogrid::capture::LiveSource& source_;
  stereogrid::Rig rig_;
  stereogrid::messages::FrameMessages messages_;
  std::optional<stereogrid::VisualOdometry> odometry_;
  std::int64_t frames_{0};
};

void StereoGridNode::go_on() {
  std::vector<stereogrid::capture::NamedSource> sources;
  for (const auto& camera : cameras_) {
    sources.push_back(
        {camera->prefix.substr(0, camera->prefix.rfind('/')), std::make_unique<CameraSource>(*this, *camera)});
  }
  const auto source{stereogrid::capture::join_cameras(std::move(sources))};
  stereogrid::PipelineOptions options{settings_.pipeline};
  options.camera_names = source->camera_names();
  stereogrid::Pipeline pipeline{settings_.config, source->rigs(), options};
  Frames frames{*this, *source};
  stereogrid::capture::run_frames(pipeline, frames);
}

}  // namespace stereogrid_ros

RCLCPP_COMPONENTS_REGISTER_NODE(stereogrid_ros::StereoGridNode)
