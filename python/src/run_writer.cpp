// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "bindings.hpp"
#include "frame_stages.hpp"
#include "input.hpp"
#include "locks/folder_lock.hpp"
#include "pipeline.hpp"
#include "run/resume.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/run_folder/checkpoint.hpp"
#include "stereogrid/io/run_folder/frame_lines.hpp"
#include "stereogrid/io/run_folder/run_record.hpp"

namespace stereogrid::python {
namespace {

namespace fs = std::filesystem;

struct WriterOptions {
  std::string preset;
  std::string fuse;
  bool resume{false};
  std::size_t checkpoint_every{0};
};

/// Writes the folder of a run, as `stereogrid run` does, frame after frame.
class RunWriter {
 public:
  RunWriter(const fs::path& folder, std::shared_ptr<Recording> recording, PyPipeline& pipeline, WriterOptions options)
      : recording_{std::move(recording)},
        pipeline_{pipeline},
        options_{std::move(options)},
        fusion_{app::fused_source(options_.fuse), recording_->input(), pipeline.pipeline().vehicle_grid()},
        record_{folder, description()},
        lock_{folder},
        checkpoints_{recording_->range().first, options_.checkpoint_every} {
    warn(lock_->warning());
    options_.resume ? record_.resume() : record_.begin();
    app::recall_skipped(recording_->source(), record_);
    io::remove_torn_checkpoint(folder);
    io::create_folder(folder / "grids");
    lines_.open(folder / "frames.jsonl", std::ios::app | std::ios::binary);
    first_to_write_ = app::first_to_do(record_);
  }

  /// Frames that the run lacks, after those whose state is loaded into the pipeline.
  [[nodiscard]] std::shared_ptr<FrameIterator> frames() {
    require_open();
    if (frames_) throw nb::value_error("A RunWriter is iterated once. Make another one with resume=True.");
    frames_ = std::make_shared<FrameIterator>(
        recording_, [this](app::PoseStage& poses) { return first_frame(poses); },
        [checkpoints = checkpoints_](std::size_t index) { return checkpoints.is_due_after(index); });
    return frames_;
  }

  [[nodiscard]] ResultObject process(const Frame& frame) {
    require_open();
    if (options_.resume && !frames_) throw nb::value_error("resume: iterate over the RunWriter, not the recording.");
    const std::size_t index{index_of(frame)};
    last_.reset();
    ResultObject result{options_.fuse != "none" ? fused(frame) : pipeline_.process(frame)};
    const Rig next_rig{pipeline_.exclusively([](const Pipeline& p) { return p.next_rig(); })};
    next_ = index + 1;
    record_.set_rig(next_rig);
    last_ = index;
    if (index >= first_to_write_) {
      const auto& written{nb::cast<const Result&>(result)};
      const ReleasedGil release;
      write(frame, written);
    }
    return result;
  }

  [[nodiscard]] const fs::path& folder() const { return record_.folder(); }

  void close() {
    if (!lock_) return;
    note_skipped();
    std::size_t next{app::first_to_do(record_)};
    if (!record_.skipped().empty()) next = std::max(next, record_.skipped().back().index + 1);
    const bool is_complete{next == record_.range().end};
    if (!is_complete && last_ && !finds_poses()) save_state();
    record_.save(is_complete);
    lock_.reset();
  }

 private:
  void require_open() const {
    if (!lock_) throw nb::value_error("The RunWriter is closed. Make another one with resume=True.");
  }

  // Readers of the folder expect frames in the order of the recording.
  [[nodiscard]] std::size_t index_of(const Frame& frame) const {
    const auto index{static_cast<std::size_t>(frame.data.index)};
    const std::size_t end{recording_->range().end};
    if (index >= next_ && index < end) return index;
    throw InputError{
        fmt::format("frame {}: index {} (allowed {} … {}). A run has the frames of its recording, in their "
                    "order, each once.",
                    frame.data.name, frame.data.index, next_, end - 1)};
  }

  [[nodiscard]] bool finds_poses() const { return recording_->input().poses == app::PoseSource::odometry; }

  static void warn(const std::string& text) {
    if (!text.empty() && PyErr_WarnEx(PyExc_RuntimeWarning, text.c_str(), 1) != 0) throw nb::python_error();
  }

  [[nodiscard]] std::size_t first_frame(app::PoseStage& poses) {
    const app::Continuation from{
        pipeline_.exclusively([&](Pipeline& p) { return app::continuation_of(record_, p, poses, 0); })};
    for (const std::string& warning : from.warnings) warn(warning);
    record_.continue_from(from.first);
    return from.first;
  }

