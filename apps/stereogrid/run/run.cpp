// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "run/run.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <optional>
#include <set>
#include <string_view>

#include "commands.hpp"
#include "console.hpp"
#include "interrupt.hpp"
#include "pose_stage.hpp"
#include "progress.hpp"
#include "run/damaged_frames.hpp"
#include "run/folder_lock.hpp"
#include "run/frame_wait.hpp"
#include "run/lidar_stage.hpp"
#include "run/opencv_stage.hpp"
#include "run/result_writer.hpp"
#include "run/resume.hpp"
#include "run/summary.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/frame_queue.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/io/run_folder/checkpoint.hpp"
#include "stereogrid/io/run_folder/run_record.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::app {
namespace {

constexpr std::size_t frames_ahead{4};

/// The vehicle at the first frame that goes through the pipeline, in the frame of the input's first one.
Pose2 start_of(const RunOptions& options, const Input& input) {
  const io::FrameRange range{parse_frame_range(options.frames, input.source->size())};
  const std::size_t first{range.first - std::min(range.first, static_cast<std::size_t>(options.warm_up))};
  if (first == 0 || input.poses != PoseSource::input) return {};
  const auto zero{first_usable_frame(*input.source, {0, range.end}).world_from_vehicle};
  const auto here{first_usable_frame(*input.source, {first, range.end}).world_from_vehicle};
  return zero && here ? inverse(*zero) * *here : Pose2{};
}

PipelineOptions pipeline_options(const RunOptions& options, const Input& input) {
  const bool stages{options.save_stages || options.pictures || !options.video.empty() || options.view ||
                    needs_stages(options.messages)};
  return {.stages = stages,
          .horizons_s = options.predict_s,
          .mask = input.mask,
          .start = options.world_of_input ? start_of(options, input) : Pose2{}};
}

/// Takes the frames of the input through the pipeline and to the files.
class RunLoop {
 public:
  /// `first_frame`: from there on frames go through the pipeline; those that are finished already are not written.
  RunLoop(Pipeline& pipeline, PoseStage& poses, const OpencvStage& opencv, const LidarStage& lidar,
          io::RunRecord& record, ResultWriter& writer, std::size_t first_frame, const io::Checkpoints& checkpoints,
          int input_wait_s)
      : pipeline_{pipeline},
        poses_{poses},
        opencv_{opencv},
        lidar_{lidar},
        record_{record},
        writer_{writer},
        first_frame_{first_frame},
        checkpoints_{checkpoints},
        input_wait_s_{input_wait_s},
        first_to_write_{first_to_do(record)} {}

  void go_through(const FrameSource& source) {
    const std::size_t total{record_.range().end - first_to_write_};
    Progress progress{"frames", total};
    // a second thread, so that the next frame is read while this one's motion is found
    const int threads{poses_.takes_time() ? 2 : 1};
    io::FrameQueue queue{
        source,       first_frame_, record_.range().end,
        frames_ahead, threads,      [this](io::QueuedFrame& queued) { queued.warning = poses_.place(*queued.frame); }};
    while (interrupted() == 0) {
      if (!wait_for_frame(queue, next_, input_wait_s_)) give_up_waiting();
      std::optional<io::QueuedFrame> queued{queue.next()};
      if (!queued) break;
      take(std::move(*queued));
      progress.update(total - (record_.range().end - next_));
    }
    writer_.finish();
    seconds_ = progress.seconds();
  }

  /// Saves what pipeline and odometry remember after the last frame that went through. False: nothing went through, or
  /// the odometry, which works ahead, was not asked to keep it.
  bool save_state() const {
    if (!last_processed_) return false;
    std::optional<io::OdometryState> odometry{poses_.take_state(*last_processed_)};
    if (poses_.takes_time() && !odometry) return false;
    io::write_checkpoint(record_.folder(), {*last_processed_, pipeline_.save_state(), std::move(odometry)});
    return true;
  }

  [[nodiscard]] bool is_complete() const { return next_ == record_.range().end; }
  [[nodiscard]] double frames_per_second() const { return seconds_ > 0 ? frames_written_ / seconds_ : 0; }

