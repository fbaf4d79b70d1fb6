// SPDX-License-Identifier: Apache-2.0
#include "run/run.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cstdlib>
#include <utility>

#include "cli/console.hpp"
#include "cli/program.hpp"
#include "diagnostics/frame_tally.hpp"
#include "run/resume.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid::app {
namespace {

/// Time for a frame that is being read when a stop is requested.
constexpr std::chrono::seconds stop_wait{2};

/// Waits for the next frame of the queue, the input's frame `index`, for `limit`, or `stop_wait` after a stop was
/// requested; logs a long wait, as on a lost network file system. False: it has not come.
bool wait_for_frame(io::FrameQueue& queue, std::size_t index, std::chrono::seconds limit) {
  constexpr std::chrono::milliseconds look_around{200};
  constexpr std::chrono::seconds long_wait{10};
  const auto start{std::chrono::steady_clock::now()};
  auto end{start + limit};
  bool is_reported{false};
  bool is_stopped{false};
  while (!queue.is_ready_within(look_around)) {
    const auto now{std::chrono::steady_clock::now()};
    if (interrupted() != 0 && !std::exchange(is_stopped, true)) end = std::min(end, now + stop_wait);
    if (now >= end) return false;
    if (is_reported || now < start + long_wait) continue;
    spdlog::warn("frame {} has not come for {} s: is the input's file system slow, or gone? Ctrl-C ends the run", index,
                 long_wait.count());
    is_reported = true;
  }
  return true;
}

constexpr std::size_t frames_ahead{4};

/// Adds the time until its end to `seconds`.
class Stopwatch {
 public:
  explicit Stopwatch(double& seconds) : seconds_{seconds} {}
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;
  ~Stopwatch() { seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

 private:
  double& seconds_;
  std::chrono::steady_clock::time_point start_{std::chrono::steady_clock::now()};
};

/// A thread that waits for a file system cannot be ended; the process can.
[[noreturn]] void end_process(const std::string& reason) {
  write_error(fmt::format("stereogrid: {}\n", reason));
  flush_errors();
  std::_Exit(exit_try_again);
}

}  // namespace

RunLoop::RunLoop(Pipeline& pipeline, PoseStage& poses, const FusionStage& fusion, io::RunRecord& record,
                 ResultWriter& writer, std::size_t first_frame, const io::Checkpoints& checkpoints, int input_wait_s)
    : pipeline_{pipeline},
      poses_{poses},
      fusion_{fusion},
      record_{record},
      writer_{writer},
      first_frame_{first_frame},
      checkpoints_{checkpoints},
      input_wait_s_{input_wait_s},
      first_to_write_{first_to_do(record)} {}

void RunLoop::run(const FrameSource& source) {
  const std::size_t total{record_.range().end - first_to_write_};
  Progress progress{"frames", total};
  // a second thread, so that the next frame is read while this one's motion is found
  const int threads{poses_.takes_time() ? 2 : 1};
  io::FrameQueue queue{source,       first_frame_, record_.range().end,
                       frames_ahead, threads,      [this](io::QueuedFrame& queued) { poses_.place(queued); }};
  queue_ = &queue;
  progress_ = &progress;
  try {
    capture::run_frames(pipeline_, *this);
    if (!queue.stop_within(stop_wait)) give_up_waiting();
    const Stopwatch writing{seconds_.writing};
    writer_.finish();
  } catch (const DeviceError& error) {
    if (queue.stop_within(stop_wait)) throw;
    end_process(error.what());
  }
  seconds_.total = progress.seconds();
}

bool RunLoop::save_state() const {
  if (!last_processed_) return false;
  std::optional<OdometryState> odometry{poses_.take_state(*last_processed_)};
  if (poses_.takes_time() && !odometry) return false;
  io::write_checkpoint(record_.folder(), {*last_processed_, pipeline_.save_state(), std::move(odometry)});
  return true;
}

std::optional<capture::PreparedFrame> RunLoop::next() {
  const Stopwatch reading{seconds_.reading};
  progress_->update(next_ - first_to_write_);
  has_ended_ = interrupted() != 0;
  if (has_ended_) return std::nullopt;
  if (!wait_for_frame(*queue_, next_, std::chrono::seconds{input_wait_s_})) give_up_waiting();
  has_ended_ = interrupted() != 0 || !load();
  if (has_ended_ || !queued_.frame) return std::nullopt;
  capture::PreparedFrame prepared{
      .frame = std::move(*queued_.frame), .warning = queued_.warning, .covariances = queued_.covariances};
  if (poses_.takes_time()) prepared.odometry_ms = queued_.prepared_ms;
  return prepared;
}

bool RunLoop::load() {
  try {
    std::optional<io::QueuedFrame> queued{queue_->next()};
    if (!queued) return false;
    queued_ = std::move(*queued);
    next_ = std::max(next_, queued_.index + 1);
    if (!queued_.frame) {
      skip(queued_.error);
      return true;
    }
    fusion_warning_ = fusion_.add_grid(*queued_.frame, queued_.index, pipeline_.next_rig());
    return true;
  } catch (const DeviceError& error) {
    unavailable_ = error.what();
    return false;
  }
}

void RunLoop::deliver(capture::PreparedFrame& prepared, FrameResult& result) {
  last_processed_ = queued_.index;
  if (queued_.index < first_to_write_) return;
  if (fusion_warning_) result.warnings.push_back({*fusion_warning_});
  log_warnings(queued_.name, result.warnings);
  places_.add(result);
  ++frames_done_;
  record_.set_rig(pipeline_.next_rig());
  if (!record_.is_written(queued_.index)) return;
  record_.add_frame(io::summary_of(prepared.frame, result));
  const Stopwatch writing{seconds_.writing};
  result = writer_.write(std::move(prepared), std::move(result), checkpoint_after(queued_.index));
}

void RunLoop::give_up_waiting() {
  try {
    writer_.finish();
    record_.save(false);
  } catch (const DeviceError& error) {  // the output's
    end_process(error.what());
  }
  const std::string what{interrupted() == 0 ? fmt::format("frame {} has not come within {} s", next_, input_wait_s_)
                                            : "stopped while a frame was being read"};
  end_process(what +
              ": the file system of the input hangs, or is gone. Finished frames are complete; the same command "
              "with --resume continues.");
}

std::optional<io::Checkpoint> RunLoop::checkpoint_after(std::size_t index) {
  if (!checkpoints_.is_due_after(index)) return std::nullopt;
  save_skipped();  // a resumed run does not search frames before its checkpoint
  return io::Checkpoint{index, pipeline_.save_state(), poses_.take_state(index)};
}

void RunLoop::skip(const std::string& reason) {
  if (queued_.index < record_.range().first || record_.is_skipped(queued_.index)) return;
  spdlog::warn("frame {} is skipped: {}", queued_.name, reason);
  record_.add_skipped({queued_.index, queued_.name, reason});
  // at powers of two, as the file lists all of them: cost stays linear
  if (std::has_single_bit(record_.skipped().size())) save_skipped();
}

void RunLoop::save_skipped() {
  if (skipped_saved_ == record_.skipped().size()) return;
  skipped_saved_ = record_.skipped().size();
  record_.save(false);
}

void RunLoop::log_warnings(const std::string& name, const std::vector<Warning>& warnings) {
  for (const Warning& warning : warnings) {
    const bool is_new{reported_.insert(without_digits(warning.text)).second};
    spdlog::log(is_new ? spdlog::level::warn : spdlog::level::debug, "frame {}: {}", name, warning.text);
  }
}

}  // namespace stereogrid::app
