// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "stereogrid/frame.hpp"
#include "stereogrid/io/poses.hpp"

namespace stereogrid::app {

/// The last seconds of where the vehicle was, as it comes, for instants of images. For any threads.
class PoseBuffer {
 public:
  /// `name`: where the poses come from, for error messages.
  explicit PoseBuffer(std::string name) : name_{std::move(name)} {}

  /// Adds poses. Stamps older than the buffer's belong to another clock: the buffer is cleared first.
  void add(const std::vector<io::StampedPose>& poses);
  void clear();

  /// Pose at an instant, interpolated; up to one usual interval after the last pose the motion continues. Waits up to
  /// `patience` for a later pose. Throws InputError: there is none.
  [[nodiscard]] Pose2 at(std::int64_t stamp_ns, std::chrono::milliseconds patience);
  /// Returns when there is a pose, or after `patience`.
  void wait_for_first(std::chrono::milliseconds patience);

 private:
  [[nodiscard]] Pose2 between(std::int64_t stamp_ns) const;

  std::string name_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<io::StampedPose> poses_;  // stamps grow
};

}  // namespace stereogrid::app
