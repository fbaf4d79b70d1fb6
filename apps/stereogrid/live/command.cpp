// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "cli/program.hpp"
#include "live/live.hpp"

namespace stereogrid::app {

void add_live_command(Command tool, int& exit_code) {
  auto options{std::make_shared<LiveOptions>()};
  const Command command{tool.add_command(
      "live", "Show grids of a camera, or of a recording at its own pace, in the browser; Ctrl-C ends it.")};
  command.footer(
      "INPUT is a recording as of 'run', or a camera with --calibration: /dev/video0 /dev/video2 (two devices), "
      "/dev/video0 (both images side by side), 'gst:…' (a GStreamer pipeline: docs/live.md), "
      "or ros2:/NAMESPACE: cameras that publish there (docs/ros2.md).\n\n"
      "Examples:\n"
      "  stereogrid live drives/0009 --loop\n"
      "  stereogrid live /dev/video0 /dev/video2 --calibration stereo.yaml\n"
      "  stereogrid live 'gst:rtspsrc location=rtsp://robot/stereo ! decodebin' \\\n"
      "      --calibration stereo.yaml\n"
      "  stereogrid live ros2:/stereo --poses /odom --ros2");
  add_input_options(command, options->input.input);
  command.group(Group::input);
  command.add_flag("--loop", options->input.loops, "Restart after the last frame.");
  command.add_option("--speed", options->input.speed, "Speed of a recording; 2: twice as fast.")
      .type_name("X")
      .check(number(0.01, 100))
      .show_default();
  add_config_options(command, options->config);
  add_device_options(command, options->device);
  command.group(Group::output);
  add_recording_option(command, options->messages, false);
  command
      .add_option("--predict", options->predict_s,
                  "Horizons in seconds of predicted grids, as topics predicted_grid_<s>.")
      .delimiter(',')
      .type_name("S,S,...");
  add_message_options(command, options->messages);
  command.group(Group::messages);
  command
      .add_option("--ros2-camera-at", options->messages.ros2.camera_at,
                  "For ros2:/… with its poses: position of the left camera in the frame of the poses "
                  "(base_link), m ahead, m to the left, degrees to the left. The vehicle's frame is then stereo_grid, "
                  "and /tf has it.")
      .delimiter(',')
      .expected(3)
      .type_name("X,Y,YAW");
  command.add_flag("--ros2-sim-time", options->messages.ros2.uses_sim_time,
                   "For ros2:/…: use the time of /clock, as with use_sim_time; if it steps back, all begins "
                   "anew.");
  add_page_options(command, options->page);
  command.callback([options, &exit_code] { exit_code = live(*options); });
}

}  // namespace stereogrid::app
