// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "stereogrid/error.hpp"
#include "stereogrid/io/poses.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

double seconds(std::int64_t ns) {
  return static_cast<double>(ns) * 1e-9;
}

std::int64_t usual_interval_ns(std::span<const StampedPose> poses) {
  std::vector<std::int64_t> intervals;
  for (std::size_t i{1}; i < poses.size(); ++i) intervals.push_back(poses[i].stamp_ns - poses[i - 1].stamp_ns);
  const auto middle{intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2)};
  std::nth_element(intervals.begin(), middle, intervals.end());
  return *middle;
}

/// On the line through both; `share` of the way from a to b, also before a and behind b.
Pose2 between(const Pose2& a, const Pose2& b, double share) {
  constexpr double turn{2 * std::numbers::pi};
  return {a.x_m + share * (b.x_m - a.x_m), a.y_m + share * (b.y_m - a.y_m),
          std::remainder(a.yaw_rad + share * std::remainder(b.yaw_rad - a.yaw_rad, turn), turn)};
}

[[noreturn]] void fail(const std::filesystem::path& source, std::span<const StampedPose> poses, std::int64_t stamp_ns) {
  const std::int64_t first_ns{poses.front().stamp_ns};
  const std::int64_t last_ns{poses.back().stamp_ns};
  const bool before{stamp_ns < first_ns};
  throw InputError{
      printable_path(source),
      fmt::format("there is no pose for the image of {:.3f} s: that is {:.3f} s {}, {:.3f} s.", seconds(stamp_ns),
                  seconds(before ? first_ns - stamp_ns : stamp_ns - last_ns),
                  before ? "before the first pose" : "after the last pose", seconds(before ? first_ns : last_ns)),
      "The poses have to reach over all images, by the same clock; or run with --poses odometry."};
}

}  // namespace

std::vector<Pose2> interpolate_poses(const std::filesystem::path& source, std::span<const StampedPose> poses,
                                     std::span<const std::int64_t> stamps_ns) {
  if (poses.size() < 2) {
    throw InputError{printable_path(source), fmt::format("has {} poses: nothing to interpolate between.", poses.size()),
                     "Give poses from before the first image to after the last; or run with --poses odometry."};
  }
  const std::int64_t reach_ns{usual_interval_ns(poses)};
  std::vector<Pose2> found;
  for (const std::int64_t stamp_ns : stamps_ns) {
    if (stamp_ns < poses.front().stamp_ns - reach_ns || stamp_ns > poses.back().stamp_ns + reach_ns) {
      fail(source, poses, stamp_ns);
    }
    // the first pose after the stamp, but never the very first nor behind the last one
    const auto after{std::upper_bound(poses.begin() + 1, poses.end() - 1, stamp_ns,
                                      [](std::int64_t ns, const StampedPose& pose) { return ns < pose.stamp_ns; })};
    const StampedPose& a{*std::prev(after)};
    const StampedPose& b{*after};
    found.push_back(between(a.world_from_vehicle, b.world_from_vehicle,
                            seconds(stamp_ns - a.stamp_ns) / seconds(b.stamp_ns - a.stamp_ns)));
  }
  return found;
}

}  // namespace stereogrid::io
