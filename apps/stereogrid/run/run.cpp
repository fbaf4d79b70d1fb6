// SPDX-License-Identifier: Apache-2.0
#include "run/run.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "cli/console.hpp"
#include "cli/program.hpp"
#include "diagnostics/frame_tally.hpp"
#include "locks/folder_lock.hpp"
#include "run/resume.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/io/run_folder/frame_lines.hpp"

namespace stereogrid::app {
namespace {

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
  const bool stages{options.save_stages || !options.pictures.empty() || !options.video.empty() || options.view ||
                    needs_stages(options.messages)};
  return {.stages = stages,
          .horizons_s = options.predict_s,
          .mask = input.mask,
          .other_masks = input.other_masks,
          .camera_names = input.source->camera_names(),
          .extrinsics_given = input.extrinsics_given,
          .start = start_of(options, input)};
}

void check_options(const RunOptions& options, const Input& input) {
  refuse_without_node(options.messages.ros2);
  if (options.messages.scale && options.messages.mcap.empty() && !options.messages.ros2.publishes && !options.view) {
    throw ConfigError{"--value-scale is of messages, but none are sent. Give --mcap FILE, --view or --ros2, too."};
  }
  check(options.messages, input.source->rig());
}

void check_options(const RunOptions& options) {
  static_cast<void>(layers_of(options));
  if (options.resume && !options.video.empty()) {
    throw ConfigError{"--video does not support --resume. Leave one of them out."};
  }
  if (options.resume && !options.messages.mcap.empty()) {
    throw ConfigError{
        "--mcap does not support --resume. Continue without it; or give it to a new run "
        "with another --out."};
  }
}

void check_layers(const RunOptions& options, const Config& config) {
  if (config.ground.model == GroundModel::terrain) return;
  for (const std::string& layer : options.layers) {
    if (layer.find("elevation") == std::string::npos && layer.find("terrain") == std::string::npos) continue;
    throw ConfigError{fmt::format("--layers {}: only with ground.model=terrain.", layer)};
  }
}

io::RunRecord record_of(const RunOptions& options, const Input& input, const Pipeline& pipeline) {
  check_layers(options, pipeline.config());
  const io::FrameRange range{parse_frame_range(options.frames, input.source->size())};
  io::RunDescription run{describe_run(input, options.input, pipeline, range)};
  run.preset = options.config.preset;
  run.predict_s = options.predict_s;
  run.fuse_source = options.fuse;
  run.compact = options.compact;
  run.every = options.every;
  run.layers = layers_of(options);
  run.warm_up = std::min(range.first, static_cast<std::size_t>(options.warm_up));
  io::RunRecord record{options.folder, std::move(run)};
  const StereoFrame first{first_usable_frame(*input.source, range)};
  if (const auto problem{io::finding_if_swapped(first)}) throw InputError{*problem};
  if (input.recording != nullptr && !first.left.empty()) {
    const Rig& rig{input.source->rig()};
    for (const std::string& text : faults_of_frame(first, {input, pipeline.config(), rig, rig, {}})) {
      spdlog::warn("{}", text);
    }
  }
  return record;
}

WriterOptions writer_options(const RunOptions& options, const Input& input, const Rig& rig, std::size_t first_frame,
                             Page* page) {
  return {.folder = options.folder,
          .predictions = !options.predict_s.empty(),
          .compact = options.compact,
          .every = options.every,
          .layers = layers_of(options),
          .stages = options.save_stages,
          .pictures = options.pictures,
          .video = options.video,
          .video_rate_hz = rate_hz(input) / static_cast<double>(options.every),
          .messages = options.messages,
          .page = page,
          .rig = rig,
          .first_frame = first_frame};
}

/// The exit code of a run that has not reached its last frame. Throws DeviceError where a frame was unavailable.
int stopped(const RunOptions& options, const io::RunRecord& record, const RunLoop& loop) {
  if (loop.unavailable().empty()) {
    const bool has_summary{spdlog::should_log(spdlog::level::info)};
    if (!has_summary) spdlog::warn("stopped; the same command with --resume continues");
    return exit_signal_base + interrupted();
  }
  throw DeviceError{fmt::format("{} {} of {} frames are done; the same command{} continues.", loop.unavailable(),
                                record.finished().size(), record.frames_to_write(),
                                options.resume ? "" : " with --resume")};
}

/// Logs what is wrong with the frames of the run and the remedy, as `info` does.
void warn_of_frames(const io::RunRecord& record, const Input& input, const Pipeline& pipeline) {
  FrameTally tally;
  for (const io::FrameSummary& frame : record.finished()) tally.add(frame);
  const auto frame_at = [&](std::size_t index) -> std::optional<StereoFrame> {
    if (interrupted() != 0) return std::nullopt;
    try {
      return input.source->load(index);
    } catch (const InputError&) {
      return std::nullopt;
    } catch (const DeviceError&) {  // the run's own error reports it
      return std::nullopt;
    }
  };
  const Findings findings{
      findings_of(tally, {input, pipeline.config(), input.source->rig(), pipeline.next_rig(), frame_at})};
  for (const std::string& text : findings.texts) spdlog::warn("{}", text);
  const std::string advice{advice_on_preset(pipeline.config(), pipeline.next_rig())};
  if (!advice.empty()) spdlog::info("{}", advice);
}

/// Logs where the poses of a complete run contradict the motion in its images.
void warn_of_poses(const Input& input) {
  if (interrupted() != 0) return;
  if (const auto text{contradiction_of_poses(input)}) spdlog::warn("{}", *text);
}

}  // namespace

