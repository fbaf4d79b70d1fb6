// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "ros2/transform_buffer.hpp"
#include "stereogrid/capture/camera_pair.hpp"
#include "stereogrid/dds/node.hpp"
#include "stereogrid/rosbag/rosbag.hpp"

namespace stereogrid::app {

/// Topics and options of a source.
struct Ros2Setup {
  mcap::Topic left;
  mcap::Topic right;  ///< images, or depth or disparities of the left ones (PairingOptions::has_depth)
  io::Calibration calibration;
  capture::PairingOptions pairing{};
  std::string poses{};  ///< a topic of nav_msgs/Odometry; "": the frames have none, or those of `transforms`
  std::shared_ptr<TransformBuffer> transforms{};  ///< poses of `tracked_frame` in `world_frame`; none: `poses`
  std::string world_frame{};
  std::string tracked_frame{};
  bool is_camera_tracked{false};  ///< `tracked_frame` is the left camera's optical frame, else a vehicle's
  Pose2 posed_from_camera{};      ///< left camera in the frame of the poses
  bool uses_sim_time{false};      ///< time is that of /clock
};

/// Images of two cameras, or of one with depth, as topics of ROS 2, paired by their stamps, which the frames keep. If
/// poses are required, frames without one are left out and counted, as are dropped poses. After a step back of the
/// stamps the stream counts as a new one.
class Ros2Source final : public capture::LiveSource {
 public:
  Ros2Source(std::shared_ptr<dds::Node> node, const Ros2Setup& setup);
  ~Ros2Source() override;

  [[nodiscard]] const Rig& rig() const override;
  [[nodiscard]] std::optional<capture::LiveFrame> next(std::chrono::milliseconds patience) override;
  [[nodiscard]] bool has_ended() const override { return false; }
  [[nodiscard]] std::string fault() const override;
  [[nodiscard]] std::vector<capture::Drop> dropped() const override;

 private:
  struct State;

  void subscribe_images(capture::Side side, const mcap::Topic& topic);

  std::shared_ptr<dds::Node> node_;
  std::shared_ptr<State> state_;  // the node has it, too
};

}  // namespace stereogrid::app
