// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "live/live.hpp"
#include "ros2/ros2_source.hpp"
#include "stereogrid/dds/node.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/mcap/bag.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/geometry_msgs.hpp"
#include "stereogrid/messages/nav_msgs.hpp"
#include "stereogrid/messages/std_msgs.hpp"

namespace stereogrid::app {
namespace {

using namespace std::chrono_literals;
using messages::tf2_msgs::TFMessage;

constexpr std::size_t dynamic_depth{100};  // as tf2_ros has it
constexpr std::size_t static_depth{100};
constexpr auto static_patience{1s};  // patience for extrinsics without poses
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

/// First message on a topic, which is waited for.
std::vector<std::byte> wait_for_message(dds::Node& node, const mcap::Topic& topic) {
  NewestMessages newest{node};
  newest.add(topic);
  Waiting waiting;
  for (;;) {
    if (auto cdr{newest.of(topic.name)}) return *std::move(cdr);
    std::string sentence{fmt::format("no message has come on {}.", io::printable(topic.name))};
    for (const dds::PublishedTopic& one : node.topics()) {
      if (one.name != topic.name || one.type == topic.type) continue;
      sentence += fmt::format(" It is of type {}, not {}.", one.type, topic.type);
    }
    waiting.print(sentence);
  }
}

std::string frame_of_images(dds::Node& node, const mcap::Topic& images) {
  const std::vector<std::byte> cdr{wait_for_message(node, images)};
  messages::std_msgs::Header header;
  messages::CdrReader reader{cdr, messages::std_msgs::Header::type_name};
  reader("header", header);
  return header.frame_id;
}

/// Waits until TF has the place of a camera on the robot; `is_one_of_several`: there is no option for it. Throws
/// InputError: the camera has no frame.
void wait_for_place(rosbag::TransformBuffer& transforms, const std::string& base, const std::string& camera_frame,
                    const mcap::Topic& images, bool is_one_of_several) {
  const char* const alternative{is_one_of_several ? "Publish it (robot_state_publisher, static_transform_publisher)."
                                                  : "Publish it, or give --ros2-camera-at X,Y,YAW."};
  if (camera_frame.empty()) {
    throw InputError{io::printable(images.name), "its messages have no frame_id: the camera's place is unknown.",
                     alternative};
  }
  Waiting waiting;
  while (!transforms.are_connected(base, camera_frame, 0ms)) {
    waiting.print(fmt::format("TF does not connect {} with {}: the camera's place is unknown. {}",
                              io::printable(base, 60), io::printable(camera_frame, 60), alternative));
  }
}

/// Sets height, pitch and roll from base_footprint, else from the robot's frame, to the camera's frame; logs it.
/// Returns false and changes nothing where TF has neither, or the camera is not above z = 0 there.
bool set_extrinsics_of_tf(Rig& rig, rosbag::TransformBuffer& transforms, const std::string& base,
                          const std::string& camera_frame) {
  if (camera_frame.empty() || !transforms.are_connected(base, camera_frame, static_patience)) {
    spdlog::warn(
        "TF does not connect {} with the camera's frame \"{}\": its height and pitch are estimated from images",
        io::printable(base, 60), io::printable(camera_frame, 60));
    return false;
  }
  const std::string ground{rosbag::ground_frame(transforms, base, camera_frame)};
  if (!rosbag::set_extrinsics(rig, transforms.newest(ground, camera_frame, 0ms))) {
    spdlog::warn("TF: {} is not above z = 0 of {}, or points straight up or down; its extrinsics are not used",
                 io::printable(camera_frame, 60), io::printable(ground, 60));
    return false;
  }
  spdlog::info("extrinsics of TF ({} → {}), checked against the road: height {:.2f} m, pitch {:.1f}°, roll {:.1f}°",
               io::printable(ground, 60), io::printable(camera_frame, 60), rig.camera_height_m,
               rig.camera_pitch_rad * degrees_per_radian, rig.camera_roll_rad * degrees_per_radian);
  return true;
}

/// A stereo pair, or a camera with depth.
struct Ros2Camera {
  std::string name;  ///< its namespace
  FoundImages found;
  io::Calibration calibration;
  std::string frame;  ///< left camera's; "": not looked for, or its messages have none
};

/// Options of each camera, whose paths are "ros2:" and its namespace.
std::vector<InputOptions> cameras_of(const InputOptions& options) {
  if (options.cameras.empty()) return {options};
  std::string root{options.paths.front().substr(ros2_scheme.size())};
  while (root.ends_with('/')) root.pop_back();
  std::vector<std::string> namespaces;
  for (const std::string& camera : options.cameras) namespaces.push_back(rosbag::namespace_of(root, camera));
  io::check_cameras(namespaces);
  std::vector<InputOptions> cameras;
  for (const std::string& name_space : namespaces) {
    cameras.push_back(options);
    cameras.back().paths = {std::string{ros2_scheme} + name_space};
  }
  return cameras;
}

/// Waits for images and calibration, which are reported.
Ros2Camera wait_for_camera(dds::Node& node, const InputOptions& options, bool needs_frame) {
  Ros2Camera camera{options.paths.front().substr(ros2_scheme.size()), wait_for_images(node, options), {}, {}};
  auto [calibration, frame]{live_calibration(node, options, camera.found)};
  if (frame.empty() && (needs_frame || !calibration.has_extrinsics)) frame = frame_of_images(node, camera.found.left);
  camera.calibration = std::move(calibration);
  camera.frame = std::move(frame);
  return camera;
}

/// Sets and logs extrinsics of TF: those of cameras whose calibration has none, or the places of all (`are_placed`).
/// Returns true if all were measured: by the calibration, or above base_footprint.
bool find_extrinsics(std::vector<Ros2Camera>& cameras, rosbag::TransformBuffer& transforms, const std::string& base,
                     bool are_placed) {
  bool are_measured{true};
  for (Ros2Camera& camera : cameras) {
    io::Calibration& calibration{camera.calibration};
    const std::string images{io::printable(camera.found.left.name)};
    if (are_placed)
      spdlog::info("{}: {}", images, rosbag::place_camera(calibration, transforms, base, camera.frame, images));
    are_measured = are_measured && calibration.has_extrinsics;
    if (are_placed) {
      calibration.has_extrinsics = true;
    } else if (!calibration.has_extrinsics) {
      calibration.has_extrinsics = set_extrinsics_of_tf(calibration.rig, transforms, base, camera.frame);
    }
  }
  return are_measured;
}

/// Subscribes to the images of all cameras. `setup`: without those of one camera.
std::unique_ptr<capture::LiveSource> open_sources(const std::shared_ptr<dds::Node>& node,
                                                  const std::vector<Ros2Camera>& cameras, Ros2Setup setup) {
  std::vector<capture::NamedSource> sources;
  for (const Ros2Camera& camera : cameras) {
    spdlog::info("{} and {}, {}", io::printable(camera.found.left.name), rosbag::second_of(camera.found.images),
                 camera.calibration.kind);
    log_calibration(camera.calibration);
    setup.left = camera.found.left;
    setup.right = camera.found.right;
    setup.calibration = camera.calibration;
    setup.pairing.has_depth = camera.found.images.has_depth();
    setup.camera_frame = camera.frame;
    sources.push_back({camera.name, std::make_unique<Ros2Source>(node, setup)});
  }
  return capture::join_cameras(std::move(sources));
}

void check_options(const InputOptions& options, const Ros2Options& ros2) {
  if (!options.cameras.empty() &&
      (!options.calibration.empty() || !options.mask.empty() || !options.left_topic.empty() ||
       !options.right_topic.empty() || !ros2.camera_at.empty())) {
    throw ConfigError{
        "--calibration, --mask, --left-topic, --right-topic and --ros2-camera-at are of one camera, but --cameras "
        "lists "
        "several."};
  }
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

/// Pose of the camera in the frame of the poses, as given by the user.
std::optional<Pose2> camera_of_user(const Ros2Options& ros2, bool has_poses) {
  if (ros2.camera_at.empty()) return std::nullopt;
  if (!has_poses) {
    throw ConfigError{
        "--ros2-camera-at says where the camera is in the frame of poses, but there are none: give --poses, too."};
  }
  constexpr double farthest_m{1000};
  for (const double value : ros2.camera_at) {
    if (!(std::abs(value) <= farthest_m)) throw ConfigError{"--ros2-camera-at: metres and degrees, up to 1000."};
  }
  return Pose2{ros2.camera_at[0], ros2.camera_at[1], ros2.camera_at[2] / degrees_per_radian};
}

/// The vehicle frame of poses has a name of its own, unless the camera is at the origin of the robot's frame.
void name_frames(Ros2Options& ros2, const std::string& base, const std::optional<Pose2>& camera) {
  if (ros2.frames.empty()) ros2.frames = {"odom", "stereo_grid"};
  if (ros2.frames[1] != base) return;
  if (camera != Pose2{}) {
    throw ConfigError{fmt::format(
        "--ros2-frames: {} is the robot's frame, but the vehicle frame lies below the left camera. Give another name, "
        "or --ros2-camera-at 0,0,0 if both are the same.",
        io::printable(base, 60))};
  }
  ros2.leaves_tf = true;
}

/// Sets the robot's frame and, unless the user names it, the world's to those of the odometry, which is waited for.
void read_frames_of_odometry(dds::Node& node, const std::string& topic, std::string& base, std::string* world) {
  mcap::Topic poses;
  poses.name = topic;
  poses.type = messages::nav_msgs::Odometry::type_name;
  messages::nav_msgs::Odometry odometry;
  messages::decode(wait_for_message(node, poses), odometry);
  if (!odometry.child_frame_id.empty()) base = odometry.child_frame_id;
  if (world != nullptr && !odometry.header.frame_id.empty()) *world = odometry.header.frame_id;
}

}  // namespace

bool is_ros2(const std::string& source) {
  return source.starts_with(ros2_scheme);
}

LiveInput open_ros2_input(const InputOptions& options, FusedSource fused, Ros2Options& ros2) {
  check_options(options, ros2);
  const std::vector<InputOptions> each{cameras_of(options)};
  const bool is_of_tf{options.poses == "tf"};
  const bool has_poses{is_of_tf || options.poses.starts_with('/')};
  const bool are_placed{!options.cameras.empty()};  // in the robot's frame, which has the poses, too
  const std::optional<Pose2> camera{are_placed ? std::optional{Pose2{}} : camera_of_user(ros2, has_poses)};
  const bool is_world_named{!ros2.frames.empty()};
  std::string base{"base_link"};
  if (has_poses) name_frames(ros2, base, camera);
  std::shared_ptr<dds::Node> node{open_ros2_node(ros2)};
  const std::shared_ptr<rosbag::TransformBuffer> transforms{subscribe_transforms(*node)};
  const bool is_place_of_tf{are_placed || (has_poses && !camera)};
  const bool are_grids_fused{fused == FusedSource::grids};
  std::vector<Ros2Camera> cameras;
  for (const InputOptions& one : each)
    cameras.push_back(wait_for_camera(*node, one, is_place_of_tf || are_grids_fused));
  Ros2Camera& first{cameras.front()};
  if (is_place_of_tf && has_poses && !is_of_tf) {
    read_frames_of_odometry(*node, options.poses, base, is_world_named ? nullptr : &ros2.frames[0]);
    name_frames(ros2, base, camera);
  }
  if (is_place_of_tf) {
    for (const Ros2Camera& one : cameras) wait_for_place(*transforms, base, one.frame, one.found.left, are_placed);
  }
  LiveInput live;
  live.recording.extrinsics_given = find_extrinsics(cameras, *transforms, base, are_placed);
  if (has_poses) {
    spdlog::info("poses of {}: {} in {} on {}", is_of_tf && !camera ? "the camera" : "the vehicle",
                 io::printable(is_of_tf && !camera ? first.frame : base, 60), io::printable(ros2.frames[0], 60),
                 is_of_tf ? "/tf" : io::printable(options.poses));
  }
  if (are_grids_fused) {
    const Pose2 place{are_placed ? camera_place(first.calibration.rig) : Pose2{}};
    live.recording.grid_at =
        subscribe_grids(*node, options, {first.frame, has_poses ? ros2.frames[0] : "", place, transforms});
  }
  live.kind = options.paths.front();
  live.in_world_of_poses = has_poses;
  live.poses = has_poses ? PoseSource::input : options.poses == "none" ? PoseSource::none : PoseSource::odometry;
  live.mask = mask_of(options.mask, first.calibration);
  const std::chrono::duration<double, std::milli> tolerance{options.pair_tolerance_ms};
  Ros2Setup setup;
  setup.pairing.tolerance = std::chrono::duration_cast<std::chrono::nanoseconds>(tolerance);
  setup.poses = has_poses && !is_of_tf ? options.poses : "";
  setup.world_frame = is_of_tf ? ros2.frames[0] : "";
  setup.base_frame = base;
  setup.transforms = transforms;
  setup.base_from_camera = camera;
  setup.uses_sim_time = ros2.uses_sim_time;
  live.source = open_sources(node, cameras, setup);
  return live;
}

}  // namespace stereogrid::app
