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
#include "settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <sstream>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "stereogrid/error.hpp"
#include "stereogrid/io/poses.hpp"
#include "stereogrid/io/recording.hpp"

namespace stereogrid_ros {
namespace {

using stereogrid::ConfigError;

/// A node, and the names of the parameters that were read from it.
struct Reader {
  rclcpp_lifecycle::LifecycleNode& node;
  std::set<std::string> names{};
};

/// Throws ConfigError: not of type T. 30 is as good as 30.0.
template <class T>
T value_of(const rclcpp::Parameter& parameter, const T& usual, const std::string& sentence) {
  const rclcpp::ParameterValue value{parameter.get_parameter_value()};
  if constexpr (std::is_same_v<T, double>) {
    if (value.get_type() == rclcpp::ParameterType::PARAMETER_INTEGER) {
      return static_cast<double>(value.get<std::int64_t>());
    }
  }
  if (value.get_type() != rclcpp::ParameterValue{usual}.get_type()) {
    throw ConfigError{"parameter " + parameter.get_name() + " is of the wrong type; it is usually " +
                      rclcpp::to_string(rclcpp::ParameterValue{usual}) + ". " + sentence};
  }
  return value.get<T>();
}

/// Value of a parameter, which is declared if it is not yet. Without a fixed type.
template <class T>
T value_of(Reader& reader, const std::string& name, const T& usual, const std::string& sentence,
           const std::string& allowed = "") {
  rcl_interfaces::msg::ParameterDescriptor descriptor;
  descriptor.description = sentence;
  descriptor.additional_constraints = allowed;  // as text: rclcpp's own check would not name the limits
  descriptor.dynamic_typing = true;
  if (!reader.node.has_parameter(name)) {
    reader.node.declare_parameter(name, rclcpp::ParameterValue{usual}, descriptor);
  }
  reader.names.insert(name);
  return value_of(reader.node.get_parameter(name), usual, sentence);
}

template <class Words>
std::string list_of(const Words& words) {
  std::string list;
  for (const std::string_view word : words) list += (list.empty() ? "" : ", ") + std::string{word};
  return list;
}

template <class T>
void read_field(Reader& reader, const std::string& name, const std::string& sentence, T& value,
                const std::string& range = "") {
  if constexpr (std::is_enum_v<T>) {
    const auto names{names_of(T{})};
    const std::string usual{names.at(static_cast<std::size_t>(value))};
    const std::string given{value_of(reader, name, usual, sentence, list_of(names))};
    const auto* const found{std::ranges::find(names, given)};
    if (found == names.end()) {
      throw ConfigError{"parameter " + name + ": " + given + " (allowed " + list_of(names) + ")."};
    }
    value = static_cast<T>(found - names.begin());
  } else if constexpr (std::is_same_v<T, int>) {
    const std::int64_t given{value_of(reader, name, std::int64_t{value}, sentence, range)};
    value = static_cast<int>(std::clamp<std::int64_t>(given, -1'000'000'000, 1'000'000'000));  // problems() says more
  } else {
    value = value_of(reader, name, value, sentence, range);
  }
}

/// A threshold: 0, or `minimum` to `maximum`.
struct Threshold {
  const char* name;
  double Thresholds::*value;
  double minimum;
  double maximum;
  const char* allowed;
  const char* sentence;
};
constexpr std::array all_thresholds{
    Threshold{"pair_tolerance", &Thresholds::pair_tolerance_s, 0, 60, "0 to 60",
              "Maximum difference of a pair's stamps, s."},
    Threshold{"transform_tolerance", &Thresholds::transform_tolerance_s, 0, 60, "0 to 60",
              "Maximum wait for a transform, s."},
    Threshold{"points_voxel", &Thresholds::points_voxel_m, 0.01, 10, "0, or 0.01 to 10",
              "Side of the voxels with one point each in clouds of points, m; 0: all points."}};

Thresholds read_thresholds(Reader& reader) {
  Thresholds thresholds;
  for (const Threshold& one : all_thresholds) {
    static_cast<void>(value_of(reader, one.name, thresholds.*one.value, one.sentence, one.allowed));
    set_threshold(thresholds, reader.node.get_parameter(one.name));
  }
  return thresholds;
}

/// Throws ConfigError with all problems at once.
stereogrid::Config read_config(Reader& reader) {
  stereogrid::Config config{stereogrid::preset(
      value_of<std::string>(reader, "preset", "default", "default, robot (a low camera), or paper (as published)."))};
  visit_parameters(config, [&](std::string_view group, const stereogrid::Parameter& parameter, auto& value) {
    std::string sentence{parameter.sentence};
    if (!parameter.unit.empty()) sentence += " [" + std::string{parameter.unit} + "]";
    std::ostringstream range;
    range << parameter.minimum << " to " << parameter.maximum;
    read_field(reader, std::string{group} + "." + std::string{parameter.name}, sentence, value, range.str());
  });
  std::string all;
  for (const std::string& problem : problems(config)) all += (all.empty() ? "" : " ") + problem;
  if (!all.empty()) throw ConfigError{all};
  return config;
}

/// Parameter with one of these values; the first is the default.
std::string one_of(Reader& reader, const std::string& name, std::initializer_list<const char*> words,
                   const char* sentence) {
  const std::string given{value_of(reader, name, std::string{*words.begin()}, sentence, list_of(words))};
  if (std::ranges::find(words, given) != words.end()) return given;
  throw ConfigError{"parameter " + name + ": " + given + " (allowed " + list_of(words) + ")."};
}

stereogrid::PipelineOptions read_pipeline(Reader& reader) {
  stereogrid::PipelineOptions pipeline;
  read_field(reader, "threads", "Threads of the pipeline; 0: all cores.", pipeline.threads);
  const std::string device{one_of(reader, "device", {"auto", "cpu", "cuda"}, "auto (a GPU if present), cpu or cuda.")};
  pipeline.back_end = device == "cpu"    ? stereogrid::BackEnd::cpu
                      : device == "cuda" ? stereogrid::BackEnd::cuda
                                         : stereogrid::BackEnd::automatic;
  return pipeline;
}

/// Without slashes at their ends. Throws ConfigError: more than eight, or one twice.
std::vector<std::string> read_cameras(Reader& reader) {
  std::vector<std::string> cameras{
      value_of(reader, "cameras", std::vector<std::string>{}, "Namespaces of several stereo pairs; empty: one.")};
  for (std::string& camera : cameras) {
    while (camera.ends_with('/')) camera.pop_back();
  }
  if (!cameras.empty()) stereogrid::io::check_cameras(cameras);
  return cameras;
}

/// Throws ConfigError: a topic that does not exist, a frame without a name, a voxel out of range.
void check(const stereogrid::messages::FrameMessagesOptions& options) {
  const stereogrid::Rig any_rig{.width_px = 640,
                                .height_px = 480,
                                .focal_px = 500,
                                .cx_px = 320,
                                .cy_px = 240,
                                .baseline_m = 0.1,
                                .camera_height_m = 1};
  stereogrid::messages::Tee nowhere{{}};
  static_cast<void>(stereogrid::messages::FrameMessages{nowhere, any_rig, options});
}

}  // namespace

bool is_autostarted(rclcpp_lifecycle::LifecycleNode& node) {
  Reader reader{node};
  return value_of(reader, "autostart", true,
                  "True: active from the start. False: a lifecycle manager activates the node.");
}

bool set_threshold(Thresholds& thresholds, const rclcpp::Parameter& parameter) {
  const auto* const found{std::ranges::find(all_thresholds, parameter.get_name(), &Threshold::name)};
  if (found == all_thresholds.end()) return false;
  const double given{value_of(parameter, thresholds.*found->value, found->sentence)};
  if (given != 0 && !(given >= found->minimum && given <= found->maximum)) {
    throw ConfigError{"parameter " + parameter.get_name() + ": " + std::to_string(given) + " (allowed " +
                      found->allowed + ")."};
  }
  thresholds.*found->value = given;
  return true;
}

Settings read_settings(rclcpp_lifecycle::LifecycleNode& node) {
  Reader reader{node};
  const auto text = [&](const char* name, const char* usual, const char* sentence) {
    return value_of(reader, name, std::string{usual}, sentence);
  };
  Settings settings;
  settings.config = read_config(reader);
  settings.pipeline = read_pipeline(reader);
  settings.cameras = read_cameras(reader);
  settings.input = one_of(reader, "input", {"stereo", "depth", "disparity"},
                          "stereo (right images), depth (of the left images) or disparity (DisparityImage).");
  settings.image_transport = one_of(reader, "image_transport", {"raw", "compressed"},
                                    "raw or compressed (…/compressed) left and right images.");
  settings.depth_image_transport = one_of(reader, "depth_image_transport", {"raw", "compressedDepth", "compressed"},
                                          "raw, compressedDepth or compressed (PNG) depth images.");
  settings.are_rectified = value_of(reader, "rectified", true, "True: the topics have rectified images.");
  if (settings.input == "disparity" && !settings.are_rectified) {
    throw ConfigError{"parameter rectified: false (allowed true, since disparities are of rectified images)."};
  }
  settings.global_frame = text("global_frame", "odom", "Frame of the filtered grid.");
  settings.robot_base_frame = text("robot_base_frame", "base_footprint",
                                   "Frame whose z = 0 is the road; empty: extrinsics are not read from TF.");
  settings.pipeline.extrinsics_given = !settings.robot_base_frame.empty();
  if (!settings.cameras.empty() && settings.robot_base_frame.empty()) {
    throw ConfigError{"parameter robot_base_frame: empty (allowed a frame with cameras, since TF places them in it)."};
  }
  settings.poses = one_of(reader, "poses", {"tf", "images", "none"},
                          "Source of the camera's poses: tf, images (visual odometry) or none.");
  settings.pipeline.in_world_of_poses = settings.poses == "tf";
  settings.messages.node = std::string{node.get_node_base_interface()->get_fully_qualified_name()}.substr(1);
  settings.messages.world_frame = settings.global_frame;
  settings.messages.vehicle_frame =
      text("vehicle_frame", "stereo_grid", "Published frame on the road below the left camera.");
  settings.messages.camera_frame = settings.messages.vehicle_frame + "_left_optical";
  read_field(reader, "value_scale", "Values of occupancy grids: percent, trinary, nav2 or autoware.",
             settings.messages.scale);
  if (settings.messages.scale == stereogrid::OccupancyScale::autoware && settings.global_frame != "map") {
    throw ConfigError{"parameter global_frame: " + settings.global_frame +
                      " (allowed map with value_scale autoware, since Autoware reads its grids in map)."};
  }
  settings.messages.topics = value_of(reader, "topics", std::vector<std::string>{}, "Published topics; empty: all.");
  settings.thresholds = read_thresholds(reader);
  check(settings.messages);
  settings.names = std::move(reader.names);
  return settings;
}

namespace {

using stereogrid::InputError;

/// 3 × 4, row-major. Throws InputError: the rotation is not of length 1.
std::array<double, 12> matrix_of(const geometry_msgs::msg::Transform& transform) {
  const auto& q{transform.rotation};
  const auto unit{stereogrid::io::unit_quaternion({q.x, q.y, q.z, q.w})};
  if (!unit) {
    throw InputError{"TF",
                     "a rotation is a quaternion of length " +
                         std::to_string(std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w)) +
                         " (allowed 0.99 to 1.01).",
                     "Correct what publishes the transforms."};
  }
  const auto& [x, y, z, w]{*unit};
  const auto& t{transform.translation};
  return {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),     t.x,
          2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),     t.y,
          2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y), t.z};
}

}  // namespace

