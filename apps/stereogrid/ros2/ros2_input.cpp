// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "live/live.hpp"
#include "ros2/pose_buffer.hpp"
#include "ros2/ros2_source.hpp"
#include "stereogrid/dds/node.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/rectifier.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/mcap/bag.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/geometry_msgs.hpp"
#include "stereogrid/messages/std_msgs.hpp"

namespace stereogrid::app {
namespace {

using namespace std::chrono_literals;
using messages::tf2_msgs::TFMessage;

constexpr std::size_t dynamic_depth{100};  // as tf2_ros has it
constexpr std::size_t static_depth{100};
constexpr auto image_patience{1s};
constexpr auto static_patience{100ms};  // they have been received since before the images were found
constexpr double degrees_per_radian{180 / 3.14159265358979323846};

/// A buffer that receives /tf and /tf_static while the node exists.
std::shared_ptr<rosbag::TransformBuffer> subscribe_transforms(dds::Node& node) {
  auto buffer{std::make_shared<rosbag::TransformBuffer>()};
  for (const bool is_static : {false, true}) {
    node.subscribe(
        is_static ? "/tf_static" : "/tf", std::string{TFMessage::type_name}, is_static ? static_depth : dynamic_depth,
        [buffer, is_static](std::span<const std::byte> cdr) {
          TFMessage message;
          messages::decode(cdr, message);
          const std::string dropped{buffer->add(message, is_static)};
          if (!dropped.empty()) spdlog::warn("{}", dropped);
        },
        is_static);
  }
  return buffer;
}

/// frame_id of the next image on a topic; "": none has come within a second, or it has none.
std::string frame_of_images(dds::Node& node, const mcap::Topic& images) {
  NewestMessages newest{node};
  newest.add(images);
  const auto end{std::chrono::steady_clock::now() + image_patience};
  for (; std::chrono::steady_clock::now() < end; std::this_thread::sleep_for(10ms)) {
    const auto cdr{newest.of(images.name)};
    if (!cdr) continue;
    messages::std_msgs::Header header;
    messages::CdrReader reader{*cdr, messages::std_msgs::Header::type_name};
    reader("header", header);
    return header.frame_id;
  }
  return "";
}

/// Sets height, pitch and roll from base_footprint or base_link to the camera's frame; logs it. Returns false and
/// changes nothing where TF has neither, or the camera is not above z = 0 there.
bool set_extrinsics_of_tf(Rig& rig, rosbag::TransformBuffer& transforms, const std::string& camera_frame) {
  if (camera_frame.empty() || !transforms.are_connected("base_link", camera_frame, static_patience)) return false;
  // base_link may be above the road
  const char* const base{transforms.are_connected("base_footprint", camera_frame, static_patience) ? "base_footprint"
                                                                                                   : "base_link"};
  if (!rosbag::set_extrinsics(rig, transforms.newest(base, camera_frame, 0ms))) {
    spdlog::warn("TF: {} is not above z = 0 of {}, or points straight up or down; its extrinsics are not used",
                 io::printable(camera_frame, 60), base);
    return false;
  }
  spdlog::info("extrinsics of TF ({} → {}), checked against the road: height {:.2f} m, pitch {:.1f}°, roll {:.1f}°",
               base, io::printable(camera_frame, 60), rig.camera_height_m, rig.camera_pitch_rad * degrees_per_radian,
               rig.camera_roll_rad * degrees_per_radian);
  return true;
}

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
  const std::shared_ptr<rosbag::TransformBuffer> transforms{subscribe_transforms(*node)};
  const FoundImages found{wait_for_images(*node, options)};
  io::Calibration calibration{live_calibration(*node, options, found)};
  const std::string camera_frame{frame_of_images(*node, found.left)};
  const bool are_extrinsics_given{calibration.has_extrinsics};
  if (!are_extrinsics_given) {
    calibration.has_extrinsics = set_extrinsics_of_tf(calibration.rig, *transforms, camera_frame);
  }
  const std::string world{is_of_tf ? ros2.frames[0] : ""};
  const bool is_camera_tracked{is_of_tf && ros2.camera_at.empty() && ros2.frames[1] != "base_link" &&
                               !camera_frame.empty() &&
                               transforms->are_connected("base_link", camera_frame, static_patience)};
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
