// SPDX-License-Identifier: Apache-2.0
#include "ros2/ros2_source.hpp"

#include <algorithm>
#include <array>

#include "stereogrid/error.hpp"

namespace stereogrid::app {
namespace {

constexpr std::size_t kept{2000};  // 2 s at 1 kHz
constexpr std::int64_t longest_gap_ns{1'000'000'000};
constexpr const char* look{"Check that it is published, with the clock of the images."};

}  // namespace

void PoseBuffer::add(const std::vector<io::StampedPose>& poses) {
  const std::scoped_lock lock{mutex_};
  for (const io::StampedPose& pose : poses) {
    if (!poses_.empty() && pose.stamp_ns == poses_.back().stamp_ns) continue;
    if (!poses_.empty() && pose.stamp_ns < poses_.back().stamp_ns) poses_.clear();
    if (poses_.size() >= 2 * kept) poses_.erase(poses_.begin(), poses_.end() - kept);
    poses_.push_back(pose);
  }
  changed_.notify_all();
}

void PoseBuffer::clear() {
  const std::scoped_lock lock{mutex_};
  poses_.clear();
}

Pose2 PoseBuffer::at(std::int64_t stamp_ns, std::chrono::milliseconds patience) {
  std::unique_lock lock{mutex_};
  changed_.wait_for(lock, patience, [&] { return poses_.size() > 1 && poses_.back().stamp_ns >= stamp_ns; });
  return between(stamp_ns);
}

void PoseBuffer::wait_for_first(std::chrono::milliseconds patience) {
  std::unique_lock lock{mutex_};
  changed_.wait_for(lock, patience, [&] { return !poses_.empty(); });
}

Pose2 PoseBuffer::between(std::int64_t stamp_ns) const {
  if (poses_.size() < 2) throw InputError{name_, "there is no pose yet.", look};
  const auto after{std::ranges::lower_bound(poses_, stamp_ns, {}, &io::StampedPose::stamp_ns)};
  const auto last_begin{poses_.end() - 2};
  const auto begin{after == poses_.begin() ? poses_.begin() : std::min(after - 1, last_begin)};
  const std::array<io::StampedPose, 2> around{*begin, *(begin + 1)};
  const bool is_reached{stamp_ns >= around[0].stamp_ns};
  if (!is_reached || around[1].stamp_ns - around[0].stamp_ns > longest_gap_ns) {
    throw InputError{name_, "there is no pose of the image's instant.", look};
  }
  try {
    return io::interpolate_poses(name_, around, std::array{stamp_ns}).front();
  } catch (const InputError&) {
    throw InputError{name_, "the poses are behind the images.", look};
  }
}

}  // namespace stereogrid::app