 private:
  void take(io::QueuedFrame queued) {
    next_ = std::max(next_, queued.index + 1);
    if (!queued.frame) return skip(queued, queued.error);
    try {
      const double opencv_ms{opencv_.match(*queued.frame)};
      FrameResult result;
      const Rig rig{pipeline_.rig()};  // a mounting that this frame shows is of the next one
      const std::string without_lidar{lidar_.add_grid(*queued.frame, rig)};
      pipeline_.process(*queued.frame, result);
      last_processed_ = queued.index;
      if (queued.index < first_to_write_) return;
      result.timing_ms.match += opencv_ms;
      if (poses_.takes_time()) result.timing_ms.odometry = queued.prepared_ms;
      result.timing_ms.total += opencv_ms;
      if (!queued.warning.empty()) result.warnings.push_back(queued.warning);
      if (!without_lidar.empty()) result.warnings.push_back(without_lidar);
      tell_warnings(queued.name, result.warnings);
      record_.add_frame({queued.index, result.timing_ms, result.warnings, result.status});
      ++frames_written_;
      record_.set_rigs(pipeline_.rig(), pipeline_.level_rig());
      writer_.write(std::move(*queued.frame), std::move(result), rig, checkpoint_after(queued.index));
    } catch (const InputError& error) {
      skip(queued, error.what());
    }
  }

  // The thread that waits for the file system cannot be ended: the process is.
  [[noreturn]] void give_up_waiting() {
    writer_.finish();
    record_.save(false);
    write_error(
        fmt::format("stereogrid: frame {} has not come within {} s: the file system of the input hangs, or is "
                    "gone. What is done is safe; the same command with --resume goes on.\n",
                    next_, input_wait_s_));
    std::_Exit(exit_try_again);
  }

  std::optional<io::Checkpoint> checkpoint_after(std::size_t index) {
    if (!checkpoints_.is_due_after(index)) return std::nullopt;
    return io::Checkpoint{index, pipeline_.save_state(), poses_.take_state(index)};
  }

  void skip(const io::QueuedFrame& queued, const std::string& reason) {
    if (queued.index < first_to_write_) return;
    spdlog::warn("frame {} is skipped: {}", queued.name, reason);
    record_.add_skipped({queued.index, queued.name, reason});
    // it tells of all of them: written for each it would take as long as they are many, squared
    if (std::has_single_bit(record_.skipped().size())) record_.save(false);
  }

  void tell_warnings(const std::string& name, const std::vector<std::string>& warnings) {
    for (const std::string& warning : warnings) {
      const bool is_new{told_.insert(warning).second};
      spdlog::log(is_new ? spdlog::level::warn : spdlog::level::debug, "frame {}: {}", name, warning);
    }
  }

