// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <opencv2/core/matx.hpp>

#include "input/calibration/raw_pair.hpp"
#include "input/calibration/yaml_group.hpp"
#include "input/poses/kitti_text.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/poses.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

const char* const mend{"Correct it, name another file with --poses, or run with --poses none."};

/// Lines with numbers, between blanks or commas; comments and blank lines are empty.
std::string content_of(std::string_view line) {
  const std::size_t start{line.find_first_not_of(" \t")};
  if (start == std::string_view::npos || line[start] == '#') return {};
  std::string content{line.substr(start)};
  std::ranges::replace(content, ',', ' ');
  return content;
}

[[noreturn]] void fail(const std::filesystem::path& path, std::size_t line, const std::string& what) {
  throw InputError{printable_path(path), fmt::format("line {} {}", line, what), mend};
}

/// Exact to a nanosecond: a double is to a quarter of a microsecond for today's dates.
std::int64_t stamp_of(std::string_view line, const std::filesystem::path& path, std::size_t number) {
  constexpr double largest_s{4e9};
  const std::string_view word{line.substr(0, line.find_first_of(" \t"))};
  double seconds{0};
  std::from_chars(word.data(), word.data() + word.size(), seconds);
  if (!(std::abs(seconds) < largest_s)) {
    fail(path, number, fmt::format("has the stamp {} (allowed: seconds up to 4e9). Stamps are in seconds.", word));
  }
  const std::size_t dot{word.find('.')};
  if (dot == std::string_view::npos || word.find_first_not_of("0123456789.") != std::string_view::npos) {
    return std::llround(seconds * 1e9);
  }
  std::string digits{word.substr(0, dot)};
  std::string fraction{word.substr(dot + 1)};
  fraction.resize(9, '0');
  digits += fraction;
  std::int64_t stamp_ns{0};
  std::from_chars(digits.data(), digits.data() + digits.size(), stamp_ns);
  return stamp_ns;
}

cv::Matx44d pose_of(const std::vector<double>& n, const std::filesystem::path& path, std::size_t number) {
  const auto is_large{[](double value) { return !(std::abs(value) <= largest_position_m); }};
  if (std::any_of(n.begin() + 1, n.end(), is_large))
    fail(path, number, "has a number that is not finite, or above 100 million m.");
  const Origin origin{printable_path(path), fmt::format("line {}", number)};
  return rigid_of({n[4], n[5], n[6], n[7]}, {n[1], n[2], n[3]}, origin, "qx qy qz qw");
}

/// True if the poses move along their own x, the forward axis of a body, and not along z, that of a camera.
bool are_of_body(const std::vector<cv::Matx44d>& poses) {
  constexpr double shortest_m{0.1};
  double along_x_m{0};
  double along_z_m{0};
  for (std::size_t i{1}; i < poses.size(); ++i) {
    const cv::Matx44d step{inverse(poses[i - 1]) * poses[i]};
    along_x_m += step(0, 3);
    along_z_m += step(2, 3);
  }
  return along_x_m > shortest_m && along_x_m > 3 * std::abs(along_z_m);
}

/// In the axes of the first body, x ahead and z up.
Pose2 body_pose_of(const cv::Matx44d& m) {
  return {m(0, 3), m(1, 3), std::atan2(m(1, 0), m(0, 0))};
}

/// In the axes of the first camera, projected on its plane of x and z.
Pose2 ground_pose_of(const cv::Matx44d& m) {
  return {m(2, 3), -m(0, 3), std::atan2(-m(0, 2), m(2, 2))};
}

}  // namespace

bool is_tum_trajectory(const std::filesystem::path& path) {
  const std::string text{read_text(path, largest_bytes::lines)};
  std::vector<double> numbers;
  for (const std::string_view line : lines_of(text)) {
    const std::string content{content_of(line)};
    if (!content.empty()) return parse_numbers(content, numbers) && numbers.size() == 8;
  }
  return false;
}

TumPoses read_tum_poses(const std::filesystem::path& path) {
  const std::string text{read_text(path, largest_bytes::lines)};
  std::vector<std::int64_t> stamps_ns;
  std::vector<cv::Matx44d> poses;
  std::vector<double> numbers;
  std::size_t number{0};
  for (const std::string_view line : lines_of(text)) {
    ++number;
    const std::string content{content_of(line)};
    if (content.empty()) continue;
    if (!parse_numbers(content, numbers) || numbers.size() != 8) {
      fail(path, number, "is not 'timestamp tx ty tz qx qy qz qw'.");
    }
    poses.push_back(pose_of(numbers, path, number));
    const std::int64_t stamp_ns{stamp_of(content, path, number)};
    if (!stamps_ns.empty() && stamp_ns <= stamps_ns.back()) {
      fail(path, number, "has a stamp that is not later than the one before.");
    }
    stamps_ns.push_back(stamp_ns);
  }
  TumPoses found{{}, are_of_body(poses)};
  for (std::size_t i{0}; i < poses.size(); ++i) {
    const cv::Matx44d first_from_this{inverse(poses.front()) * poses[i]};
    found.poses.push_back(
        {stamps_ns[i], found.are_of_body ? body_pose_of(first_from_this) : ground_pose_of(first_from_this)});
  }
  return found;
}

}  // namespace stereogrid::io