stereogrid::io::RosCamera camera_of(const sensor_msgs::msg::CameraInfo& info, const std::string& name) {
  if (info.binning_x > 1 || info.binning_y > 1 || info.roi.x_offset != 0 || info.roi.y_offset != 0) {
    throw InputError{name, "images with binning or a roi are unsupported.", "Publish whole images."};
  }
  stereogrid::io::RosCamera camera{
      name,  static_cast<int>(info.width), static_cast<int>(info.height), info.distortion_model, info.d, info.k, info.r,
      info.p};
  if (camera.d.empty() && camera.distortion_model != "equidistant") {  // simulators
    camera.distortion_model = "plumb_bob";
    camera.d.resize(5);
  }
  return camera;
}

stereogrid::Pose2 pose_of(const geometry_msgs::msg::Transform& world_from_camera) {
  const std::array<double, 12> m{matrix_of(world_from_camera)};
  return {m[3], m[7], std::atan2(m[6], m[2])};
}

void set_extrinsics(stereogrid::Rig& rig, const geometry_msgs::msg::Transform& base_from_camera) {
  const std::array<double, 12> m{matrix_of(base_from_camera)};
  const double right_z{m[8]};
  const double down_z{m[9]};
  const double forward_z{m[10]};
  rig.camera_height_m = m[11];
  rig.camera_pitch_rad = std::asin(std::clamp(-forward_z, -1.0, 1.0));
  rig.camera_roll_rad = std::atan2(-right_z, -down_z);
  if (rig.camera_height_m > 0 && std::abs(forward_z) < 0.99) return;
  throw InputError{"TF", "the left camera is not above z = 0 of the base frame, or points straight up or down.",
                   "Set robot_base_frame to a frame on the road (base_footprint), or to \"\"."};
}

}  // namespace stereogrid_ros
