// SPDX-License-Identifier: Apache-2.0
#include "live/live.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <map>
#include <utility>

#include "cli/console.hpp"
#include "cli/program.hpp"
#include "diagnostics/frame_tally.hpp"
#include "live/service_manager.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/recording.hpp"

namespace stereogrid::app {
namespace {

using namespace std::chrono_literals;

using capture::Clock;

constexpr auto report_every{10s};
constexpr auto warn_again_after{1min};  // the same text, numbers aside

/// Latencies of the last frames.
class LatencyWindow {
 public:
  /// With the newest one.
  [[nodiscard]] messages::Latency add(std::chrono::nanoseconds latency) {
    const double now_ms{std::chrono::duration<double, std::milli>{latency}.count()};
    if (last_ms_.size() < kept) {
      last_ms_.push_back(now_ms);
    } else {
      last_ms_[next_] = now_ms;
      next_ = (next_ + 1) % kept;
    }
    sorted_ = last_ms_;
    std::ranges::sort(sorted_);
    const std::size_t last{sorted_.size() - 1};
    return {now_ms, sorted_[last / 2], sorted_[last * 99 / 100]};
  }

 private:
  static constexpr std::size_t kept{1000};

  std::vector<double> last_ms_;  // ring buffer when full
  std::size_t next_{0};
  std::vector<double> sorted_;
};

/// Reset requested by a viewer with the parameter "pipeline.reset": true; false again once it is done.
class ResetRequest {
 public:
  [[nodiscard]] server::Parameters parameters() {
    return {{{name, false}}, [this](const server::Parameter& parameter) {
              if (std::get<bool>(parameter.value)) is_wanted_ = true;
              return std::optional<std::string>{};
            }};
  }
  [[nodiscard]] bool take(server::Server& server) {
    if (!is_wanted_.exchange(false)) return false;
    server.set_parameter({name, false});
    return true;
  }

 private:
  static constexpr const char* name{"pipeline.reset"};
  std::atomic<bool> is_wanted_{false};
};

/// The same frames with another preset, for the page only.
class OtherPreset {
 public:
  OtherPreset(const LiveOptions& options, const LiveInput& input, server::Server& viewers)
      : pipeline_{start_pipeline(config_of(options), input.source->rigs(), options.device,
                                 {.mask = input.mask,
                                  .other_masks = input.recording.other_masks,
                                  .camera_names = input.source->camera_names(),
                                  .extrinsics_given = input.recording.extrinsics_given,
                                  .in_world_of_poses = input.in_world_of_poses})},
        sink_{viewer_sink(viewers)},
        messages_{*sink_,
                  pipeline_.rig(),
                  {.node = options.beside + "/stereo_grid",
                   .topics = {"occupancy_grid", "observed_grid", "packed_grid", "obstacles", "left/camera_info",
                              "odometry", "status"}}} {}

  void send(const capture::PreparedFrame& placed, messages::FrameFacts facts) {
    if (placed.resets_before) pipeline_.reset();
    const FrameResult& result{pipeline_.process(placed.frame)};
    messages_.set_rig(result.rig);
    facts.stamp_ns = placed.frame.stamp_ns;
    messages_.send(result, facts);
  }

 private:
  static Config config_of(const LiveOptions& options) {
    ConfigOptions config{options.config};
    config.preset = options.beside;
    return config_from(config);
  }

  Pipeline pipeline_;
  std::unique_ptr<messages::Sink> sink_;
  messages::FrameMessages messages_;
};

/// Takes frames as they come through the pipeline to the viewers.
class LiveLoop final : private capture::FrameHandler {
 public:
  /// `other`: nullptr: none.
  LiveLoop(const LiveInput& input, const FusionStage& fusion, Pipeline& pipeline, MessageOutput& output,
           OtherPreset* other, Page& page, ResetRequest& reset)
      : input_{input},
        fusion_{fusion},
        placed_{input},
        pipeline_{pipeline},
        output_{output},
        other_{other},
        page_{page},
        reset_{reset} {}

