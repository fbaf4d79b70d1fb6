// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereo_grid_node.hpp"

#include <algorithm>
#include <chrono>
#include <rclcpp_components/register_node_macro.hpp>
#include <utility>

#include "stereogrid/error.hpp"
#include "stereogrid/pipeline.hpp"
#include "translate.hpp"

namespace stereogrid_ros {
namespace {

using namespace std::chrono_literals;
using stereogrid::InputError;
using stereogrid::capture::Clock;

constexpr std::int64_t step_back_ns{1'000'000'000};

template <class T>
std::int64_t nanoseconds(T instant) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(instant.time_since_epoch()).count();
}

std::size_t index_of(stereogrid::capture::Side side) {
  return side == stereogrid::capture::Side::left ? 0 : 1;
}

}  // namespace

StereoGridNode::StereoGridNode(const rclcpp::NodeOptions& options)
    : Node{"stereo_grid", options},
      settings_{declare_settings(*this)},
      clock_ns_{nanoseconds(std::chrono::system_clock::now()) - nanoseconds(Clock::now())} {
  subscribe(Side::left, "left");
  subscribe(Side::right, "right");
  thread_ = std::thread{[this] { work(); }};
}

StereoGridNode::~StereoGridNode() {
  is_to_stop_ = true;
  changed_.notify_all();
  thread_.join();
}

void StereoGridNode::subscribe(Side side, const std::string& camera) {
  subscriptions_.push_back(create_subscription<sensor_msgs::msg::CameraInfo>(
      camera + "/camera_info", rclcpp::SensorDataQoS{},
      [this, side](const sensor_msgs::msg::CameraInfo& info) { take_info(side, info); }));
  subscriptions_.push_back(create_subscription<sensor_msgs::msg::Image>(
      camera + (settings_.are_rectified ? "/image_rect" : "/image_raw"), rclcpp::SensorDataQoS{},
      [this, side](const sensor_msgs::msg::Image& image) { take_image(side, image); }));
}

void StereoGridNode::take_info(Side side, const sensor_msgs::msg::CameraInfo& info) {
  const std::scoped_lock lock{mutex_};
  if (pair_) return;
  infos_.at(index_of(side)) = info;
  changed_.notify_all();
}

void StereoGridNode::take_image(Side side, const sensor_msgs::msg::Image& image) {
  const std::int64_t stamp_ns{rclcpp::Time{image.header.stamp}.nanoseconds()};
  std::shared_ptr<Pair> pair;
  {
    const std::scoped_lock lock{mutex_};
    if (!pair_) return;
    std::int64_t& newest_ns{newest_ns_.at(index_of(side))};
    if (stamp_ns + step_back_ns < newest_ns) {
      RCLCPP_INFO(get_logger(), "the stamps of the images step back: all begins anew");
      newest_ns_.fill(stamp_ns);
      pair_ = std::make_shared<Pair>(calibration_, pairing());
    }
    newest_ns = std::max(newest_ns, stamp_ns);
    pair = pair_;
  }
  try {
    pair->add(side, pixels_of(image, side == Side::left ? "left image" : "right image"),
              Clock::time_point{std::chrono::nanoseconds{stamp_ns - clock_ns_}});
  } catch (const InputError& error) {
    pair->add_unusable();
    tell(error.what());
  }
}

void StereoGridNode::tell(const std::string& sentence) {
  const std::scoped_lock lock{mutex_};
  if (sentence != std::exchange(told_, sentence)) RCLCPP_WARN(get_logger(), "%s", sentence.c_str());
}

void StereoGridNode::work() {
  try {
    while (!is_to_stop_) {
      if (open_pair()) return go_on();
    }
  } catch (const std::exception& error) {
    RCLCPP_FATAL(get_logger(), "stopped: %s", error.what());
  }
}

bool StereoGridNode::open_pair() {
  std::unique_lock lock{mutex_};
  if (!changed_.wait_for(lock, 5s, [this] { return is_to_stop_ || (infos_[0] && infos_[1]); })) {
    lock.unlock();
    tell("waiting for the CameraInfo of both cameras: left/camera_info, right/camera_info");
    return false;
  }
  if (is_to_stop_) return false;
  const auto left{*std::exchange(infos_[0], std::nullopt)};
  const auto right{*std::exchange(infos_[1], std::nullopt)};
  lock.unlock();
  try {
    stereogrid::io::Calibration calibration{stereogrid::io::ros_calibration(
        camera_of(left, "left/camera_info"), camera_of(right, "right/camera_info"), settings_.are_rectified)};
    set_mounting_from_tf(calibration.rig, left.header.frame_id);
    lock.lock();
    camera_frame_ = left.header.frame_id;
    calibration_ = calibration;
    pair_ = std::make_shared<Pair>(calibration, pairing());
    return true;
  } catch (const InputError& error) {
    tell(error.what());
    return false;  // the next CameraInfo may do
  }
}

void StereoGridNode::set_mounting_from_tf(stereogrid::Rig& rig, const std::string& camera_frame) {
  if (settings_.robot_base_frame.empty()) return;
  set_mounting(rig, transform(settings_.robot_base_frame, camera_frame, rclcpp::Time{0, 0, RCL_ROS_TIME}));
}

geometry_msgs::msg::Transform StereoGridNode::transform(const std::string& target, const std::string& source,
                                                        const rclcpp::Time& instant) const {
  try {
    return transforms_.lookupTransform(target, source, instant, rclcpp::Duration{settings_.transform_tolerance})
        .transform;
  } catch (const tf2::TransformException& error) {
    throw InputError{"TF", error.what(), "Publish it, or set robot_base_frame to \"\" and poses to images."};
  }
}

std::shared_ptr<StereoGridNode::Pair> StereoGridNode::current_pair() {
  const std::scoped_lock lock{mutex_};
  return pair_;
}

void StereoGridNode::place(stereogrid::StereoFrame& frame, std::optional<stereogrid::io::VisualOdometry>& odometry,
                           const stereogrid::Rig& rig) {
  if (settings_.poses == "images") {
    if (!odometry) odometry.emplace(rig);
    frame.world_from_vehicle = odometry->update(frame).world_from_vehicle;
  } else if (settings_.poses == "tf") {
    frame.world_from_vehicle =
        pose_of(transform(settings_.global_frame, camera_frame_, rclcpp::Time{frame.stamp_ns, RCL_ROS_TIME}));
  }
}

void StereoGridNode::go_on() {
  std::shared_ptr<Pair> pair{current_pair()};
  stereogrid::Rig rig{pair->rig()};
  stereogrid::Pipeline pipeline{settings_.config, rig, settings_.pipeline};
  stereogrid::messages::FrameMessages messages{sink_, rig, settings_.messages};
  std::optional<stereogrid::io::VisualOdometry> odometry;
  stereogrid::FrameResult result;
  std::int64_t frames{0};
  while (!is_to_stop_) {
    if (const std::string fault{pair->fault()}; !fault.empty()) tell(fault);
    try {
      if (current_pair() != pair) {
        pair = current_pair();
        pipeline.reset();
        odometry.reset();
      }
      std::optional<stereogrid::capture::LiveFrame> live{pair->next(100ms)};
      if (!live) continue;
      live->frame.stamp_ns = nanoseconds(live->captured) + clock_ns_;
      place(live->frame, odometry, pair->rig());
      pipeline.process(live->frame, result);
      if (result.rig != rig) messages.set_rig(rig = result.rig);  // found in the frame before
      for (const std::string& warning : result.warnings) tell(warning);
      const std::vector<stereogrid::messages::Dropped> dropped{dropped_by(*pair)};
      messages.send(result, {.stamp_ns = live->frame.stamp_ns, .frames = ++frames, .dropped = dropped});
    } catch (const InputError& error) {
      ++refused_;
      tell(error.what());
    }
  }
}

std::vector<stereogrid::messages::Dropped> StereoGridNode::dropped_by(const Pair& pair) const {
  std::vector<stereogrid::messages::Dropped> dropped;
  for (const stereogrid::capture::Drop& drop : pair.dropped()) dropped.push_back({drop.reason, drop.frames});
  if (refused_ > 0) dropped.push_back({"no transform of its instant, or refused by the pipeline", refused_});
  return dropped;
}

}  // namespace stereogrid_ros

RCLCPP_COMPONENTS_REGISTER_NODE(stereogrid_ros::StereoGridNode)
