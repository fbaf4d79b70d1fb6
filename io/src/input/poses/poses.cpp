// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/poses.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <numbers>
#include <set>

#include "input/poses/kitti_text.hpp"
#include "input/poses/recording_poses.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

namespace fs = std::filesystem;

const char* const leave_out{"Correct it, name another file with --poses, or run with --poses none."};

[[noreturn]] void fail(const fs::path& path, std::size_t line, const std::string& what) {
  throw InputError{printable_path(path), "line " + std::to_string(line) + " " + what, leave_out};
}

void check_finite(const fs::path& path, std::size_t line, const std::vector<double>& numbers) {
  if (!std::ranges::all_of(numbers, [](double number) { return std::isfinite(number); })) {
    fail(path, line, "has a number that is not finite (NaN or infinity).");
  }
  if (!std::ranges::all_of(numbers, [](double number) { return std::abs(number) <= largest_position_m; })) {
    fail(path, line, "has a number above 100 million; poses are in metres and radians.");
  }
}

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> fields;
  for (;;) {
    const std::size_t comma{line.find(',')};
    std::string_view field{line.substr(0, comma)};
    while (field.starts_with(' ')) field.remove_prefix(1);
    while (field.ends_with(' ')) field.remove_suffix(1);
    fields.push_back(field);
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

NamedPose parse_row(const fs::path& path, std::size_t line, std::string_view text, bool named) {
  auto fields{split(text)};
  const std::size_t expected{named ? 5U : 4U};
  if (fields.size() != expected) fail(path, line, fmt::format("has {} fields, not {}.", fields.size(), expected));
  if (!named) fields.insert(fields.begin(), "");
  NamedPose pose;
  pose.name = frame_name(fields[0]);
  if (named && pose.name.empty()) fail(path, line, "has no name.");
  const auto [end, error]{std::from_chars(fields[1].data(), fields[1].data() + fields[1].size(), pose.stamp_ns)};
  if (error != std::errc{} || end != fields[1].data() + fields[1].size()) {
    fail(path, line, "has a stamp that is not a whole number of nanoseconds.");
  }
  if (pose.stamp_ns > largest_stamp_ns || pose.stamp_ns < -largest_stamp_ns) {
    fail(path, line, "has a stamp beyond the year 2096.");
  }
  std::vector<double> numbers;
  if (!parse_numbers(fmt::format("{} {} {}", fields[2], fields[3], fields[4]), numbers) || numbers.size() != 3) {
    fail(path, line, "has a pose that is not three numbers.");
  }
  check_finite(path, line, numbers);
  pose.world_from_vehicle = {numbers[0], numbers[1], numbers[2]};
  return pose;
}

bool is_blank(std::string_view line) {
  return line.find_first_not_of(" \t") == std::string_view::npos;
}

}  // namespace

std::optional<std::array<double, 4>> unit_quaternion(const std::array<double, 4>& quaternion) {
  constexpr double tolerance{0.01};
  const auto& [x, y, z, w]{quaternion};
  const double length{std::sqrt(x * x + y * y + z * z + w * w)};
  if (!(std::abs(length - 1) <= tolerance)) return std::nullopt;  // NaN, too
  return std::array{x / length, y / length, z / length, w / length};
}

std::vector<Pose2> read_kitti_poses(const fs::path& path, std::size_t expected) {
  const std::string text{read_text(path, largest_bytes::lines)};
  std::vector<Pose2> poses;
  std::vector<double> numbers;
  std::size_t line_number{0};
  for (const std::string_view line : lines_of(text)) {
    ++line_number;
    if (is_blank(line)) continue;
    if (!parse_numbers(line, numbers)) fail(path, line_number, "holds something that is not a number.");
    const bool is_square{numbers.size() == 16 && numbers[12] == 0 && numbers[13] == 0 && numbers[14] == 0 &&
                         numbers[15] == 1};
    if (is_square) numbers.resize(12);
    if (numbers.size() != 12) fail(path, line_number, fmt::format("has {} numbers, not 12.", numbers.size()));
    check_finite(path, line_number, numbers);
    const std::vector<double>& m{numbers};
    if (!is_rotation({m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]}))
      fail(path, line_number, "has a matrix that is not a rotation.");
    poses.push_back(ground_pose(std::span<const double, 12>{numbers}));
  }
  if (poses.size() != expected) {
    throw InputError{printable_path(path),
                     fmt::format("has {} poses, but there are {} frames.", poses.size(), expected),
                     "There has to be a line per frame (frames.txt says which frames the lines belong to); or run "
                     "with --poses none."};
  }
  return poses;
}

