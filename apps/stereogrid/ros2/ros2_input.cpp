// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "ros2/ros2_input.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <cmath>
#include <utility>

#include "ros2/ros2_calibration.hpp"
#include "ros2/ros2_source.hpp"
#include "ros2/ros2_topics.hpp"
#include "ros2/ros2_transforms.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/mask.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::app {
namespace {

void check_options(const InputOptions& options) {
  if (!options.disparities.empty() || !options.depth.empty()) {
    throw ConfigError{"--disparities and --depth are of recordings, but SOURCE is ROS 2."};
  }
  const std::string& poses{options.poses};
  if (poses.empty() || poses == "odometry" || poses == "none" || poses == "tf" || poses.starts_with('/')) return;
  throw ConfigError{
      "--poses with ROS 2 are 'odometry' (found from the images), 'none', 'tf' (odom → the camera on /tf), or a topic "
      "of "
      "nav_msgs/Odometry, such as /odom."};
}

// Pose of the camera in the frame of the poses; if it is not the origin, the vehicle frame has another name.
Pose2 camera_in(Ros2Options& ros2, bool has_poses) {
  if (ros2.camera_at.empty()) return {};
  if (!has_poses) {
    throw ConfigError{
        "--ros2-camera-at says where the camera is in the frame of poses, but there are none: give --poses, too."};
  }
  constexpr double farthest_m{1000};
  for (const double value : ros2.camera_at) {
    if (!(std::abs(value) <= farthest_m)) throw ConfigError{"--ros2-camera-at: metres and degrees, up to 1000."};
  }
  if (ros2.frames.empty()) ros2.frames = {"odom", "stereo_grid"};
  constexpr double degree{3.14159265358979323846 / 180};
  return {ros2.camera_at[0], ros2.camera_at[1], ros2.camera_at[2] * degree};
}

}  // namespace

bool is_ros2(const std::string& source) {
  return source.starts_with(ros2_scheme);
}

LiveInput open_ros2_input(const InputOptions& options, Ros2Options& ros2) {
  check_options(options);
  const bool has_poses{options.poses == "tf" || options.poses.starts_with('/')};
  const Pose2 camera{camera_in(ros2, has_poses)};
  const bool is_of_tf{options.poses == "tf"};
  if (is_of_tf && ros2.frames.empty()) ros2.frames = {"odom", "stereo_grid"};
  // the odometry publishes the robot's own frame
  if (has_poses && (ros2.frames.empty() || ros2.frames[1] == "base_link")) ros2.leaves_tf = true;
  std::shared_ptr<dds::Node> node{open_ros2_node(ros2)};
  const std::shared_ptr<TransformBuffer> transforms{subscribe_transforms(*node)};
  const FoundImages found{wait_for_images(*node, options)};
  io::Calibration calibration{live_calibration(*node, options, found)};
  const std::string camera_frame{frame_of_images(*node, found.left)};
  const bool are_extrinsics_given{calibration.has_extrinsics};
  if (!are_extrinsics_given) {
    calibration.has_extrinsics = set_extrinsics_of_tf(calibration.rig, *transforms, camera_frame);
  }
  const std::string world{is_of_tf ? ros2.frames[0] : ""};
  const bool is_camera_tracked{is_of_tf && ros2.camera_at.empty() && ros2.frames[1] != "base_link" &&
                               !camera_frame.empty() && are_connected(*transforms, "base_link", camera_frame)};
  if (is_of_tf) {
    spdlog::info("poses of {}: {} in {} on /tf", is_camera_tracked ? "the camera" : "the vehicle",
                 is_camera_tracked ? io::printable(camera_frame, 60) : "base_link", io::printable(world, 60));
  }
  const std::chrono::duration<double, std::milli> tolerance{options.pair_tolerance_ms};
  const Ros2Setup setup{.left = found.left,
                        .right = found.right,
                        .calibration = std::move(calibration),
                        .pairing = {.tolerance = std::chrono::duration_cast<std::chrono::nanoseconds>(tolerance),
                                    .has_depth = found.images.has_depth()},
                        .poses = has_poses && !is_of_tf ? options.poses : "",
                        .transforms = is_of_tf ? transforms : nullptr,
                        .world_frame = world,
                        .tracked_frame = is_camera_tracked ? camera_frame : "base_link",
                        .is_camera_tracked = is_camera_tracked,
                        .posed_from_camera = camera,
                        .uses_sim_time = ros2.uses_sim_time};
  spdlog::info("{} and {}, {}", io::printable(setup.left.name), rosbag::second_of(found.images),
               setup.calibration.kind);
  log_calibration(setup.calibration);
  LiveInput live;
  live.kind = options.paths.front();
  live.in_world_of_poses = has_poses;
  live.recording.extrinsics_given = are_extrinsics_given;
  live.poses = has_poses ? PoseSource::input : options.poses == "none" ? PoseSource::none : PoseSource::odometry;
  const std::filesystem::path mask{options.mask.empty() ? setup.calibration.mask : std::filesystem::path{options.mask}};
  if (!mask.empty()) live.mask = io::read_mask(mask, setup.calibration);
  live.source = std::make_unique<Ros2Source>(std::move(node), setup);
  return live;
}

}  // namespace stereogrid::app