  Pipeline& pipeline_;
  PoseStage& poses_;
  const OpencvStage& opencv_;
  const LidarStage& lidar_;
  io::RunRecord& record_;
  ResultWriter& writer_;
  std::size_t first_frame_;
  io::Checkpoints checkpoints_;
  int input_wait_s_;
  std::size_t first_to_write_;
  std::size_t next_{first_to_write_};
  std::optional<std::size_t> last_processed_;
  int frames_written_{0};
  double seconds_{0};
  std::set<std::string> told_;
};

void check_options(const RunOptions& options, const Input& input) {
  refuse_without_node(options.messages.ros2);
  if (options.messages.scale && options.messages.mcap.empty() && !options.messages.ros2.publishes && !options.view) {
    throw ConfigError{"--value-scale is of messages, but none are sent. Give --mcap FILE, --view or --ros2, too."};
  }
  check(options.messages, input.source->rig());
  if (options.matcher != "own" && input.recording != nullptr && input.recording->gives_disparities()) {
    throw ConfigError{fmt::format("--matcher {} needs right images, but the disparities are given ({}). Leave one out.",
                                  options.matcher, input.recording->contents().disparities.string())};
  }
}

void check_options(const RunOptions& options) {
  if (options.fuse == "none" && options.fuse_rings != Rings::all) {
    throw ConfigError{"--fuse-rings chooses among the lidar's rings, but nothing is fused. Give --fuse lidar, too."};
  }
  if (options.resume && !options.video.empty()) {
    throw ConfigError{"--video cannot go on with --resume: a film is made in one go. Leave one of them out."};
  }
  if (options.resume && !options.messages.mcap.empty()) {
    throw ConfigError{
        "--mcap cannot go on with --resume: a recording is made in one go. Go on without it; or give it to a new run "
        "with another --out."};
  }
}

io::RunRecord describe_run(const RunOptions& options, const Input& input, const Pipeline& pipeline) {
  const io::FrameRange range{parse_frame_range(options.frames, input.source->size())};
  const bool given{input.recording != nullptr && input.recording->gives_disparities()};
  io::RunRecord record{options.folder,
                       {.preset = options.config.preset,
                        .config = pipeline.config(),
                        .input = describe(input, options.input),
                        .matcher = given ? "given" : options.matcher,
                        .predict_s = options.predict_s,
                        .fuse_source = options.fuse,
                        .fuse_rings = name_of(options.fuse_rings),
                        .device = std::string{name_of(pipeline.back_end())},
                        .rig = pipeline.rig(),
                        .grid = pipeline.vehicle_grid(),
                        .world_grid = pipeline.world_grid(),
                        .simd_target = std::string{simd_target()},
                        .threads = pipeline.threads(),
                        .frames = range,
                        .compact = options.compact,
                        .warm_up = std::min(range.first, static_cast<std::size_t>(options.warm_up))}};
  const std::optional<std::string> complaint{io::complaint_if_swapped(first_usable_frame(*input.source, range))};
  if (complaint) throw InputError{*complaint};
  return record;
}

WriterOptions writer_options(const RunOptions& options, const Input& input, const Rig& rig, std::size_t first_frame,
                             Page* page) {
  return {.folder = options.folder,
          .predictions = !options.predict_s.empty(),
          .compact = options.compact,
          .stages = options.save_stages,
          .pictures = options.pictures,
          .video = options.video,
          .video_rate_hz = rate_hz(input),
          .messages = options.messages,
          .page = page,
          .rig = rig,
          .first_frame = first_frame};
}

}  // namespace

int run(const RunOptions& options) {
  check_options(options);
  const Config config{config_from(options.config)};
  const Input input{open_input(options.input)};
  check_options(options, input);
  log_input(input);
  Pipeline pipeline{start_pipeline(config, input.source->rig(), options.device, pipeline_options(options, input))};
  const LidarStage lidar{options.fuse == "lidar", input, pipeline.vehicle_grid(), options.fuse_rings};
  io::RunRecord record{describe_run(options, input, pipeline)};
  record.set_rigs(pipeline.rig(), pipeline.level_rig());
  const FolderLock lock{record.folder()};
  options.resume ? record.resume() : record.begin();
  recall_skipped(*input.source, record);
  io::remove_torn_checkpoint(record.folder());
  std::optional<Page> page;
  if (options.view) {
    page.emplace(options.page, options.folder);
    tell("open {}\n", page->server().url());
  }
  ResultWriter writer{writer_options(options, input, pipeline.rig(), record.range().first, page ? &*page : nullptr)};
  const OpencvStage opencv{options.matcher, pipeline.config().matching.disparities};
  const io::Checkpoints checkpoints{record.range().first, static_cast<std::size_t>(options.checkpoint_every)};
  PoseStage poses{input.poses, input.source->rig(), input.mask,
                  [checkpoints, end = record.range().end, save_last = options.save_last](std::size_t index) {
                    return checkpoints.is_due_after(index) || (save_last && index + 1 == end);
                  }};
  RunLoop loop{pipeline,
               poses,
               opencv,
               lidar,
               record,
               writer,
               first_frame_of(record, pipeline, poses, {static_cast<std::size_t>(options.warm_up), options.go_on_from}),
               checkpoints,
               options.input_wait_s};
  catch_interrupts();
  loop.go_through(*input.source);
  record.save(loop.is_complete());
  if (loop.is_complete() ? options.save_last : !poses.takes_time()) loop.save_state();
  print_summary(record, loop.frames_per_second());
  warn_of_unknown_frames(record, input.source->rig(), pipeline.rig());
  if (loop.is_complete()) return exit_done;
  spdlog::warn("stopped; the same command with --resume goes on");
  return exit_signal_base + interrupted();
}

}  // namespace stereogrid::app