int run(const RunOptions& requested) {
  RunOptions options(requested);
  if (options.messages.mcap == MessageOptions::in_run_folder) {
    options.messages.mcap = std::filesystem::path{options.folder} / "run.mcap";
  }
  check_options(options);
  static_cast<void>(config_from(options.config));  // rejects options before the input is opened
  const Input input{open_input(options.input)};
  check_options(options, input);
  const Config config{resolve_preset(options.config, [&] { return choose_preset(input); })};
  warn_of_unread(options.config, config,
                 {input.recording != nullptr && input.recording->gives_disparities(), options.fuse != "none"});
  log_input(input);
  Pipeline pipeline{start_pipeline(config, input.source->rigs(), options.device, pipeline_options(options, input))};
  const FusionStage fusion{fused_source(options.fuse), input, pipeline.vehicle_grid()};
  io::RunRecord record{record_of(options, input, pipeline)};
  const FolderLock lock{record.folder()};
  if (!lock.warning().empty()) spdlog::warn("{}", lock.warning());
  options.resume ? record.resume() : record.begin();
  recall_skipped(*input.source, record);
  io::remove_torn_checkpoint(record.folder());
  std::optional<Page> page;
  if (options.view) {
    page.emplace(options.page, options.folder);
    print("open {}\n", page->server().url());
  }
  ResultWriter writer{writer_options(options, input, pipeline.rig(), record.range().first, page ? &*page : nullptr)};
  const io::Checkpoints checkpoints{record.range().first, static_cast<std::size_t>(options.checkpoint_every),
                                    options.every};
  PoseStage poses{input.poses, input.source->rig(), input.mask,
                  [checkpoints](std::size_t index) { return checkpoints.is_due_after(index); }};
  const Continuation from{continuation_of(record, pipeline, poses, static_cast<std::size_t>(options.warm_up))};
  for (const std::string& warning : from.warnings) spdlog::warn("{}", warning);
  if (!from.note.empty()) spdlog::info("{}", from.note);
  record.continue_from(from.first);
  RunLoop loop{pipeline, poses, fusion, record, writer, from.first, checkpoints, options.input_wait_s};
  catch_interrupts();
  loop.run(*input.source);
  record.save(loop.is_complete());
  if (!loop.is_complete() && !poses.takes_time()) loop.save_state();
  if (spdlog::should_log(spdlog::level::info)) {
    write_output(summary_of(options, input, record, loop.frames_done(), loop.seconds(), loop.is_complete()));
  }
  warn_of_frames(record, input, pipeline);
  for (const std::string& text : loop.places().findings()) spdlog::warn("{}", text);
  if (!loop.is_complete()) return stopped(options, record, loop);
  warn_of_poses(input);
  return exit_done;
}

}  // namespace stereogrid::app
