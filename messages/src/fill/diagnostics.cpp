// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>

#include "fill/fill.hpp"

namespace stereogrid::messages {
namespace {

using diagnostic_msgs::KeyValue;

constexpr std::byte fine{0};
constexpr std::byte warning{1};

// Overwrites the previous frame's values and reuses their memory.
class Values {
 public:
  explicit Values(std::vector<KeyValue>& values) : values_{values} {}

  void add(std::string_view key, std::string_view value) {
    if (used_ == values_.size()) values_.emplace_back();
    values_[used_].key = key;
    values_[used_++].value = value;
  }
  void add(std::string_view key, double value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.6g", value);
    add(key, std::string_view{text.data()});
  }
  void add(std::string_view key, std::int64_t value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%lld", static_cast<long long>(value));
    add(key, std::string_view{text.data()});
  }
  void finish() { values_.resize(used_); }

 private:
  std::vector<KeyValue>& values_;
  std::size_t used_{0};
};

void add_counts(Values& values, const FrameFacts& facts) {
  values.add("frames", facts.frames);
  values.add("dropped", counts_of(facts).dropped);
  for (const Dropped& one : facts.dropped) values.add("dropped: " + one.reason, one.frames);
}

void add_times(Values& values, const StageTimes& times, const FrameFacts& facts) {
  if (facts.latency) {
    values.add("latency_ms", facts.latency->now);
    values.add("latency_median_ms", facts.latency->median);
    values.add("latency_p99_ms", facts.latency->p99);
  }
  values.add("total_ms", times.total);
  values.add("odometry_ms", times.odometry);
  values.add("match_ms", times.match);
  values.add("ground_ms", times.ground);
  values.add("count_ms", times.count);
  values.add("project_ms", times.project);
  values.add("filter_ms", times.filter);
  values.add("flow_ms", times.flow);
  values.add("track_ms", times.track);
}

void add_scene(Values& values, const FrameResult& result) {
  values.add("ground_height_m", result.ground.height_m);
  values.add("ground_pitch_rad", result.ground.pitch_rad);
  values.add("ground_roll_rad", result.ground.roll_rad);
  values.add("ground_estimated", result.ground.estimated ? "true" : "false");
  values.add("obstacle_density", result.obstacle_density);
  values.add("road_density", result.road_density);
  values.add("obstacles", static_cast<std::int64_t>(std::ranges::count_if(result.obstacles, &Obstacle::confirmed)));
  if (result.speed_limit_reason == SpeedReason::none) return;
  values.add("speed_limit_mps", result.speed_limit_mps);
  values.add("speed_limit_reason", names_of(SpeedReason{})[static_cast<std::size_t>(result.speed_limit_reason)]);
}

void write_states(std::string& text, const std::vector<FrameStatus>& states) {
  text.clear();
  for (const FrameStatus state : states) {
    if (!text.empty()) text += ", ";
    text += names_of(state)[static_cast<std::size_t>(state)];
  }
}

}  // namespace

FrameCounts counts_of(const FrameFacts& facts) {
  FrameCounts counts{.used = facts.frames};
  for (const Dropped& one : facts.dropped) counts.dropped += one.frames;
  return counts;
}

void fill(diagnostic_msgs::DiagnosticArray& message, const FrameResult& result, const FrameFacts& facts,
          const FrameCounts& recent, const FrameMessagesOptions& options) {
  message.status.resize(1);
  diagnostic_msgs::DiagnosticStatus& status{message.status.front()};
  const bool is_fine{result.status.empty() && result.warnings.empty() && !recent.are_poor()};
  status.level = is_fine ? fine : warning;
  status.name = options.node;
  status.hardware_id = options.camera_frame;
  write_states(status.message, result.status);
  if (!result.warnings.empty()) status.message = result.warnings.front().text;
  if (is_fine) status.message = "fine";
  if (status.message.empty()) {
    status.message = std::to_string(recent.dropped) + " of the last " + std::to_string(recent.used + recent.dropped) +
                     " frames dropped";
  }
  Values values{status.values};
  add_counts(values, facts);
  add_times(values, result.timing_ms, facts);
  add_scene(values, result);
  values.finish();
}

}  // namespace stereogrid::messages
