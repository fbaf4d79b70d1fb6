// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stereogrid/camera.hpp"
#include "stereogrid/export.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/image.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"
#include "stereogrid/messages/sink.hpp"
#include "stereogrid/occupancy_values.hpp"
#include "stereogrid/pose_covariances.hpp"
#include "stereogrid/result.hpp"

namespace stereogrid::messages {

struct FrameMessagesOptions {
  std::string node{"stereo_grid"};         ///< topics are /NODE/…; letters, digits and _, separated by /
  std::string world_frame{"odom"};         ///< frame of FrameResult::world
  std::string vehicle_frame{"base_link"};  ///< frame of FrameResult::vehicle
  std::string camera_frame{
      "stereo_left_optical"};                     ///< frame of the left camera; the level rig's has the suffix "_level"
  OccupancyScale scale{OccupancyScale::percent};  ///< scale of all occupancy grids
  /// Published topics by their names in docs/messages.md: "occupancy_grid", "tf", …; empty: all.
  std::vector<std::string> topics{};
  /// Side of the voxels with one point of each label in clouds of points, m, 0.01 … 10; doubled where more than 8,000
  /// points would remain. Points outside the grid are left out. 0: all points.
  double points_voxel_m{0.1};
};

/// Number of unused frames, by reason.
struct Dropped {
  std::string reason;
  std::int64_t frames{0};
};

/// Time from exposure to the finished grid, ms.
struct Latency {
  double now{0};
  double median{0};  ///< median of the last frames; p99: 99th percentile
  double p99{0};
};

/// Published data of a frame that is not in FrameResult.
struct FrameFacts {
  std::int64_t stamp_ns{0};  ///< StereoFrame::stamp_ns
  /// Render the annotated left image and the u-disparity grid of a camera (0: the only or first one) as JPEG; called
  /// only for topics with subscribers. The bytes must be valid until send() returns. Empty function, no bytes: no such
  /// image.
  std::function<std::span<const std::byte>(int camera)> left_jpeg{};
  std::function<std::span<const std::byte>(int camera)> u_disparity_jpeg{};
  std::optional<Latency> latency{};
  std::int64_t frames{0};                        ///< number of used frames so far, including this one
  std::span<const Dropped> dropped{};            ///< frames dropped so far
  std::optional<PoseCovariances> covariances{};  ///< covariances of FrameResult::world_from_vehicle; none: unknown
};

/// Publishes the result of each frame as ROS 2 messages; docs/messages.md lists topics, types and frames. A channel is
/// added with the first message of its topic. Topics of several cameras (FrameResult::cameras) are below their names,
/// such as front/left/camera_info, in frames such as front_stereo_left_optical.
class STEREOGRID_EXPORT FrameMessages {
 public:
  /// `rig`: Pipeline::rig(). `sink`: publisher that outlives this object. Throws InputError: problems of the rig;
  /// ConfigError: a name that is invalid in ROS, an unknown topic.
  FrameMessages(Sink& sink, const Rig& rig, const FrameMessagesOptions& options = {});
  FrameMessages(FrameMessages&&) noexcept;
  FrameMessages& operator=(FrameMessages&&) noexcept;
  ~FrameMessages();

  /// Without FrameResult::stages, their topics have no message. Throws the publisher's exceptions; InputError: no
  /// result of a pipeline, or stages of another rig.
  void send(const FrameResult& result, const FrameFacts& facts);

  /// Sets the current Pipeline::rig() after the pipeline has estimated extrinsics. Several cameras have those of
  /// FrameResult::cameras. Throws InputError: its problems.
  void set_rig(const Rig& rig);

  /// Sets FrameMessagesOptions::points_voxel_m from the next frame on. Throws ConfigError: out of range.
  void set_points_voxel(double side_m);

 private:
  struct STEREOGRID_HIDDEN Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// Nearest obstacle at each bearing in the cameras' fields of view, relative to the origin of the vehicle frame
/// (docs/messages.md, topic `scan`). Writes all fields but the header; reuses the message's memory.
///
/// `geometry`: in the vehicle frame; `occupancy` has its size. `rigs`: of all cameras (rigs_of()). Throws InputError:
/// none, or more than 8.
STEREOGRID_EXPORT void fill(sensor_msgs::LaserScan& message, std::span<const Rig> rigs, const GridGeometry& geometry,
                            View<const float> occupancy);

}  // namespace stereogrid::messages
