// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "stereogrid/pipeline.hpp"

namespace stereogrid::app {

/// Which file, and which topics of docs/messages.md.
struct McapOptions {
  std::filesystem::path file;       ///< empty: none
  std::vector<std::string> topics;  ///< empty: all
};

/// Throws ConfigError: a topic that does not exist, topics without a file, a file that is there already.
void check_mcap(const McapOptions& options, const Rig& rig);

/// Is something recorded that is made of FrameResult::stages?
[[nodiscard]] bool needs_stages(const McapOptions& options);

/// What is known after each frame as ROS 2 messages in an MCAP file.
class McapRecorder {
 public:
  /// `rig`: of the first frame; `first_frame`: its place in the input. Throws DeviceError.
  McapRecorder(const McapOptions& options, const Rig& rig, std::size_t first_frame);
  ~McapRecorder();

  /// `rig`: of this frame. Throws DeviceError.
  void add(const StereoFrame& frame, const FrameResult& result, const Rig& rig);
  /// Throws DeviceError.
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace stereogrid::app
