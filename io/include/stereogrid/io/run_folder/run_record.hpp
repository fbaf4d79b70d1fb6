// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "stereogrid/export.hpp"
#include "stereogrid/io/run_folder/description.hpp"
#include "stereogrid/io/run_folder/frame_lines.hpp"
#include "stereogrid/result.hpp"

namespace stereogrid::io {

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

/// A run's folder as a whole: run.json, and what earlier calls of the program have left of it.
class STEREOGRID_EXPORT RunRecord {
 public:
  RunRecord(std::filesystem::path folder, RunDescription run);

  /// Throws ConfigError where the folder already holds a run.
  void begin();
  /// Takes over what the folder holds; nothing there: as begin(). Throws ConfigError naming the settings that differ,
  /// InputError where the files there cannot be understood.
  void resume();

  /// In the order of the frames.
  void add_frame(FrameSummary frame) { finished_.push_back(std::move(frame)); }
  /// Goes where its index belongs.
  void add_skipped(SkippedFrame frame);
  /// Continues from a frame: later frames are processed again, and their skipped frames are recorded again.
  void continue_from(std::size_t index);
  /// Sets Pipeline::next_rig() after the last frame. Default: the description's rig.
  void set_rig(const Rig& mounted) { mounted_rig_ = mounted; }
  /// Writes run.json. Throws DeviceError.
  void save(bool complete) const;

  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }
  [[nodiscard]] const FrameRange& range() const { return run_.frames; }
  [[nodiscard]] std::size_t every() const { return run_.every; }
  [[nodiscard]] const std::vector<FrameSummary>& finished() const { return finished_; }
  [[nodiscard]] const std::vector<SkippedFrame>& skipped() const { return skipped_; }
  [[nodiscard]] bool is_skipped(std::size_t index) const;
  /// True if the frame is one of those that are written (RunDescription::every).
  [[nodiscard]] bool is_written(std::size_t index) const { return index % run_.every == 0; }
  /// Number of frames that the run writes where none is skipped.
  [[nodiscard]] std::size_t frames_to_write() const {
    return multiples_between(run_.frames.first, run_.frames.end - 1, run_.every);
  }
  /// Before the last finished frame: those that are written, but neither are finished nor known to be skipped.
  [[nodiscard]] std::vector<std::size_t> unaccounted() const;
  /// Number of finished frames with a flag.
  [[nodiscard]] std::size_t frames_with(FrameStatus flag) const;
  [[nodiscard]] Percentiles timing(double StageTimes::*stage) const;

 private:
  void check_range() const;
  void check_grids() const;

  std::filesystem::path folder_;
  RunDescription run_;
  Rig mounted_rig_;
  std::vector<FrameSummary> finished_;
  std::vector<SkippedFrame> skipped_;
};

// The .npz files of a frame; their arrays are listed in docs/format.md. Throw DeviceError.

/// The arrays that write_grids or write_compact_grids can write, but for world_origin, which comes with those of the
/// world, in the order of the file.
[[nodiscard]] STEREOGRID_EXPORT std::vector<std::string> grid_arrays(bool compact);

/// `layers`: some of grid_arrays(); none: all.
STEREOGRID_EXPORT void write_grids(const std::filesystem::path& path, const FrameResult& result,
                                   const std::vector<std::string>& layers = {});
/// The vehicle grid alone, in half as many bits: occupancies to 1/256, velocities to 1/16 m/s, ages to 1/64 s.
STEREOGRID_EXPORT void write_compact_grids(const std::filesystem::path& path, const FrameResult& result,
                                           const std::vector<std::string>& layers = {});
/// The frame must have predictions.
STEREOGRID_EXPORT void write_predictions(const std::filesystem::path& path, const FrameResult& result);
/// Writes every stage image that is not empty.
STEREOGRID_EXPORT void write_stages(const std::filesystem::path& path, const StageImages& stages);

}  // namespace stereogrid::io
