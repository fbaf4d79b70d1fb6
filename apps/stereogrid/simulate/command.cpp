// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "cli/console.hpp"
#include "cli/program.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/truth.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace stereogrid::app {
namespace {

struct SimulateOptions {
  std::string scene;
  std::string folder;
  std::optional<int> frames;
  std::optional<std::uint64_t> seed;
  std::optional<int> width_px;
  std::optional<int> height_px;
  bool without_truth{false};
};

scenes::SceneOptions scene_options(const SimulateOptions& options) {
  scenes::SceneOptions scene{scenes::parse_scene(options.scene)};
  scene.frames = options.frames.value_or(scene.frames);
  scene.seed = options.seed.value_or(scene.seed);
  scene.width_px = options.width_px.value_or(scene.width_px);
  scene.height_px = options.height_px.value_or(scene.height_px);
  return scene;
}

int simulate(const SimulateOptions& options) {
  const scenes::Scene scene{scene_options(options)};
  const std::optional<TruthGrid> truth_grid{options.without_truth ? std::nullopt : std::optional{scene.truth_grid()}};
  io::PlainFolderWriter writer{options.folder, scene.rigs(), truth_grid};
  spdlog::info("scene {}: {} frames of {} × {} px", scene.options().name, scene.size(), scene.rig().width_px,
               scene.rig().height_px);
  catch_interrupts();
  std::size_t done{0};
  {
    Progress progress{"frames", scene.size()};
    for (; done < scene.size() && interrupted() == 0; ++done) {
      const StereoFrame frame{scene.load(done)};
      if (options.without_truth) {
        writer.write(frame);
      } else {
        const FrameTruth truth{scene.truth(done)};
        writer.write(frame, &truth);
      }
      progress.update(done + 1);
    }
  }
  writer.finish();
  if (spdlog::should_log(spdlog::level::info)) print("{} frames in {}\n", done, options.folder);
  return interrupted() == 0 ? exit_done : exit_signal_base + interrupted();
}

std::string scenes_help() {
  return fmt::format("A built-in scene ({}), or in full 'scene:street?frames=60&seed=3&width=1242&height=375'.",
                     fmt::join(scenes::scene_names(), ", "));
}

}  // namespace

void add_simulate_command(Command tool, int& exit_code) {
  auto options{std::make_shared<SimulateOptions>()};
  const Command command{tool.add_command("simulate", "Write a built-in scene as a data set with ground truth.")};
  command.add_option("SCENE", options->scene, scenes_help()).required();
  command.group(Group::output);
  command.add_option("--out,-o DIR", options->folder, "Folder for the data set.").required();
  command.add_flag("--no-truth", options->without_truth, "Do not write ground truth.");
  command.group(Group::scene);
  command.add_option("--frames N", options->frames, "Number of frames. Default: that of the scene.")
      .check(whole_number(1, 1'000'000));
  command.add_option("--seed N", options->seed, "Seed of the random layout.")
      .check(whole_number(0, std::numeric_limits<std::uint64_t>::max()));
  command.add_option("--width PX", options->width_px, "Width of the images.").check(whole_number(16, 8192));
  command.add_option("--height PX", options->height_px, "Height of the images.").check(whole_number(16, 8192));
  command.callback([options, &exit_code] { exit_code = simulate(*options); });
}

}  // namespace stereogrid::app