  void go_on() {
    service_.notify_ready();
    capture::run_frames(pipeline_, *this);
  }

  void report() {
    const Clock::time_point now{Clock::now()};
    const double seconds{std::chrono::duration<double>{now - reported_}.count()};
    spdlog::info("{} frames ({:.1f} per second), latency {:.1f} ms (99 %: {:.1f} ms){}", frames_,
                 static_cast<double>(frames_ - frames_reported_) / seconds, latency_.median, latency_.p99,
                 dropped_text());
    reported_ = now;
    frames_reported_ = frames_;
  }

  /// Warns of what was wrong with the frames, as `info` and `run` do.
  void report_findings(const Config& config) {
    const auto frame_at = [this](std::size_t index) -> std::optional<StereoFrame> {
      const auto found{poor_frames_.find(index)};
      if (found == poor_frames_.end()) return std::nullopt;
      return found->second;
    };
    const Findings findings{
        findings_of(tally_, {input_.recording, config, input_.source->rig(), pipeline_.next_rig(), frame_at})};
    for (const std::string& text : findings.texts) spdlog::warn("{}", text);
    for (const std::string& text : places_.findings()) spdlog::warn("{}", text);
    const std::string advice{advice_on_preset(config, pipeline_.next_rig())};
    if (!advice.empty()) spdlog::info("{}", advice);
  }

  [[nodiscard]] bool has_frames() const { return frames_ > 0; }

 private:
  [[nodiscard]] bool has_ended() const override { return interrupted() != 0 || placed_.has_ended(); }

  [[nodiscard]] std::optional<capture::PreparedFrame> next() override {
    service_.notify_alive();
    if (reset_.take(page_.server())) placed_.request_reset();
    std::optional<capture::PreparedFrame> placed{placed_.next(100ms)};
    log_fault(input_.source->fault());
    if (Clock::now() - reported_ >= report_every) report();
    if (placed) fusion_warning_ = fusion_.add_grid(placed->frame, placed->recorded, pipeline_.next_rig());
    return placed;
  }

  void deliver(capture::PreparedFrame& placed, FrameResult& result) override {
    latency_ = latencies_.add(Clock::now() - placed.captured);
    if (fusion_warning_) {
      result.warnings.push_back({*fusion_warning_});
      ++alone_;
    }
    log_warnings(result.warnings);
    count(placed, result);
    send(placed, result);
  }

  void refuse(const std::string& reason) override {
    if (reason != refused_reason_) spdlog::warn("a frame cannot be used: {}", reason);
    refused_reason_ = reason;
    ++refused_;
  }

  // The first frames that are examined in the end are kept, and those that may have the other image of a pair.
  void count(const capture::PreparedFrame& placed, const FrameResult& result) {
    const StereoFrame& frame{placed.frame};
    tally_.add(io::summary_of(frame, result));
    places_.add(result);
    const auto index{static_cast<std::size_t>(frame.index)};
    const auto since = [index](const FrameCount& poor) {
      return poor.frames > 0 ? index - poor.first.index : most_late + 1;
    };
    if (since(tally_.with(FrameStatus::few_matches)) > most_late && since(tally_.without_road) != 0) return;
    StereoFrame& kept{poor_frames_.emplace(index, frame).first->second};
    if (input_.recording.source) kept.index = static_cast<std::int64_t>(placed.recorded);
  }

  void send(const capture::PreparedFrame& placed, const FrameResult& result) {
    ++frames_;
    std::vector<messages::Dropped> dropped;
    for (const capture::Drop& drop : placed_.dropped()) dropped.push_back({drop.reason, drop.frames});
    if (refused_ > 0) dropped.push_back({"refused by the pipeline", refused_});
    const messages::FrameFacts facts{
        .latency = latency_, .frames = frames_, .dropped = dropped, .covariances = placed.covariances};
    output_.send(placed.frame, result, facts);
    if (other_ != nullptr) other_->send(placed, facts);
    page_.note(result, facts);
  }

