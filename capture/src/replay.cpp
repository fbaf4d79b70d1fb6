// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/capture/live_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>

#include "pairing.hpp"
#include "stereogrid/capture/latest.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/frame_queue.hpp"

namespace stereogrid::capture {
namespace {

/// Interval if all frames have one stamp, and between the last frame and the first one of the next round.
constexpr std::int64_t usual_step_ns{100'000'000};

struct Played {
  io::QueuedFrame queued;
  Clock::time_point captured;
  int round{0};
};

class Replay final : public LiveSource {
 public:
  Replay(const FrameSource& source, const ReplayOptions& options)
      : source_{source}, options_{options}, thread_{[this](const std::stop_token& stop) { run(stop); }} {}

  [[nodiscard]] const Rig& rig() const override { return source_.rig(); }
  [[nodiscard]] std::span<const Rig> rigs() const override { return source_.rigs(); }
  [[nodiscard]] std::vector<std::string> camera_names() const override { return source_.camera_names(); }
  [[nodiscard]] std::optional<LiveFrame> next(std::chrono::milliseconds patience) override;
  [[nodiscard]] bool has_ended() const override { return latest_.has_ended() && !has_failure_; }
  [[nodiscard]] std::string fault() const override { return ""; }
  [[nodiscard]] std::vector<Drop> dropped() const override;

 private:
  void run(const std::stop_token& stop);
  void run_round(const std::stop_token& stop, int round);
  void wait_until(const std::stop_token& stop, Clock::time_point due);
  [[nodiscard]] Clock::duration real(std::int64_t recorded_ns) const {
    const double ns{static_cast<double>(recorded_ns) / options_.speed};
    return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double, std::nano>{ns});
  }

  const FrameSource& source_;
  const ReplayOptions options_;
  UnixTime unix_time_;
  Latest<Played> latest_;
  std::int64_t given_{0};
  int last_round_{0};
  std::atomic<std::int64_t> unusable_{0};
  std::exception_ptr failure_;  // before latest_ ends
  std::atomic<bool> has_failure_{false};
  std::mutex mutex_;
  std::condition_variable_any stopped_;
  // used by the thread
  Clock::time_point due_{Clock::now()};
  std::int64_t stamp_ns_{unix_time_.ns(due_)};
  std::jthread thread_;
};

std::optional<LiveFrame> Replay::next(std::chrono::milliseconds patience) {
  std::optional<Played> played{latest_.take(patience)};
  if (!played) {
    if (latest_.has_ended() && has_failure_.exchange(false)) std::rethrow_exception(failure_);
    return std::nullopt;
  }
  if (!played->queued.frame) {
    ++unusable_;
    throw InputError{played->queued.error};
  }
  const bool resets_before{played->round != std::exchange(last_round_, played->round)};
  LiveFrame live{std::move(*played->queued.frame), played->captured, resets_before, played->queued.index};
  live.frame.index = given_++;
  return live;
}

std::vector<Drop> Replay::dropped() const {
  std::vector<Drop> drops{{"a newer one came", latest_.replaced()}, {"cannot be used", unusable_}};
  std::erase_if(drops, [](const Drop& drop) { return drop.frames == 0; });
  return drops;
}

void Replay::wait_until(const std::stop_token& stop, Clock::time_point due) {
  std::unique_lock lock{mutex_};
  stopped_.wait_until(lock, stop, due, [] { return false; });
}

void Replay::run_round(const std::stop_token& stop, int round) {
  io::FrameQueue queue{source_, options_.first, options_.last == 0 ? source_.size() : options_.last, 2};
  std::optional<std::int64_t> last_ns;
  while (!stop.stop_requested()) {
    std::optional<io::QueuedFrame> queued{queue.next()};
    if (!queued) return;
    std::int64_t step_ns{usual_step_ns};
    if (queued->frame) {
      std::int64_t& recorded_ns{queued->frame->stamp_ns};
      if (last_ns && recorded_ns > *last_ns) step_ns = recorded_ns - *last_ns;
      if (!last_ns && round == 0) step_ns = 0;
      last_ns = recorded_ns;
      stamp_ns_ += step_ns;
      for (StereoFrame& other : queued->frame->others) other.stamp_ns += stamp_ns_ - recorded_ns;
      recorded_ns = stamp_ns_;
    }
    due_ = std::max(due_ + real(step_ns), Clock::now());
    wait_until(stop, due_);
    latest_.put({std::move(*queued), Clock::now(), round});
  }
}

void Replay::run(const std::stop_token& stop) {
  try {
    run_round(stop, 0);
    for (int round{1}; options_.loops && !stop.stop_requested(); ++round) run_round(stop, round);
  } catch (...) {
    failure_ = std::current_exception();
    has_failure_ = true;
  }
  latest_.end();
}

}  // namespace

std::unique_ptr<LiveSource> replay(const FrameSource& source, const ReplayOptions& options) {
  const std::size_t last{options.last == 0 ? source.size() : options.last};
  if (!(options.speed > 0) || options.first >= last || last > source.size()) {
    throw ConfigError{fmt::format("Frames {} to {} of {} cannot be played at speed {}.", options.first, last,
                                  source.size(), options.speed)};
  }
  return std::make_unique<Replay>(source, options);
}

}  // namespace stereogrid::capture
