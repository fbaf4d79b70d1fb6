// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>

#include "cli/program.hpp"
#include "run/run.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/run_folder/run_record.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::app {
namespace {

void add_output_options(Command command, RunOptions& options) {
  command.group(Group::output);
  command.add_option("--out,-o DIR", options.folder, "Folder of the results (docs/format.md).").required();
  command
      .add_option("--pictures [png|svg]", options.pictures,
                  "Write a visualisation of every frame, too: pictures/NAME.png, or .svg for print.")
      .optional_value("png")
      .one_of({"png", "svg"});
  command.add_option("--video FILE.mp4|FILE.gif|FILE.webp", options.video,
                     "Write the visualisations as a video, too, with ffmpeg: .gif, .webp, or else H.264.");
  command.add_flag("--view", options.view, "Show the results in the browser during the run, too.");
  add_recording_option(command, options.messages, true);
  command.add_flag("--resume", options.resume, "Continue a stopped run, with the same results.");
}

void add_grid_options(Command command, RunOptions& options) {
  add_fuse_option(command, options.fuse);
  command.add_option("--predict S,S,...", options.predict_s,
                     "Horizons in seconds of predicted grids: predictions/NAME.npz.");
}

void add_file_options(Command command, RunOptions& options) {
  command.group(Group::files);
  command.add_flag("--compact", options.compact,
                   "Small grids: in the vehicle's frame only, without covariances, occupancies to 1/256, velocities to "
                   "1/16 m/s, ages to 1/64 s.");
  command.add_option("--layers LAYER,LAYER,...", options.layers,
                     "Only these arrays of grids/NAME.npz: occupancy, velocity, age_s and so on (docs/format.md). Left "
                     "out: all.");
  command
      .add_option("--every N", options.every,
                  "Process all frames, but write only those whose index in the input is a multiple of N.")
      .check(whole_number(1, 1'000'000'000))
      .show_default();
  command.add_flag("--save-stages", options.save_stages,
                   "Write intermediate results of the stages, too: stages/NAME.npz.");
}

void add_long_run_options(Command command, RunOptions& options) {
  command.group(Group::long_runs);
  command.add_option("--frames FIRST:LAST", options.frames,
                     std::string{frame_range_help} + " The world frame is that of the whole input.");
  command
      .add_option("--warm-up N", options.warm_up,
                  "Frames processed before the first of --frames and not written, so that the "
                  "filter starts with their state.")
      .within(0, 1'000'000'000)
      .show_default();
  command
      .add_option("--input-wait S", options.input_wait_s,
                  "Maximum time to load a frame, as for a file system that hangs. Exit code 75.")
      .within(1, 1'000'000)
      .show_default();
  command
      .add_option("--checkpoint-every N", options.checkpoint_every,
                  "Interval in frames at which the state is saved for --resume; 0: never, so that --resume "
                  "has to work through the frames from the first one on again.")
      .within(0, 1'000'000'000)
      .show_default();
}

}  // namespace

std::vector<std::string> layers_of(const RunOptions& options) {
  const std::vector<std::string> there{io::grid_arrays(options.compact)};
  std::vector<bool> wanted(there.size());
  for (const std::string& layer : options.layers) {
    const auto found{std::ranges::find(there, layer == "age" || layer == "world_age" ? layer + "_s" : layer)};
    if (found == there.end()) {
      throw ConfigError{fmt::format("--layers {}: there is no such layer{}. There are: {}.", io::printable(layer),
                                    options.compact ? " in --compact" : "", fmt::join(there, ", "))};
    }
    wanted[static_cast<std::size_t>(found - there.begin())] = true;
  }
  std::vector<std::string> layers;
  for (std::size_t i{0}; i < there.size(); ++i) {
    if (wanted[i]) layers.push_back(there[i]);
  }
  return layers;
}

void add_run_command(Command tool, int& exit_code) {
  auto options{std::make_shared<RunOptions>()};
  const Command command{tool.add_command("run", "Compute occupancy grids and obstacles from a stereo drive.")};
  add_input_options(command, options->input);
  add_output_options(command, *options);
  add_config_options(command, options->config);
  add_grid_options(command, *options);
  add_device_options(command, options->device);
  add_long_run_options(command, *options);
  add_file_options(command, *options);
  add_message_options(command, options->messages);
  add_page_options(command, options->page);
  for (const char* name : {"--listen", "--allow-origin"}) command.option(name).needs(command.option("--view"));
  command.callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stereogrid::app