  void log_warnings(const std::vector<Warning>& warnings) {
    const Clock::time_point now{Clock::now()};
    for (const Warning& warning : warnings) {
      const auto [last, is_new]{logged_.try_emplace(without_digits(warning.text), now)};
      const bool is_due{is_new || now - last->second >= warn_again_after};
      if (is_due) last->second = now;
      spdlog::log(is_due ? spdlog::level::warn : spdlog::level::debug, "{}", warning.text);
    }
  }

  // Sentences that count seconds are one and the same.
  void log_fault(const std::string& fault) {
    if (without_digits(fault) == without_digits(fault_)) return;
    if (fault.empty()) {
      spdlog::info("it works again");
    } else {
      spdlog::warn("{}", fault);
    }
    fault_ = fault;
    page_.set_fault(fault);
  }

  [[nodiscard]] std::string dropped_text() const {
    std::string text;
    for (const capture::Drop& drop : placed_.dropped()) {
      text += fmt::format("{} {}: {}", text.empty() ? "; not used:" : ",", drop.reason, drop.frames);
    }
    if (alone_ > 0) text += fmt::format("; not fused: {}", alone_);
    return text;
  }

  const LiveInput& input_;
  const FusionStage& fusion_;
  PlacedFrames placed_;
  Pipeline& pipeline_;
  MessageOutput& output_;
  OtherPreset* other_;
  Page& page_;
  ResetRequest& reset_;
  ServiceManager service_;
  FrameTally tally_;
  PlaceCheck places_{5};
  std::map<std::size_t, StereoFrame> poor_frames_;
  LatencyWindow latencies_;
  messages::Latency latency_;
  std::int64_t frames_{0};
  std::int64_t frames_reported_{0};
  std::int64_t refused_{0};
  std::int64_t alone_{0};  ///< frames without a grid to fuse
  std::string refused_reason_;
  std::optional<std::string> fusion_warning_;  ///< about the other source of the last frame
  std::map<std::string, Clock::time_point> logged_;
  std::string fault_;
  Clock::time_point reported_{Clock::now()};
};

/// Preset by the first frames. Those of a camera are not processed again.
PresetChoice preset_choice_of(const LiveInput& input) {
  if (input.recording.source != nullptr) return choose_preset(input.recording);
  return choose_preset(input.source->rig(), input.recording.extrinsics_given, input.mask,
                       [&]() -> std::optional<StereoFrame> {
                         while (!input.source->has_ended()) {
                           try {
                             if (auto live{input.source->next(100ms)}) return std::move(live->frame);
                           } catch (const InputError& error) {
                             spdlog::warn("a frame cannot be used: {}", error.what());
                           }
                         }
                         return std::nullopt;
                       });
}

/// Logs what is wrong with the first frame of a recording, as `run` does.
void warn_of_first_frame(const Input& input, const Config& config) {
  const Rig& rig{input.source->rig()};
  const StereoFrame first{first_usable_frame(*input.source, {0, input.source->size()})};
  if (first.left.empty()) return;
  for (const std::string& text : faults_of_frame(first, {input, config, rig, rig, {}})) spdlog::warn("{}", text);
}

}  // namespace

int live(const LiveOptions& options) {
  static_cast<void>(config_from(options.config));  // rejects options before the source is opened
  MessageOptions messages{options.messages};
  const LiveInput input{open_live_input(options.input, messages.ros2)};
  check(messages, input.source->rig());
  ConfigOptions parameters{options.config};
  const Config config{resolve_preset(parameters, [&] { return preset_choice_of(input); })};
  const FusedSource fused{fused_source(options.input.fuse)};
  const io::Recording* const recording{input.recording.recording};
  warn_of_unread(parameters, config,
                 {recording != nullptr && recording->gives_disparities(), fused != FusedSource::none});
  Pipeline pipeline{start_pipeline(config, input.source->rigs(), options.device,
                                   {.horizons_s = options.predict_s,
                                    .mask = input.mask,
                                    .other_masks = input.recording.other_masks,
                                    .camera_names = input.source->camera_names(),
                                    .extrinsics_given = input.recording.extrinsics_given,
                                    .in_world_of_poses = input.in_world_of_poses})};
  const FusionStage fusion{fused, input.recording, pipeline.vehicle_grid()};
  ResetRequest reset;
  Page page{options.page, input.kind, reset.parameters()};
  MessageOutput output{messages, &page.server(), pipeline.rig()};
  std::optional<OtherPreset> other;
  if (!options.beside.empty()) other.emplace(options, input, page.server());
  catch_interrupts();
  if (recording != nullptr) warn_of_first_frame(input.recording, config);
  print("open {}\n", page.server().url());
  if (!failed_output().empty()) return exit_try_again;  // run_program() says it
  LiveLoop loop{input, fusion, pipeline, output, other ? &*other : nullptr, page, reset};
  loop.go_on();
  output.finish();
  loop.report();
  loop.report_findings(config);
  if (interrupted() == 0) {
    if (const auto text{contradiction_of_poses(input.recording)}) spdlog::warn("{}", *text);
  }
  if (interrupted() != 0 || loop.has_frames()) return exit_done;
  throw InputError{input.kind, "has ended without a frame that could be used.", "The warnings above say why."};
}

void add_live_command(Command tool, int& exit_code) {
  auto options{std::make_shared<LiveOptions>()};
  const Command command{tool.add_command(
      "live", "Show grids of a camera, or of a recording at its own pace, in the browser; Ctrl-C ends it.")};
  command.footer(
      "INPUT is a recording as of 'run', or a camera with --calibration: /dev/video0 /dev/video2 (two devices), "
      "/dev/video0 (both images side by side), 'gst:…' (a GStreamer pipeline: docs/live.md), "
      "or ros2:/NAMESPACE: cameras that publish there (docs/ros2.md), several stereo pairs with --cameras.\n\n"
      "Examples:\n"
      "  stereogrid live drives/0009 --loop\n"
      "  stereogrid live /dev/video0 /dev/video2 --calibration stereo.yaml\n"
      "  stereogrid live 'gst:rtspsrc location=rtsp://robot/stereo ! decodebin' \\\n"
      "      --calibration stereo.yaml\n"
      "  stereogrid live ros2:/stereo --poses /odom --ros2\n"
      "  stereogrid live ros2: --cameras /front,/rear --poses tf --ros2");
  add_input_options(command, options->input.input);
  command.group(Group::input);
  command.add_flag("--loop", options->input.loops, "Restart after the last frame.");
  command.add_option("--speed X", options->input.speed, "Speed of a recording; 2: twice as fast.")
      .check(number(0.01, 100))
      .show_default();
  add_config_options(command, options->config);
  add_fuse_option(command, options->input.fuse);
  add_device_options(command, options->device);
  command.group(Group::output);
  add_recording_option(command, options->messages, false);
  command.add_option("--predict S,S,...", options->predict_s,
                     "Horizons in seconds of predicted grids, as topics predicted_grid_<s>.");
  add_message_options(command, options->messages);
  command.group(Group::messages);
  command
      .add_option(
          "--ros2-camera-at X,Y,YAW", options->messages.ros2.camera_at,
          "For ros2:/… with its poses: place of the left camera in the robot's frame (base_link), m ahead, m to the "
          "left, degrees to the left. Otherwise TF's.")
      .expected(3);
  command.add_flag("--ros2-sim-time", options->messages.ros2.uses_sim_time,
                   "For ros2:/…: use the time of /clock, as with use_sim_time; if it steps back, all begins "
                   "anew.");
  add_page_options(command, options->page);
  command.add_option("--beside PRESET", options->beside, "Show the grids of another preset, too, beside these.")
      .one_of({"default", "robot", "paper"});
  command.callback([options, &exit_code] { exit_code = live(*options); });
}

}  // namespace stereogrid::app
