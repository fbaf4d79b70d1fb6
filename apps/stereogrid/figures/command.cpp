// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "commands.hpp"
#include "config_options.hpp"
#include "console.hpp"
#include "figures/figures.hpp"
#include "input.hpp"
#include "stereogrid/io/file.hpp"

namespace stereogrid::app {
namespace {

namespace fs = std::filesystem;

// the paper's camera (512 × 320 px, f = 410 px, baseline 0.22 m); somebody steps out from behind a parked car
constexpr const char* default_scene{"scene:street?frames=45"};

struct Options {
  InputOptions input;
  ConfigOptions config;
  std::string folder;
  std::string frame;
};

/// How an input is called in the figures: without the folders above it.
std::string short_name(const std::string& path) {
  if (path.starts_with("scene:")) return path;
  const fs::path whole{fs::weakly_canonical(path)};
  return (whole.has_filename() ? whole : whole.parent_path()).filename().string();
}

void say(const std::string& sentence) {
  if (spdlog::should_log(spdlog::level::info)) tell("{}\n", sentence);
}

void write(const fs::path& folder, int number, const io::RgbImage& image) {
  io::write_png(folder / fmt::format("figure_{}.png", number), image);
}

int draw_figures(Options options) {
  if (options.input.paths.empty()) options.input.paths = {default_scene};
  const Config config{config_from(options.config)};
  const Input input{open_input(options.input)};
  log_input(input);
  const std::size_t index{figures::frame_index(input, options.frame)};
  io::create_folder(options.folder);
  figures::Material material{figures::gather(input, index, config)};
  material.input = short_name(options.input.paths.front());
  const fs::path folder{options.folder};
  write(folder, 1, figures::figure_1(material.config.u_disparity));
  write(folder, 2, figures::figure_2(material.config.u_disparity));
  write(folder, 3, figures::figure_3(material));
  write(folder, 4, figures::figure_4(material));
  write(folder, 6, figures::figure_6(material));
  write(folder, 7, figures::figure_7(material));
  write(folder, 8, figures::figure_8(material));
  const std::optional<io::RgbImage> beside_lidar{figures::figure_9(material)};
  if (beside_lidar) {
    write(folder, 9, *beside_lidar);
  } else {
    say(fmt::format("Figure 9 is left out: frame {} has no lidar sweep.", material.moment().frame.name));
  }
  say(fmt::format("figures of {}, frame {}, in {}", material.input, material.moment().frame.name, options.folder));
  return exit_done;
}

}  // namespace

void add_figures_command(CLI::App& tool, int& exit_code) {
  auto options{std::make_shared<Options>()};
  options->config.preset = "paper";
  CLI::App* command{tool.add_subcommand("figures", "The figures of the paper, drawn from an input.")};
  add_input_options(*command, options->input);
  command->get_option("INPUT")->required(false)->description(
      fmt::format("A drive's folder, LEFT and RIGHT image, or a built-in scene; left out: '{}'.", default_scene));
  command->add_option("--out,-o", options->folder, "Folder for the figures: figure_1.png and so on.")
      ->type_name("DIR")
      ->required();
  command
      ->add_option("--frame", options->frame,
                   "The frame to draw; left out: the middle one, with lidar where there is any.")
      ->type_name("NAME");
  add_config_options(*command, options->config);
  command->callback([options, &exit_code] { exit_code = draw_figures(*options); });
}

}  // namespace stereogrid::app
