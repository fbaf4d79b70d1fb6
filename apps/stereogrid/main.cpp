// SPDX-License-Identifier: Apache-2.0

#include "cli/program.hpp"

namespace {

using namespace stereogrid::app;

void describe(CLI::App& program, int& exit_code) {
  const Command tool{program};
  tool.description("Stereo camera in, probabilistic occupancy grid with velocities out.");
  tool.footer(
      "INPUT is a KITTI odometry sequence, a KITTI raw drive, a plain folder (left/ right/ calibration.yaml), "
      "a ROS 2 bag, a video of both cameras, LEFT RIGHT (images or videos) with --calibration, or a built-in scene "
      "such as 'scene:street?frames=60&seed=3'. docs/input.md lists all kinds.\n\n"
      "Exit codes: 0 done, 64 wrong usage, 65 bad input, 70 internal error, 75 try again (disk full, device missing, "
      "input unavailable, too little memory or threads, folder locked by another stereogrid); 129, 130, 143 stopped "
      "by a closed terminal, Ctrl-C or kill: frames are complete, continue with --resume; 141 output closed, as by "
      "'| head'.\n\n"
      "Examples:\n"
      "  stereogrid run scene:street --out runs/street --pictures\n"
      "  stereogrid view runs/street\n"
      "  stereogrid info drives/0009\n"
      "  stereogrid run drives/0009 --out runs/0009 --video runs/0009.gif\n"
      "  stereogrid export runs/0009 --nav2-map maps/0009 --laserscan scans/0009.csv");
  tool.require_command();
  add_run_command(tool, exit_code);
  add_simulate_command(tool, exit_code);
  add_evaluate_command(tool, exit_code);
  add_export_command(tool, exit_code);
  add_info_command(tool, exit_code);
  add_live_command(tool, exit_code);
  add_view_command(tool, exit_code);
  add_config_command(tool);
  add_nav2_params_command(tool);
  add_completion_command(tool);
}

}  // namespace

int main(int argc, char** argv) {
  return run_program(argc, argv, "stereogrid", describe);
}
