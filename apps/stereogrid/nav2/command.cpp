// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "cli/config_options.hpp"
#include "cli/console.hpp"
#include "cli/program.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/calibration.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/run_folder/run_reader.hpp"
#include "stereogrid/messages/nav2_parameters.hpp"

namespace stereogrid::app {
namespace {

struct Nav2ParamsOptions {
  std::string input;
  ConfigOptions config;
  std::string source{"grid"};
  std::vector<double> predict_s;
  std::string node{"stereo_grid"};
  std::vector<std::string> frames{"odom", "base_link"};
};

std::string parameters_of_run(const Nav2ParamsOptions& options, messages::Nav2Options nav2) {
  const ConfigOptions& config{options.config};
  const bool has_settings{!config.file.empty() || !config.settings.empty() || config.preset != ConfigOptions{}.preset};
  if (has_settings || !options.predict_s.empty()) {
    throw ConfigError{"A run has its own settings. Give its calibration instead of the run to change them."};
  }
  if (!io::is_there(std::filesystem::path{options.input} / "run.json")) {
    throw InputError{io::printable_path(options.input), "is not a run.",
                     "Give its calibration file, such as calib.txt, or the folder of `stereogrid run --out`."};
  }
  const io::RunReader run{options.input};
  nav2.has_predictions = !run.predict_s().empty();
  return messages::nav2_local_costmap(run.rig_of(run.frames().back()), run.grid(), nav2);
}

std::string parameters_of_rig(const Nav2ParamsOptions& options, const messages::Nav2Options& nav2) {
  const Rig rig{io::read_calibration(options.input).rig};
  if (rig.width_px <= 0 || rig.height_px <= 0) {
    throw InputError{io::printable_path(options.input), "does not have the size of the images.",
                     "Write a calibration.yaml that names it ('from: FILE') and the size ('image: {width_px: …, "
                     "height_px: …}'), or give the folder of a run."};
  }
  const Pipeline pipeline{config_from(options.config), rig, {.threads = 1}};
  return messages::nav2_local_costmap(rig, pipeline.vehicle_grid(), nav2);
}

void print_parameters(const Nav2ParamsOptions& options) {
  constexpr auto sources{names_of(messages::Nav2Source{})};
  messages::Nav2Options nav2;
  nav2.source = static_cast<messages::Nav2Source>(std::ranges::find(sources, options.source) - sources.begin());
  nav2.node = options.node;
  nav2.world_frame = options.frames[0];
  nav2.robot_frame = options.frames[1];
  nav2.has_predictions = !options.predict_s.empty();
  print("{}", io::is_folder(options.input) ? parameters_of_run(options, nav2) : parameters_of_rig(options, nav2));
}

}  // namespace

void add_nav2_params_command(Command tool) {
  auto options{std::make_shared<Nav2ParamsOptions>()};
  const Command command{
      tool.add_command("nav2-params", "Print parameters of Nav2's local costmap for a rig or a run (docs/ros2.md).")};
  command.add_option("RIG|RUN_DIR", options->input, "Calibration file, or folder of `stereogrid run --out`.")
      .required();
  command.footer(
      "Examples:\n"
      "  stereogrid nav2-params stereo.yaml --preset robot --predict 1 > costmap.yaml\n"
      "  stereogrid nav2-params runs/0009 --source scan");
  add_config_options(command, options->config);
  command.group(Group::messages);
  constexpr auto sources{names_of(messages::Nav2Source{})};
  command
      .add_option("--source", options->source,
                  "Layer of the costmap: StaticLayer on the grid, ObstacleLayer on the scan, "
                  "SpatioTemporalVoxelLayer on the obstacle points, or the layer of ros2/stereogrid_nav2.")
      .one_of({sources.begin(), sources.end()})
      .show_default();
  command.add_option("--predict S,S,...", options->predict_s, "As given to 'run' and 'live'.");
  command.add_option("--ros2-node NAME|NAMESPACE/NAME", options->node, "As given to 'run' and 'live'.").show_default();
  command
      .add_option("--frames GLOBAL,ROBOT", options->frames,
                  "Names of global_frame and robot_base_frame. Otherwise odom,base_link.")
      .expected(2);
  command.callback([options] { print_parameters(*options); });
}

}  // namespace stereogrid::app
