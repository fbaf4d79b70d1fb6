// SPDX-License-Identifier: Apache-2.0
#include "view/playback.hpp"

#include <algorithm>

namespace stereogrid::app {
namespace {

constexpr double slowest{0.05};
constexpr double fastest{20};
constexpr double half_nanosecond_s{0.5e-9};
constexpr double longest_gap_s{1e8};  // the clock counts nanoseconds in 64 bits

}  // namespace

Playback::Playback(std::vector<std::uint64_t> stamps_ns) : stamps_ns_{std::move(stamps_ns)} {}

PlaybackState Playback::state() const {
  const std::scoped_lock lock{mutex_};
  return state_;
}

double Playback::time_s(std::int64_t frame) const {
  return seconds_since_first(stamps_ns_.at(static_cast<std::size_t>(frame)));
}

double Playback::seconds_since_first(std::uint64_t stamp_ns) const {
  return static_cast<double>(stamp_ns - stamps_ns_.front()) * 1e-9;
}

std::vector<server::Parameter> Playback::parameters_of(const PlaybackState& state) const {
  return {{"player.frame", state.frame}, {"player.time_s", time_s(state.frame)}, {"player.playing", state.playing},
          {"player.speed", state.speed}, {"player.frames", last() + 1},          {"player.duration_s", time_s(last())}};
}

std::optional<std::string> Playback::set(const server::Parameter& parameter) {
  const std::scoped_lock lock{mutex_};
  if (auto refusal{change(parameter)}) return refusal;
  schedule(Clock::now());
  is_changed_ = true;
  changed_.notify_all();
  return std::nullopt;
}

std::optional<std::string> Playback::change(const server::Parameter& parameter) {
  if (parameter.name == "player.playing") {
    state_.playing = std::get<bool>(parameter.value);
    if (state_.playing && state_.frame == last()) state_.frame = 0;
  } else if (parameter.name == "player.frame") {
    const std::int64_t frame{std::get<std::int64_t>(parameter.value)};
    if (frame < 0 || frame > last()) return "frames go from 0 to " + std::to_string(last()) + ".";
    state_.frame = frame;
  } else if (parameter.name == "player.time_s") {
    const double requested_s{std::max(std::get<double>(parameter.value), 0.0) + half_nanosecond_s};
    const auto later{std::ranges::partition_point(
        stamps_ns_, [&](std::uint64_t stamp_ns) { return seconds_since_first(stamp_ns) <= requested_s; })};
    state_.frame = later - stamps_ns_.begin() - 1;
  } else if (parameter.name == "player.speed") {
    const double speed{std::get<double>(parameter.value)};
    if (speed < slowest || speed > fastest) return "speeds go from 0.05 to 20.";
    state_.speed = speed;
  } else {
    return "it can only be read.";
  }
  return std::nullopt;
}

// At the end it stands.
void Playback::schedule(Clock::time_point from) {
  if (state_.frame == last()) state_.playing = false;
  if (!state_.playing) return;
  const double gap_s{std::min((time_s(state_.frame + 1) - time_s(state_.frame)) / state_.speed, longest_gap_s)};
  due_ = from + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>{gap_s});
}

// Frames that take too long to read come late; none is left out.
void Playback::advance() {
  const Clock::time_point now{Clock::now()};
  if (is_changed_ || !state_.playing || now < due_) return;
  ++state_.frame;
  schedule(due_);
  due_ = std::max(due_, now);
}

PlaybackState Playback::wait(std::chrono::milliseconds patience) {
  std::unique_lock lock{mutex_};
  Clock::time_point until{Clock::now() + patience};
  if (state_.playing) until = std::min(until, due_);
  changed_.wait_until(lock, until, [&] { return is_changed_; });
  advance();
  is_changed_ = false;
  return state_;
}

}  // namespace stereogrid::app