  [[nodiscard]] ResultObject fused(const Frame& frame) {
    Frame with_grid{frame};
    const std::optional<std::string> warning{
        fusion_.add_grid(with_grid.data, static_cast<std::size_t>(frame.data.index),
                         pipeline_.exclusively([](const Pipeline& p) { return p.next_rig(); }))};
    ResultObject result{pipeline_.process(with_grid)};
    if (warning) nb::cast<Result&>(result).data.warnings.push_back({*warning});
    return result;
  }

  void write(const Frame& frame, const Result& result) {
    io::write_grids(record_.folder() / "grids" / (result.name + ".npz"), result.data);
    lines_ << io::frame_line(frame.data, result.data, result.data.rig) << '\n' << std::flush;
    if (!lines_) {
      throw DeviceError{(record_.folder() / "frames.jsonl").string() + ": cannot be written. Free some space."};
    }
    record_.add_frame(io::summary_of(frame.data, result.data));
    if (!checkpoints_.is_due_after(*last_)) return;
    note_skipped();
    record_.save(false);
    save_state();
  }

  void note_skipped() {
    for (const io::SkippedFrame& skipped : recording_->skipped) {
      if (!record_.is_skipped(skipped.index)) record_.add_skipped(skipped);
    }
  }

  void save_state() {
    std::optional<OdometryState> odometry;
    if (frames_) odometry = frames_->poses().take_state(*last_);
    if (finds_poses() && !odometry) return;
    const std::vector<std::byte> state{pipeline_.exclusively([](const Pipeline& p) { return p.save_state(); })};
    io::write_checkpoint(record_.folder(), {*last_, state, std::move(odometry)});
  }

  [[nodiscard]] io::RunDescription description() const {
    io::RunDescription run{
        app::describe_run(recording_->input(), recording_->options(), pipeline_.pipeline(), recording_->range())};
    const app::Input& input{recording_->input()};
    const bool is_in_memory{input.recording == nullptr && input.scene == nullptr};
    if (is_in_memory && !input.source->load(run.frames.first).disparity.empty()) run.matcher = "given";
    run.preset = options_.preset;
    run.fuse_source = options_.fuse;
    return run;
  }

  std::shared_ptr<Recording> recording_;
  PyPipeline& pipeline_;
  WriterOptions options_;
  app::FusionStage fusion_;
  io::RunRecord record_;
  std::optional<app::FolderLock> lock_;  ///< none: closed
  io::Checkpoints checkpoints_;
  std::ofstream lines_;
  std::size_t first_to_write_{0};
  std::size_t next_{recording_->range().first};  ///< least index of the next frame
  std::shared_ptr<FrameIterator> frames_;
  std::optional<std::size_t> last_;  ///< frame that the pipeline's state is of
};

}  // namespace

void bind_run_writer(nb::module_& module) {
  nb::class_<RunWriter> writer{module, "RunWriter",
                               "Processes the frames of a recording and writes the folder that stereogrid run leaves. "
                               "A context manager: run.json is written at the end. Iteration gives the frames to "
                               "process."};
  writer.def(
      "__init__",
      [](RunWriter* self, const fs::path& folder, std::shared_ptr<Recording> recording, PyPipeline& pipeline,
         std::string preset, std::string fuse, bool resume, std::size_t checkpoint_every) {
        new (self) RunWriter{
            folder, std::move(recording), pipeline, {std::move(preset), std::move(fuse), resume, checkpoint_every}};
      },
      nb::arg("folder"), nb::arg("recording"), nb::arg("pipeline"), nb::kw_only(), nb::arg("preset") = "default",
      nb::arg("fuse") = "none", nb::arg("resume") = false, nb::arg("checkpoint_every") = 100, nb::keep_alive<1, 4>(),
      "preset: its name, for run.json. fuse: \"none\", \"lidar\", \"grids\" or \"labels\". resume: continue a stopped "
      "run with a "
      "new "
      "pipeline. "
      "checkpoint_every: interval in frames at which the state is saved for resume; 0: never. Raises ConfigError: the "
      "folder holds a run, or one with other settings; DeviceError: another process writes there.");
  writer.def_prop_ro("folder", &RunWriter::folder);
  writer.def("__iter__", &RunWriter::frames, "Frames to process. Those of a stopped run continue after its state.");
  writer.def("process", &RunWriter::process, nb::arg("frame"),
             "Processes a frame, writes its results and returns them. Raises InputError, also for frames that are not "
             "in the order of the recording; DeviceError; ValueError: closed.");
  writer.def("close", &RunWriter::close, "Writes run.json and releases the folder. Raises DeviceError.");
  writer.def(
      "__enter__", [](nb::handle self) { return nb::borrow(self); }, nb::sig("def __enter__(self) -> RunWriter"));
  writer.def(
      "__exit__", [](RunWriter& self, nb::args) { self.close(); },
      nb::sig("def __exit__(self, type: object, value: object, traceback: object) -> None"));
}

}  // namespace stereogrid::python
