// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "input.hpp"
#include "run/frame_lines.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::app {

struct SkippedFrame {
  std::size_t index{0};
  std::string name;
  std::string reason;
};

struct Percentiles {
  double p50{0};
  double p90{0};
  double p99{0};
  double mean{0};
};

/// A run's folder as a whole: run.json, and what earlier sittings of the run have left.
class RunRecord {
 public:
  /// `settings`: what run.json begins with; a run that goes on must have them in common with its beginning.
  /// `machine`: what it tells besides and may differ.
  RunRecord(std::filesystem::path folder, FrameRange range, nlohmann::ordered_json settings,
            nlohmann::ordered_json machine);

  /// Throws ConfigError where the folder already holds a run.
  void begin();
  /// Takes over what the folder holds; nothing there: as begin(). Throws ConfigError naming the settings that differ,
  /// InputError where the files there cannot be understood.
  void resume();

  /// In the order of the frames.
  void add_frame(FrameSummary frame) { finished_.frames.push_back(std::move(frame)); }
  /// Goes where its index belongs.
  void add_skipped(SkippedFrame frame);
  /// Writes run.json. Throws DeviceError.
  void save(bool complete) const;

  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }
  [[nodiscard]] const FrameRange& range() const { return range_; }
  [[nodiscard]] const FinishedFrames& finished() const { return finished_; }
  [[nodiscard]] const std::vector<SkippedFrame>& skipped() const { return skipped_; }
  /// Before the last finished frame: those that neither are finished nor known to be skipped.
  [[nodiscard]] std::vector<std::size_t> unaccounted() const;
  /// How many of the finished frames carry a flag.
  [[nodiscard]] std::size_t frames_with(FrameStatus flag) const;
  [[nodiscard]] Percentiles timing(double StageTimes::*stage) const;

 private:
  void check_same_settings(const nlohmann::ordered_json& before) const;
  void check_range() const;
  void take_skipped(const nlohmann::ordered_json& before);
  [[nodiscard]] nlohmann::ordered_json frames_json(bool complete) const;
  [[nodiscard]] nlohmann::ordered_json status_json() const;

  std::filesystem::path folder_;
  FrameRange range_;
  nlohmann::ordered_json settings_;
  nlohmann::ordered_json machine_;
  FinishedFrames finished_;
  std::vector<SkippedFrame> skipped_;
};

}  // namespace stereogrid::app
