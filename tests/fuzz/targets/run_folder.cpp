// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "stereogrid/io/run_folder/frame_lines.hpp"
#include "stereogrid/io/run_folder/run_reader.hpp"
#include "stereogrid/io/truth.hpp"
#include "support.hpp"

namespace stereogrid::fuzz {
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
