// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stereogrid/camera.hpp"
#include "stereogrid/export.hpp"
#include "stereogrid/messages/sink.hpp"
#include "stereogrid/occupancy_values.hpp"
#include "stereogrid/result.hpp"

namespace stereogrid::messages {

struct FrameMessagesOptions {
  std::string node{"stereo_grid"};                  ///< topics are /NODE/…; letters, digits, _, and / between
  std::string world_frame{"odom"};                  ///< of FrameResult::world
  std::string vehicle_frame{"base_link"};           ///< of FrameResult::vehicle
  std::string camera_frame{"stereo_left_optical"};  ///< of the left camera; with "_level" behind it: of the level rig
  OccupancyScale scale{OccupancyScale::percent};    ///< of all occupancy grids
  /// Which to send, as docs/messages.md names them: "occupancy_grid", "tf", …; empty: all.
  std::vector<std::string> topics{};
};

/// Frames that were not used, and why.
struct Dropped {
  std::string reason;
  std::int64_t frames{0};
};

/// From exposure until the grid is there, ms.
struct Latency {
  double now{0};
  double median{0};  ///< of the last frames; so is the 99th percentile
  double p99{0};
};

/// What is told of a frame that FrameResult does not know.
struct FrameFacts {
  std::int64_t stamp_ns{0};  ///< StereoFrame::stamp_ns
  /// Makes the left image with what is drawn on it, as JPEG, and the u-disparity grid; called where somebody wants it.
  /// What they return has to stay until send() returns. None: there is no such picture.
  std::function<std::span<const std::byte>()> left_jpeg{};
  std::function<std::span<const std::byte>()> u_disparity_jpeg{};
  std::optional<Latency> latency{};
  std::int64_t frames{0};              ///< used so far, this one included
  std::span<const Dropped> dropped{};  ///< so far
};

/// Sends what is known after each frame as ROS 2 messages; docs/messages.md has the topics, their types and frames. A
/// topic is added to the sink when there is something to send on it for the first time.
class STEREOGRID_EXPORT FrameMessages {
 public:
  /// `rig`: Pipeline::rig(). The sink has to live longer. Throws InputError: problems of the rig; ConfigError: a name
  /// that ROS does not take, a topic that does not exist.
  FrameMessages(Sink& sink, const Rig& rig, const FrameMessagesOptions& options = {});
  FrameMessages(FrameMessages&&) noexcept;
  FrameMessages& operator=(FrameMessages&&) noexcept;
  ~FrameMessages();

  /// Topics that are made of FrameResult::stages are left out where there are none. Throws what the sink throws;
  /// InputError: no result of a pipeline, or one whose stages are of another rig.
  void send(const FrameResult& result, const FrameFacts& facts);

  /// Where the pipeline has found another mounting: Pipeline::rig() as it is then. Throws InputError: its problems.
  void set_rig(const Rig& rig);

 private:
  struct STEREOGRID_HIDDEN Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace stereogrid::messages
