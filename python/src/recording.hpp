// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "frame_stages.hpp"
#include "geometry.hpp"
#include "input.hpp"
#include "stereogrid/io/frame_queue.hpp"
#include "stereogrid/io/run_folder/run_record.hpp"
#include "stereogrid/io/truth.hpp"

namespace stereogrid::python {

/// Opened input, and its skipped frames. Frames and iterators share it.
class Recording {
 public:
  Recording(std::shared_ptr<const app::Input> input, app::InputOptions options, io::FrameRange range)
      : input_{std::move(input)}, options_{std::move(options)}, range_{range} {}

  [[nodiscard]] const app::Input& input() const { return *input_; }
  [[nodiscard]] const app::InputOptions& options() const { return options_; }
  [[nodiscard]] const FrameSource& source() const { return *input_->source; }
  [[nodiscard]] io::FrameRange range() const { return range_; }
  [[nodiscard]] MountedRig rig() const { return {source().rig(), input_->extrinsics_given, input_->mask}; }
  [[nodiscard]] std::vector<MountedRig> rigs() const;

  /// The same input with other frames.
  [[nodiscard]] std::shared_ptr<Recording> with(io::FrameRange range) const {
    return std::make_shared<Recording>(input_, options_, range);
  }

  [[nodiscard]] bool has_truth() const;
  [[nodiscard]] TruthGrid truth_grid() const;
  /// Throws InputError: no truth of this frame.
  [[nodiscard]] FrameTruth truth(std::size_t index) const;

  std::vector<io::SkippedFrame> skipped{};  ///< skipped in the last iteration

 private:
  [[nodiscard]] const io::TruthReader& reader() const;

  std::shared_ptr<const app::Input> input_;
  app::InputOptions options_;
  io::FrameRange range_;
  mutable std::mutex mutex_;
  mutable std::unique_ptr<io::TruthReader> reader_;  // opened on demand
};

/// A frame, and what its source adds to the result (as capture::PreparedFrame).
struct Frame {
  StereoFrame data;
  std::optional<std::string> warning{};
  std::optional<double> odometry_ms{};
  std::shared_ptr<const Recording> recording{};  ///< none: of arrays
};

/// Time between frames without stamps.
inline constexpr std::int64_t assumed_step_ns{100'000'000};
/// Name of a frame without one, such as "000012".
[[nodiscard]] std::string numbered_name(std::int64_t index);

/// Sets the frames of other cameras, and their others, as the others of `frame`.
void set_others(StereoFrame& frame, std::span<const Frame* const> others);

/// Recording of frames in memory. `poses`: "" those of the frames, "none" or "odometry". Throws InputError,
/// ConfigError.
[[nodiscard]] std::shared_ptr<Recording> recording_of(const std::vector<const Frame*>& frames, const RigOrRigs& rig,
                                                      const std::string& poses);

/// Loads the frames of a recording in order, as `stereogrid run` does: on background threads, with poses placed.
class FrameIterator {
 public:
  /// `first_of` may load a state of the odometry, and returns the first frame. `is_kept`: see PoseStage.
  explicit FrameIterator(std::shared_ptr<Recording> recording,
                         const std::function<std::size_t(app::PoseStage&)>& first_of = {},
                         std::function<bool(std::size_t)> is_kept = {});

  /// Waits for the next frame that can be used; none: the end. Requires the GIL, which it releases while it waits.
  [[nodiscard]] std::unique_ptr<Frame> next();
  [[nodiscard]] app::PoseStage& poses() { return poses_; }

 private:
  [[nodiscard]] std::optional<io::QueuedFrame> wait();
  void skip(const io::QueuedFrame& queued);

  std::shared_ptr<Recording> recording_;
  app::PoseStage poses_;
  io::FrameQueue queue_;
  bool is_checked_{false};  // left and right are not swapped
};

}  // namespace stereogrid::python
