// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereo_grid_node.hpp"

#include <algorithm>
#include <cctype>
#include <chrono>
#include <iterator>
#include <opencv2/core/mat.hpp>
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
constexpr std::size_t warnings_max{100};
constexpr auto warn_again_after{1min};

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
    cv::Mat grey;
    pair->add(side, pixels_of(image, side == Side::left ? "left image" : "right image", grey),
              Clock::time_point{std::chrono::nanoseconds{stamp_ns - clock_ns_}});
  } catch (const InputError& error) {
    pair->add_unusable();
    warn(error.what());
  }
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
    RCLCPP_FATAL(get_logger(), "stopped: %s", error.what());
    has_failed_ = true;
    rclcpp::shutdown();  // a node that does nothing is not left in the graph
  }
}

bool StereoGridNode::open_pair() {
  std::unique_lock lock{mutex_};
  if (!changed_.wait_for(lock, 5s, [this] { return is_to_stop_ || (infos_[0] && infos_[1]); })) {
    lock.unlock();
    warn("waiting for the CameraInfo of both cameras: left/camera_info, right/camera_info");
    return false;
  }
  if (is_to_stop_) return false;
  const auto left{*std::exchange(infos_[0], std::nullopt)};
  const auto right{*std::exchange(infos_[1], std::nullopt)};
  lock.unlock();
  try {
    stereogrid::io::Calibration calibration{stereogrid::io::ros_calibration(
        camera_of(left, "left/camera_info"), camera_of(right, "right/camera_info"), settings_.are_rectified)};
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

void StereoGridNode::set_extrinsics_from_tf(stereogrid::Rig& rig, const std::string& camera_frame) {
  if (settings_.robot_base_frame.empty()) return;
  set_extrinsics(rig, transform(settings_.robot_base_frame, camera_frame, rclcpp::Time{0, 0, RCL_ROS_TIME}));
}

// Waits in wall time: the buffer's own wait is in ROS time, which stands still while a simulation is paused.
geometry_msgs::msg::Transform StereoGridNode::transform(const std::string& target, const std::string& source,
                                                        const rclcpp::Time& instant) const {
  const Clock::time_point end{Clock::now() + settings_.transform_tolerance};
  for (;;) {
    try {
      return transforms_.lookupTransform(target, source, instant, rclcpp::Duration{0ns}).transform;
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

void StereoGridNode::place(stereogrid::StereoFrame& frame, std::optional<stereogrid::VisualOdometry>& odometry,
                           const stereogrid::Rig& rig) {
  if (settings_.poses == "images") {
    if (!odometry) odometry.emplace(rig);
    frame.world_from_vehicle = odometry->update(frame).world_from_vehicle;
  } else if (settings_.poses == "tf") {
    frame.world_from_vehicle =
        pose_of(transform(settings_.global_frame, camera_frame_, rclcpp::Time{frame.stamp_ns, RCL_ROS_TIME}));
  }
}

/// Frames of the camera pair that the node has now, for its pipeline.
class StereoGridNode::Frames final : public stereogrid::capture::FrameHandler {
 public:
  Frames(StereoGridNode& node, stereogrid::Rig rig)
      : node_{node}, rig_{rig}, messages_{node.sink_, rig, node.settings_.messages} {}

  [[nodiscard]] bool has_ended() const override { return node_.is_to_stop_; }

  [[nodiscard]] std::optional<PreparedFrame> next() override {
    if (const std::shared_ptr<Pair> now{node_.current_pair()}; now != pair_) {
      pair_ = now;
      odometry_.reset();
      begins_anew_ = true;
    }
    if (const std::string fault{pair_->fault()}; !fault.empty()) node_.warn(fault);
    std::optional<stereogrid::capture::LiveFrame> live{pair_->next(100ms)};
    if (!live) return std::nullopt;
    PreparedFrame prepared{.frame = std::move(live->frame), .captured = live->captured};
    prepared.frame.stamp_ns = nanoseconds(live->captured) + node_.clock_ns_;
    node_.place(prepared.frame, odometry_, pair_->rig());
    prepared.begins_anew = std::exchange(begins_anew_, false);
    return prepared;
  }

  void deliver(PreparedFrame& prepared, stereogrid::FrameResult& result) override {
    if (result.rig != rig_) messages_.set_rig(rig_ = result.rig);  // found in an earlier frame
    for (const std::string& warning : result.warnings) node_.warn(warning);
    const std::vector<stereogrid::messages::Dropped> dropped{node_.dropped_by(*pair_)};
    messages_.send(result, {.stamp_ns = prepared.frame.stamp_ns, .frames = ++frames_, .dropped = dropped});
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
  bool begins_anew_{false};
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
