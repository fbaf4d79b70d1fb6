// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "cli/config_options.hpp"
#include "connect/message_output.hpp"
#include "connect/page.hpp"
#include "connect/ros2_node.hpp"
#include "frame_stages.hpp"
#include "input.hpp"
#include "stereogrid/capture/frame_loop.hpp"
#include "stereogrid/capture/latest.hpp"
#include "stereogrid/capture/live_source.hpp"

namespace stereogrid::app {

struct LiveInputOptions {
  InputOptions input;  ///< whose paths are SOURCE
  bool loops{false};
  double speed{1};
  std::string fuse{"none"};
};

/// Opened SOURCE.
struct LiveInput {
  Input recording{};  ///< with a source where it is one; has to live longer than `source`
  std::unique_ptr<capture::LiveSource> source;
  std::string kind;
  PoseSource poses{PoseSource::odometry};
  bool in_world_of_poses{false};  ///< PipelineOptions::in_world_of_poses
  Image<std::uint8_t> mask{};
};

/// `ros2`: for a SOURCE there. Throws ConfigError, InputError, DeviceError.
[[nodiscard]] LiveInput open_live_input(const LiveInputOptions& options, Ros2Options& ros2);

struct LiveOptions {
  LiveInputOptions input;
  ConfigOptions config;
  DeviceOptions device;
  std::vector<double> predict_s;
  MessageOptions messages;
  PageOptions page;
  std::string beside;  ///< preset whose grids the page shows, too; empty: none
};

/// `stereogrid live`. Returns the exit code; throws ConfigError, InputError, DeviceError.
[[nodiscard]] int live(const LiveOptions& options);

/// True if SOURCE is "ros2:/NAMESPACE", or "ros2:" for any namespace.
[[nodiscard]] bool is_ros2(const std::string& source);

/// Opens two cameras, or a camera with depth, on the network. Waits until both topics have images, and CameraInfo if no
/// calibration is given, and of grids to fuse; waiting is reported. Throws ConfigError: options that do not fit;
/// DeviceError; InputError: no pair of cameras. Sets the options in `ros2` that follow from the poses.
[[nodiscard]] LiveInput open_ros2_input(const InputOptions& options, FusedSource fused, Ros2Options& ros2);

/// Frames of a live source with their poses, which are found on a thread of its own: a frame's while the pipeline works
/// on the one before. Never more than one waits. All functions are for one thread.
class PlacedFrames {
 public:
  /// The input has to live longer.
  explicit PlacedFrames(const LiveInput& input);
  PlacedFrames(const PlacedFrames&) = delete;
  PlacedFrames& operator=(const PlacedFrames&) = delete;
  ~PlacedFrames();

  /// As LiveSource::next(); unusable frames are reported and counted. Throws other errors that end the source.
  [[nodiscard]] std::optional<capture::PreparedFrame> next(std::chrono::milliseconds patience);
  [[nodiscard]] bool has_ended() const { return latest_.has_ended() && !failure_; }
  /// By the source, and here.
  [[nodiscard]] std::vector<capture::Drop> dropped() const;
  /// Frames that are not placed yet are another stream's; one that waits already is not.
  void request_reset() { is_reset_requested_ = true; }

 private:
  struct PlacedFrame {
    capture::PreparedFrame prepared;
    std::int64_t stream;  ///< frames of another stream do not belong to it
  };

  void place_all();
  void place_next();
  void take(capture::LiveFrame live);
  void log_unusable(const std::string& reason);

  const LiveInput& input_;
  capture::Latest<PlacedFrame> latest_;
  std::atomic<bool> is_reset_requested_{false};
  std::atomic<bool> is_to_stop_{false};
  std::atomic<std::int64_t> refused_{0};
  std::int64_t taken_stream_{0};  ///< last frame of next()
  std::exception_ptr failure_;    // before latest_ ends
  // used by the thread
  std::optional<PoseStage> poses_;
  std::int64_t stream_{0};
  std::string reported_;
  std::thread thread_;
};

}  // namespace stereogrid::app
