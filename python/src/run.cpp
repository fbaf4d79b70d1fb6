// SPDX-License-Identifier: Apache-2.0
#include <nanobind/nanobind.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "arrays.hpp"
#include "bindings.hpp"
#include "evaluate/output.hpp"
#include "geometry.hpp"
#include "stereogrid/io/json_text.hpp"
#include "stereogrid/io/run_folder/run_reader.hpp"

namespace stereogrid::python {
namespace {

using Path = std::filesystem::path;

/// Grids of a frame of a run, as read. `velocity`: both components, one after the other.
struct ReadGrids {
  io::RunGrids grids;
  std::vector<float> velocity;
};

std::unique_ptr<ReadGrids> read_grids(const io::RunReader& run, const std::string& name) {
  auto read{std::make_unique<ReadGrids>()};
  read->grids = run.grids(name);
  for (const auto* part : {&read->grids.velocity_x, &read->grids.velocity_y}) {
    read->velocity.insert(read->velocity.end(), part->begin(), part->end());
  }
  return read;
}

Planes<float> velocity_of(nb::handle self) {
  const auto& read{nb::cast<const ReadGrids&>(self)};
  const Image<float>& part{read.grids.velocity_x};
  return {
      read.velocity.data(), {2, static_cast<std::size_t>(part.height()), static_cast<std::size_t>(part.width())}, self};
}

void bind_run_frame(nb::module_& module) {
  nb::class_<io::RunFrame> frame{module, "RunFrame", "A line of a run's frames.jsonl."};
  frame.def_ro("index", &io::RunFrame::index).def_ro("name", &io::RunFrame::name);
  frame.def_ro("stamp_ns", &io::RunFrame::stamp_ns);
  frame.def_ro("pose", &io::RunFrame::world_from_vehicle, "world_from_vehicle.");
  frame.def_ro("obstacles", &io::RunFrame::obstacles).def_ro("status", &io::RunFrame::status);
  nb::class_<ReadGrids> grids{module, "RunGrids", "Grids of a frame of a run, vehicle frame."};
  grids.def_prop_ro("observed",
                    [](nb::handle self) { return view_of(nb::cast<const ReadGrids&>(self).grids.observed, self); });
  grids.def_prop_ro("occupancy",
                    [](nb::handle self) { return view_of(nb::cast<const ReadGrids&>(self).grids.occupancy, self); });
  grids.def_prop_ro("velocity", &velocity_of, "(2, ny, nx), m/s over ground, vehicle axes.");
}

/// Figures as `stereogrid evaluate --json` writes them.
std::string evaluate(const Path& run, const std::optional<Path>& input, const std::string& truth,
                     std::optional<double> camera_height_m) {
  app::EvaluateOptions options;
  options.run = run.string();
  options.input = input ? input->string() : "";
  options.truth = truth;
  options.camera_height_m = camera_height_m;
  const app::Evaluation evaluation{app::evaluate(options, [](std::size_t, std::size_t) { check_signals(); })};
  const nlohmann::ordered_json json(app::json_of(evaluation));
  return io::json_text(json);
}

}  // namespace

void bind_run(nb::module_& module) {
  bind_run_frame(module);
  nb::class_<io::RunReader> run{module, "Run", "The folder of a run."};
  run.def_prop_ro("folder", &io::RunReader::folder).def_prop_ro("grid", &io::RunReader::grid);
  run.def_prop_ro("preset", &io::RunReader::preset);
  run.def_prop_ro("rig", [](const io::RunReader& self) { return MountedRig{self.rig()}; });
  run.def_prop_ro("frames", &io::RunReader::frames, nb::rv_policy::reference_internal);
  run.def("__len__", [](const io::RunReader& self) { return self.frames().size(); });
  run.def(
      "grids",
      [](const io::RunReader& self, const std::string& name) {
        const ReleasedGil release;
        return read_grids(self, name);
      },
      nb::arg("name"), "Reads the grids of a frame. Raises InputError.");
  module.def(
      "read_run",
      [](const Path& folder) {
        const ReleasedGil release;
        return std::make_shared<io::RunReader>(folder);
      },
      nb::arg("folder"), "Opens the folder of a run. Raises InputError.");
  module.def("evaluate_json", &evaluate, nb::arg("run"), nb::arg("input") = nb::none(), nb::arg("truth") = "",
             nb::arg("camera_height_m") = nb::none(), nb::call_guard<ReleasedGil>());
}

}  // namespace stereogrid::python
