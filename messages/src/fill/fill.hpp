// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stereogrid/camera.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/messages/foxglove_msgs.hpp"
#include "stereogrid/messages/frame_messages.hpp"
#include "stereogrid/messages/geometry_msgs.hpp"
#include "stereogrid/messages/nav_msgs.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"
#include "stereogrid/messages/std_msgs.hpp"
#include "stereogrid/messages/vision_msgs.hpp"
#include "stereogrid/messages/visualization_msgs.hpp"
#include "stereogrid/occupancy_values.hpp"
#include "stereogrid/points.hpp"
#include "stereogrid/result.hpp"

// Conversion of a frame's result. All functions write all fields of a message but its header, and reuse its memory.
namespace stereogrid::messages {

/// Clamped to the range of ROS (1901 to 2038).
[[nodiscard]] builtin_interfaces::Time time_of(std::int64_t stamp_ns);

void fill(nav_msgs::OccupancyGrid& message, const GridGeometry& geometry, const Image<float>& occupancy,
          OccupancyScale scale);
/// Filtered grid of the world with the highest probability of the present and of all predictions in each cell. Unknown
/// cells of predictions do not count; cells unknown in the present are unknown unless a prediction is occupied.
void fill_highest(nav_msgs::OccupancyGrid& message, const FrameResult& result, OccupancyScale scale);
/// With elevation where the result has it, in the world's cells.
void fill(grid_map_msgs::GridMap& message, const FrameResult& result);
/// 7 bytes per cell, 9 with elevation (docs/messages.md).
void fill(foxglove_msgs::Grid& message, const FrameResult& result);

/// In the world frame. `node`: part of what makes their ids unique.
void fill(nav2_dynamic_msgs::ObstacleArray& message, const FrameResult& result, const std::string& node);
/// In the world frame. Copies the message's header into the detections.
void fill(vision_msgs::Detection3DArray& message, const FrameResult& result);
/// In the world frame.
void fill(visualization_msgs::MarkerArray& message, const FrameResult& result, const builtin_interfaces::Time& stamp,
          const std::string& world_frame);

void fill(stereo_msgs::DisparityImage& message, const StageImages& stages, const Rig& level_rig);
/// Points of points_of(), all or those of a label.
void fill(sensor_msgs::PointCloud2& message, std::span<const LabelledPoint> points,
          std::optional<PointLabel> label = std::nullopt);
/// Voxel filter with memory that is reused.
class VoxelFilter {
 public:
  /// Most points of a filtered cloud: 0.13 MB with 16 bytes each, which Linux's default receive buffer of 0.2 MB holds.
  static constexpr std::size_t points_max{8'000};

  /// Keeps the first point of each label in each voxel, within the sides of `grid` (vehicle frame). The side of the
  /// voxels, `voxel_m`, is doubled until at most `points_max` points remain. 0: keeps all points.
  void apply(std::vector<LabelledPoint>& points, const GridGeometry& grid, double voxel_m);

 private:
  void keep_first_of_each(std::vector<LabelledPoint>& points, double voxel_m);

  std::vector<std::uint64_t> voxels_;  // hash set with open addressing
};

/// Calibration of the left camera's rectified images.
void fill(sensor_msgs::CameraInfo& message, const Rig& rig);
void fill(sensor_msgs::CompressedImage& message, std::span<const std::byte> jpeg);

[[nodiscard]] geometry_msgs::Quaternion rotation_about_z(double yaw_rad);
/// Transform from the camera frame (x right, y down, z forward) to the vehicle frame.
[[nodiscard]] geometry_msgs::Transform vehicle_from_camera(const Rig& rig);
[[nodiscard]] geometry_msgs::Transform world_from_vehicle(const Pose2& pose);
/// `moved`: motion of the vehicle in `dt_s`, in its former frame; 0 s: unknown, the velocity is 0.
void fill(nav_msgs::Odometry& message, const Pose2& world_from_vehicle, const Pose2& moved, double dt_s,
          const std::optional<PoseCovariances>& covariances);

/// Frames used and dropped.
struct FrameCounts {
  std::int64_t used{0};
  std::int64_t dropped{0};

  /// True if at least a third was dropped.
  [[nodiscard]] bool are_poor() const { return dropped > 0 && 3 * dropped >= used + dropped; }
};
[[nodiscard]] FrameCounts counts_of(const FrameFacts& facts);
/// `recent`: frames of the last second.
void fill(diagnostic_msgs::DiagnosticArray& message, const FrameResult& result, const FrameFacts& facts,
          const FrameCounts& recent, const FrameMessagesOptions& options);

}  // namespace stereogrid::messages
