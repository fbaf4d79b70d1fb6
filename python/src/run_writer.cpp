// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>

#include <filesystem>
#include <fstream>

#include "bindings.hpp"
#include "pipeline.hpp"
#include "run_description.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/run_folder/frame_files.hpp"
#include "stereogrid/io/run_folder/frame_lines.hpp"
#include "stereogrid/io/run_folder/run_record.hpp"

namespace stereogrid::python {
namespace {

namespace fs = std::filesystem;

/// Writes the folder of a run, as `stereogrid run` does, frame after frame.
class RunWriter {
 public:
  RunWriter(const fs::path& folder, std::shared_ptr<Recording> recording, PyPipeline& pipeline, std::string preset)
      : recording_{std::move(recording)}, pipeline_{pipeline}, record_{folder, description(std::move(preset))} {
    record_.begin();
    io::create_folder(folder / "grids");
    lines_.open(folder / "frames.jsonl", std::ios::app | std::ios::binary);
  }

  [[nodiscard]] std::unique_ptr<Result> process(const Frame& frame) {
    std::unique_ptr<Result> result{pipeline_.process(frame)};
    record_.set_rig(pipeline_.exclusively([](const Pipeline& p) { return p.next_rig(); }));
    const nb::gil_scoped_release release;
    io::write_grids(record_.folder() / "grids" / (result->name + ".npz"), result->data);
    lines_ << io::frame_line(frame.data, result->data, result->data.rig) << '\n' << std::flush;
    if (!lines_) {
      throw DeviceError{(record_.folder() / "frames.jsonl").string() + ": cannot be written. Free some space."};
    }
    record_.add_frame(io::summary_of(frame.data, result->data));
    return result;
  }

  void close(bool complete) {
    if (is_closed_) return;
    is_closed_ = true;
    for (const io::SkippedFrame& skipped : recording_->skipped) record_.add_skipped(skipped);
    record_.save(complete);
  }

 private:
  io::RunDescription description(std::string preset) const {
    io::RunDescription run{
        app::describe_run(recording_->input(), recording_->options(), pipeline_.pipeline(), recording_->range())};
    run.preset = std::move(preset);
    run.fuse_source = "none";
    return run;
  }

  std::shared_ptr<Recording> recording_;
  PyPipeline& pipeline_;
  io::RunRecord record_;
  std::ofstream lines_;
  bool is_closed_{false};
};

}  // namespace

void bind_run_writer(nb::module_& module) {
  nb::class_<RunWriter> writer{
      module, "RunWriter",
      "Processes the frames of a recording and writes the folder that stereogrid run leaves. A "
      "context manager: run.json is written at the end."};
  writer.def(nb::init<const fs::path&, std::shared_ptr<Recording>, PyPipeline&, std::string>(), nb::arg("folder"),
             nb::arg("recording"), nb::arg("pipeline"), nb::kw_only(), nb::arg("preset") = "default",
             nb::keep_alive<1, 4>(),
             "preset: name of the preset, for run.json. Raises ConfigError: the folder holds a run.");
  writer.def("process", &RunWriter::process, nb::arg("frame"),
             "Processes a frame, writes its results and returns them. Raises InputError, DeviceError.");
  writer.def(
      "close", [](RunWriter& self) { self.close(true); }, "Writes run.json. Raises DeviceError.");
  writer.def(
      "__enter__", [](nb::handle self) { return nb::borrow(self); }, nb::sig("def __enter__(self) -> RunWriter"));
  writer.def(
      "__exit__", [](RunWriter& self, nb::handle type, nb::handle, nb::handle) { self.close(type.is_none()); },
      nb::arg("type").none(), nb::arg("value").none(), nb::arg("traceback").none(),
      nb::sig("def __exit__(self, type: object, value: object, traceback: object) -> None"));
}

}  // namespace stereogrid::python
