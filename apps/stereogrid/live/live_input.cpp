// SPDX-License-Identifier: Apache-2.0
#include "live/live.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>

#include "stereogrid/capture/camera_pair.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/calibration.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::app {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view gstreamer{"gst:"};
constexpr std::string_view video{"v4l2:"};

bool is_camera(const std::string& path) {
  return path.starts_with(gstreamer) || path.starts_with(video) || path.starts_with("/dev/video");
}

io::Calibration calibration_of(const InputOptions& options) {
  if (options.calibration.empty()) {
    throw ConfigError{
        "A camera needs --calibration FILE: calibration.yaml, or one of KITTI, ROS, OpenCV or Kalibr (docs/input.md)."};
  }
  io::Calibration calibration{io::read_calibration(options.calibration)};
  log_calibration(calibration);
  return calibration;
}

void check_camera_options(const LiveInputOptions& options) {
  const InputOptions& input{options.input};
  if (!input.disparities.empty() || !input.depth.empty() || !input.left_topic.empty() || !input.right_topic.empty() ||
      !input.cameras.empty()) {
    throw ConfigError{
        "--disparities, --depth, --left-topic, --right-topic and --cameras are of recordings and ROS 2, but SOURCE is "
        "a "
        "camera."};
  }
  if (options.loops && !input.paths.front().starts_with(gstreamer)) {
    throw ConfigError{"--loop is of recordings and of files of GStreamer, but SOURCE is a camera."};
  }
  if (options.speed != 1) throw ConfigError{"--speed is of recordings, but SOURCE is a camera."};
  if (!input.poses.empty() && input.poses != "odometry" && input.poses != "none") {
    throw ConfigError{"--poses of a camera are 'odometry' (found from the images) or 'none'."};
  }
}

std::vector<std::string> devices_of(const std::vector<std::string>& paths) {
  if (!paths.front().starts_with(video)) return paths;
  const std::string given{paths.front().substr(video.size())};
  const std::size_t comma{given.find(',')};
  if (comma == std::string::npos) return {given};
  return {given.substr(0, comma), given.substr(comma + 1)};
}

std::unique_ptr<capture::LiveSource> open_camera(const LiveInputOptions& options, const io::Calibration& calibration) {
  const std::vector<std::string>& paths{options.input.paths};
  const std::chrono::duration<double, std::milli> tolerance{options.input.pair_tolerance_ms};
  const capture::CameraOptions camera{
      .pairing = {.tolerance = std::chrono::duration_cast<std::chrono::nanoseconds>(tolerance)},
      .loops = options.loops};
  const std::string& first{paths.front()};
  if (first.starts_with(gstreamer)) {
    return capture::open_gstreamer(first.substr(gstreamer.size()), calibration, camera);
  }
  const std::vector<std::string> devices{devices_of(paths)};
  return capture::open_gstreamer(
      capture::v4l2_pipeline(devices.front(), devices.size() > 1 ? devices.back() : "", calibration.rig), calibration,
      camera);
}

LiveInput open_camera_input(const LiveInputOptions& options) {
  check_camera_options(options);
  const io::Calibration calibration{calibration_of(options.input)};
  LiveInput live;
  live.poses = options.input.poses == "none" ? PoseSource::none : PoseSource::odometry;
  live.mask = mask_of(options.input.mask, calibration);
  live.source = open_camera(options, calibration);
  live.recording.extrinsics_given = calibration.has_extrinsics;
  live.kind = options.input.paths.size() == 1 ? options.input.paths.front()
                                              : options.input.paths.front() + " " + options.input.paths.back();
  return live;
}

}  // namespace

LiveInput open_live_input(const LiveInputOptions& options, Ros2Options& ros2) {
  if (is_ros2(options.input.paths.front())) {
    if (options.loops || options.speed != 1) {
      throw ConfigError{"--loop and --speed are of recordings, but SOURCE is ROS 2."};
    }
    return open_ros2_input(options.input, fused_source(options.fuse), ros2);
  }
  refuse_without_node(ros2);
  if (ros2.uses_sim_time) throw ConfigError{"--ros2-sim-time is of ros2:/…, but SOURCE is none."};
  if (!ros2.camera_at.empty()) throw ConfigError{"--ros2-camera-at is of ros2:/…, but SOURCE is none."};
  if (is_camera(options.input.paths.front())) return open_camera_input(options);
  LiveInput live;
  live.recording = open_input(options.input);
  log_input(live.recording);
  live.poses = live.recording.poses;
  live.mask = live.recording.mask;

  live.kind = options.input.paths.front();
  live.source = capture::replay(*live.recording.source, {.loops = options.loops, .speed = options.speed});
  return live;
}

}  // namespace stereogrid::app
