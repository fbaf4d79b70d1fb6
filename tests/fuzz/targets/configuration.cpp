// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "stereogrid/config.hpp"
#include "stereogrid/io/config_file.hpp"
#include "stereogrid/io/run_folder/frame_lines.hpp"
#include "stereogrid/io/run_folder/run_reader.hpp"
#include "stereogrid/io/truth.hpp"
#include "stereogrid/scenes/scene.hpp"
#include "support.hpp"

namespace stereogrid::fuzz {
namespace {

void set_from(Config& config, std::string_view key, std::string_view value) {
  set(config, key, value);
  const std::string text{get(config, key)};
  set(config, key, text);
  require(get(config, key) == text, "a value changes when it is set again: " + text);
}

}  // namespace

FUZZ_TARGET(config_yaml) {
  static const Folder folder;
  Config config;
  if (!accepts([&] { io::load_config(folder.write("config.yaml", text_of(input)), config); })) return;
  static_cast<void>(problems(config));
  static_cast<void>(io::to_json(config));
  const std::string text{io::to_yaml(config)};
  Config again;
  io::load_config(folder.write("again.yaml", text), again);
  require(io::to_yaml(again) == text, "a configuration changes when it is written");
}

/// Lines KEY=VALUE.
FUZZ_TARGET(settings) {
  std::string_view lines{text_of(input)};
  Config config;
  while (!lines.empty()) {
    const std::string_view line{lines.substr(0, lines.find('\n'))};
    lines.remove_prefix(std::min(lines.find('\n'), lines.size() - 1) + 1);
    const std::size_t equals{std::min(line.find('='), line.size())};
    accepts([&] { set_from(config, line.substr(0, equals), line.substr(std::min(equals + 1, line.size()))); });
  }
  static_cast<void>(problems(config));
}

FUZZ_TARGET(scene) {
  scenes::SceneOptions options;
  if (!accepts([&] { options = scenes::parse_scene(text_of(input)); })) return;
  // larger images are only slower
  options.width_px = std::min(options.width_px, 24);
  options.height_px = std::min(options.height_px, 16);
  accepts([&] {
    const scenes::Scene rendered{options, 1};
    const std::size_t last{rendered.size() - 1};
    const StereoFrame frame{rendered.load(last)};
    require(frame.left.width() == options.width_px && frame.right.height() == options.height_px,
            "a scene's images have another size");
    require(rendered.truth(last).disparity.width() == options.width_px, "a scene's truth has another size");
  });
}

namespace {

void check_grids(const io::RunReader& run, const io::RunGrids& grids) {
  require(grids.occupancy.width() == run.grid().nx && grids.occupancy.height() == run.grid().ny,
          "grids are not of the run's size");
}

}  // namespace

/// Files run.json, frames.jsonl and a frame's grids.
FUZZ_TARGET(run_folder) {
  static const Folder folder;
  const auto files{parts_of(input, 3)};
  folder.write("run.json", files[0]);
  const auto lines{folder.write("frames.jsonl", files[1])};
  folder.write("grids/000000.npz", files[2]);
  accepts([&] {
    const io::RunReader run{folder.path()};
    for (const io::RunFrame& frame : run.frames()) {
      accepts([&] { check_grids(run, run.grids(frame.name)); });
      accepts([&] { require(!run.world_grid(frame.name).occupancy.empty(), "a grid without cells"); });
    }
  });
  std::size_t finished{0};
  if (!accepts([&] { finished = io::take_finished_frames(lines).size(); })) return;
  require(io::take_finished_frames(lines).size() == finished, "lines are lost when they are read twice");
}

FUZZ_TARGET(object_labels) {
  static const Folder folder;
  const auto file{folder.write("objects.jsonl", text_of(input))};
  accepts([&] {
    for (const io::LabelledFrame& frame : io::read_object_labels(file)) {
      for (const LabelledObject& object : frame.objects) {
        require(object.length_m >= 0 && object.width_m >= 0 && std::isfinite(object.x_m + object.y_m),
                "a label that is not a box");
      }
    }
  });
}

/// Files grid.json and objects.jsonl.
FUZZ_TARGET(truth) {
  static const Folder folder;
  const auto files{parts_of(input, 2)};
  folder.write("grid.json", files[0]);
  folder.write("objects.jsonl", files[1]);
  accepts([&] {
    const io::TruthReader reader{folder.path()};
    for (const std::string& name : reader.names()) {
      accepts([&] { require(reader.objects(name).name == name, "truth of another frame"); });
    }
  });
}

}  // namespace stereogrid::fuzz