std::vector<NamedPose> read_poses_csv(const fs::path& path) {
  const std::string text{read_text(path, largest_bytes::lines)};
  const auto lines{lines_of(text)};
  const bool named{!lines.empty() && split(lines[0]) == split("name,stamp_ns,x_m,y_m,yaw_rad")};
  if (!named && (lines.empty() || split(lines[0]) != split("stamp_ns,x_m,y_m,yaw_rad"))) {
    fail(path, 1, "is neither 'name,stamp_ns,x_m,y_m,yaw_rad' nor 'stamp_ns,x_m,y_m,yaw_rad'.");
  }
  std::vector<NamedPose> poses;
  std::set<std::string> names;
  for (std::size_t i{1}; i < lines.size(); ++i) {
    if (is_blank(lines[i])) continue;
    NamedPose pose{parse_row(path, i + 1, lines[i], named)};
    if (named && !names.insert(pose.name).second) fail(path, i + 1, "names frame " + pose.name + " a second time.");
    if (!poses.empty() && pose.stamp_ns <= poses.back().stamp_ns) {
      fail(path, i + 1, "has a stamp that is not later than the one before.");
    }
    poses.push_back(std::move(pose));
  }
  return poses;
}

void write_poses_csv(const fs::path& path, std::span<const NamedPose> poses) {
  std::string text{"name,stamp_ns,x_m,y_m,yaw_rad\n"};
  for (const NamedPose& pose : poses) {
    text += fmt::format("{},{},{:.6f},{:.6f},{:.8f}\n", pose.name, pose.stamp_ns, pose.world_from_vehicle.x_m,
                        pose.world_from_vehicle.y_m, pose.world_from_vehicle.yaw_rad);
  }
  write_file(path, text);
}

std::optional<PoseChoice> find_poses(const fs::path& folder) {
  std::vector<fs::path> found;
  for (const char* const name : {"poses.csv", "poses_gt.txt", "poses.txt", "poses_vo.txt"}) {
    if (is_file(folder / name)) found.push_back(folder / name);
  }
  std::vector<fs::path> others;
  for (const fs::path& entry : entries_of(folder)) {
    const std::string name{entry.filename().string()};
    const bool listed{std::ranges::find(found, entry) != found.end()};
    if (name.starts_with("poses") && name.ends_with(".txt") && !listed) others.push_back(entry);
  }
  found.insert(found.end(), others.begin(), others.end());
  for (const char* const name :
       {"groundtruth.txt", "trajectory.txt", "CameraTrajectory.txt", "pose_left.txt", "airsim_rec.txt"}) {
    if (is_file(folder / name) && is_trajectory(folder / name)) found.push_back(folder / name);
  }
  if (found.empty()) return std::nullopt;
  return PoseChoice{found.front(), {found.begin() + 1, found.end()}};
}

std::int64_t usual_interval_ns(std::span<const StampedPose> poses) {
  std::vector<std::int64_t> intervals;
  for (std::size_t i{1}; i < poses.size(); ++i) intervals.push_back(poses[i].stamp_ns - poses[i - 1].stamp_ns);
  const auto middle{intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2)};
  std::nth_element(intervals.begin(), middle, intervals.end());
  return *middle;
}

namespace {

double seconds(std::int64_t ns) {
  return static_cast<double>(ns) * 1e-9;
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
