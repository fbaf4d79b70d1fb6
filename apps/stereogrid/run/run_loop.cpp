// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "run/run_loop.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <utility>

#include "commands.hpp"
#include "complaints/frame_tally.hpp"
#include "console.hpp"
#include "interrupt.hpp"
#include "progress.hpp"
#include "run/frame_wait.hpp"
#include "run/resume.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid::app {
namespace {

constexpr std::size_t frames_ahead{4};

}  // namespace

RunLoop::RunLoop(Pipeline& pipeline, PoseStage& poses, const LidarStage& lidar, io::RunRecord& record,
                 ResultWriter& writer, std::size_t first_frame, const io::Checkpoints& checkpoints, int input_wait_s)
    : pipeline_{pipeline},
      poses_{poses},
      lidar_{lidar},
      record_{record},
      writer_{writer},
      first_frame_{first_frame},
      checkpoints_{checkpoints},
      input_wait_s_{input_wait_s},
      first_to_write_{first_to_do(record)} {}

void RunLoop::go_through(const FrameSource& source) {
  const std::size_t total{record_.range().end - first_to_write_};
  Progress progress{"frames", total};
  // a second thread, so that the next frame is read while this one's motion is found
  const int threads{poses_.takes_time() ? 2 : 1};
  io::FrameQueue queue{
      source,       first_frame_, record_.range().end,
      frames_ahead, threads,      [this](io::QueuedFrame& queued) { queued.warning = poses_.place(*queued.frame); }};
  while (interrupted() == 0) {
    if (!wait_for_frame(queue, next_, input_wait_s_)) give_up_waiting();
    if (!take_next(queue)) break;
    progress.update(total - (record_.range().end - next_));
  }
  writer_.finish();
  seconds_ = progress.seconds();
}

bool RunLoop::save_state() const {
  if (!last_processed_) return false;
  std::optional<io::OdometryState> odometry{poses_.take_state(*last_processed_)};
  if (poses_.takes_time() && !odometry) return false;
  io::write_checkpoint(record_.folder(), {*last_processed_, pipeline_.save_state(), std::move(odometry)});
  return true;
}

bool RunLoop::take_next(io::FrameQueue& queue) {
  std::optional<io::QueuedFrame> queued;
  try {
    queued = queue.next();
  } catch (const DeviceError& error) {
    unavailable_ = error.what();
  }
  if (queued) take(std::move(*queued));
  return queued && unavailable_.empty();
}

std::optional<std::string> RunLoop::add_lidar(StereoFrame& frame, const Rig& rig) {
  try {
    return lidar_.add_grid(frame, rig);
  } catch (const DeviceError& error) {
    unavailable_ = error.what();
    return std::nullopt;
  }
}

void RunLoop::take(io::QueuedFrame queued) {
  next_ = std::max(next_, queued.index + 1);
  if (!queued.frame) return skip(queued, queued.error);
  try {
    FrameResult result;
    const Rig rig{pipeline_.rig()};  // a mounting that this frame shows is of the next one
    const std::optional<std::string> without_lidar{add_lidar(*queued.frame, rig)};
    if (!without_lidar) return;
    pipeline_.process(*queued.frame, result);
    last_processed_ = queued.index;
    if (queued.index < first_to_write_) return;
    if (poses_.takes_time()) result.timing_ms.odometry = queued.prepared_ms;
    if (!queued.warning.empty()) result.warnings.push_back(queued.warning);
    if (!without_lidar->empty()) result.warnings.push_back(record_.told(*without_lidar));
    tell_warnings(queued.name, result.warnings);
    ++frames_done_;
    record_.set_rigs(pipeline_.rig(), pipeline_.level_rig());
    if (!record_.is_written(queued.index)) return;
    record_.add_frame(io::summary_of(*queued.frame, result));
    writer_.write(std::move(*queued.frame), std::move(result), rig, checkpoint_after(queued.index));
  } catch (const InputError& error) {
    skip(queued, error.what());
  }
}

// The thread that waits for the file system cannot be ended: the process is.
void RunLoop::give_up_waiting() {
  writer_.finish();
  record_.save(false);
  write_error(
      fmt::format("stereogrid: frame {} has not come within {} s: the file system of the input hangs, or is "
                  "gone. What is done is safe; the same command with --resume goes on.\n",
                  next_, input_wait_s_));
  std::_Exit(exit_try_again);
}

std::optional<io::Checkpoint> RunLoop::checkpoint_after(std::size_t index) {
  if (!checkpoints_.is_due_after(index)) return std::nullopt;
  save_skipped();  // behind a checkpoint nobody finds out again what was skipped before it
  return io::Checkpoint{index, pipeline_.save_state(), poses_.take_state(index)};
}

void RunLoop::skip(const io::QueuedFrame& queued, const std::string& reason) {
  if (queued.index < record_.range().first || record_.is_skipped(queued.index)) return;
  spdlog::warn("frame {} is skipped: {}", queued.name, reason);
  record_.add_skipped({queued.index, queued.name, reason});
  // it tells of all of them: written for each it would take as long as they are many, squared
  if (std::has_single_bit(record_.skipped().size())) save_skipped();
}

void RunLoop::save_skipped() {
  if (skipped_saved_ == record_.skipped().size()) return;
  skipped_saved_ = record_.skipped().size();
  record_.save(false);
}

void RunLoop::tell_warnings(const std::string& name, const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) {
    const bool is_new{told_.insert(without_digits(warning)).second};
    spdlog::log(is_new ? spdlog::level::warn : spdlog::level::debug, "frame {}: {}", name, warning);
  }
}

}  // namespace stereogrid::app
