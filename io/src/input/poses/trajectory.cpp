// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <opencv2/core/matx.hpp>

#include "input/calibration/raw_pair.hpp"
#include "input/calibration/yaml_group.hpp"
#include "input/poses/kitti_text.hpp"
#include "input/poses/recording_poses.hpp"
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

/// Exact to a nanosecond: a double is to a quarter of a microsecond for today's dates. `stamp`: the word's value.
std::int64_t stamp_of(const std::string& word, double stamp, const StampUnit& unit) {
  const std::size_t dot{std::min(word.find('.'), word.size())};
  const std::string fraction_digits{dot < word.size() ? word.substr(dot + 1) : ""};
  const std::size_t fraction{std::to_string(unit.ns).size() - 1};  // digits of a nanosecond in the unit
  std::string digits{word.substr(0, dot) + fraction_digits.substr(0, fraction)};
  if (digits.find_first_not_of("0123456789") == std::string::npos) {
    digits.append(fraction - std::min(fraction, fraction_digits.size()), '0');
    std::int64_t stamp_ns{0};
    const auto [end, error]{std::from_chars(digits.data(), digits.data() + digits.size(), stamp_ns)};
    if (error == std::errc{} && *end == '\0') return stamp_ns;
  }
  return std::llround(stamp * static_cast<double>(unit.ns));
}

/// Columns of a file.
enum class Form {
  none,
  tum,         ///< stamp (s), position, quaternion x y z w
  euroc,       ///< stamp (ns), position, quaternion w x y z, and more
  airsim,      ///< vehicle, stamp (ms), position, quaternion w x y z; x ahead, y to the right, z down
  tartan_air,  ///< position, quaternion x y z w; the same axes; a line per frame
  kitti_360    ///< number of the frame, 4 × 4 of the camera or 3 × 4 of the vehicle (x ahead, y to the right, z down)
};

/// A line as numbers; AirSim's begins with words.
std::vector<double> numbers_of(std::string_view content, Form form) {
  std::vector<double> numbers;
  std::string text{content};
  if (form == Form::airsim) {
    text = text.substr(std::min(text.find_first_of("\t "), text.size()));
    std::size_t end{0};
    for (int column{0}; column < 8; ++column) {
      end = text.find_first_not_of("\t ", end);
      end = end == std::string::npos ? text.size() : std::min(text.find_first_of("\t ", end), text.size());
    }
    text.resize(end);
  }
  if (!parse_numbers(text, numbers)) numbers.clear();
  return numbers;
}

Form form_of(std::string_view text) {
  bool is_w_first{false};
  for (const std::string_view line : lines_of(text)) {
    if (line.find("POS_X") != std::string_view::npos && line.find("Q_W") != std::string_view::npos) return Form::airsim;
    is_w_first = is_w_first || line.find("q_RS_w") != std::string_view::npos ||
                 line.find("qw, qx") != std::string_view::npos || line.find("qw,qx") != std::string_view::npos ||
                 line.find("q_w") != std::string_view::npos;
    const std::string content{content_of(line)};
    if (content.empty()) continue;
    const std::size_t count{numbers_of(content, Form::tum).size()};
    if (is_w_first && count >= 8) return Form::euroc;
    switch (count) {
      case 7:
        return Form::tartan_air;
      case 8:
        return Form::tum;
      case 13:
      case 17:
        return Form::kitti_360;
      default:
        if (count > 0 || !is_w_first) return Form::none;  // else a header without #
    }
  }
  return Form::none;
}

bool has_columns(Form form, std::size_t count) {
  switch (form) {
    case Form::tum:
    case Form::airsim:
      return count == 8;
    case Form::euroc:
      return count >= 8;
    case Form::tartan_air:
      return count == 7;
    case Form::kitti_360:
      return count == 13 || count == 17;
    default:
      return false;
  }
}

const char* columns_of(Form form) {
  switch (form) {
    case Form::tum:
      return "timestamp tx ty tz qx qy qz qw";
    case Form::euroc:
      return "timestamp [ns], p_x, p_y, p_z, q_w, q_x, q_y, q_z";
    case Form::airsim:
      return "VehicleName TimeStamp POS_X POS_Y POS_Z Q_W Q_X Q_Y Q_Z ImageFile";
    case Form::tartan_air:
      return "tx ty tz qx qy qz qw";
    default:
      return "frame and 16 or 12 numbers";
  }
}

cv::Matx44d pose_of(const std::vector<double>& n, Form form, const std::filesystem::path& path, std::size_t number) {
  const std::size_t first{form == Form::tartan_air ? 0U : 1U};
  const auto is_large{[](double value) { return !(std::abs(value) <= largest_position_m); }};
  if (std::any_of(n.begin() + static_cast<std::ptrdiff_t>(first), n.end(), is_large))
    fail(path, number, "has a number that is not finite, or above 100 million m.");
  const Origin origin{printable_path(path), fmt::format("line {}", number)};
  if (form == Form::kitti_360) return rigid_of(std::vector<double>{n.begin() + 1, n.end()}, origin, "pose");
  const cv::Vec3d place{n[first], n[first + 1], n[first + 2]};
  const bool is_w_first{form == Form::euroc || form == Form::airsim};
  const std::size_t q{first + 3};
  return is_w_first ? rigid_of({n[q + 1], n[q + 2], n[q + 3], n[q]}, place, origin, "qw qx qy qz")
                    : rigid_of({n[q], n[q + 1], n[q + 2], n[q + 3]}, place, origin, "qx qy qz qw");
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

/// In the axes of the first body, x ahead, y to the right and z down.
Pose2 pose_of_z_down(const cv::Matx44d& m) {
  return {m(0, 3), -m(1, 3), -std::atan2(m(1, 0), m(0, 0))};
}

/// In the axes of the first camera, projected on its plane of x and z.
Pose2 ground_pose_of(const cv::Matx44d& m) {
  return {m(2, 3), -m(0, 3), std::atan2(-m(0, 2), m(2, 2))};
}

}  // namespace

bool is_trajectory(const std::filesystem::path& path) {
  return form_of(read_text(path, largest_bytes::lines)) != Form::none;
}

Trajectory read_trajectory(const std::filesystem::path& path, const std::optional<Transform>& body_from_camera) {
  const std::string text{read_text(path, largest_bytes::lines)};
  const Form form{form_of(text)};
  std::vector<std::string> words;
  std::vector<double> stamps;
  std::vector<cv::Matx44d> poses;
  Trajectory found;
  std::size_t number{0};
  bool is_of_camera{false};
  for (const std::string_view line : lines_of(text)) {
    ++number;
    const std::string content{content_of(line)};
    if (content.empty() || (poses.empty() && content.find_first_of("0123456789.+-") != 0 && form != Form::airsim) ||
        (form == Form::airsim && poses.empty() && content.find("POS_X") != std::string::npos)) {
      continue;
    }
    const std::vector<double> numbers{numbers_of(content, form)};
    if (!has_columns(form, numbers.size())) fail(path, number, fmt::format("is not '{}'.", columns_of(form)));
    poses.push_back(pose_of(numbers, form, path, number));
    is_of_camera = numbers.size() == 17 && form == Form::kitti_360;
    if (form == Form::tartan_air) continue;
    if (!(std::abs(numbers[0]) <= static_cast<double>(largest_stamp_ns))) {
      fail(path, number, fmt::format("has the stamp {} (allowed: seconds up to 4e9).", numbers[0]));
    }
    if (form == Form::kitti_360 && numbers[0] != std::floor(numbers[0])) {
      fail(path, number, "has a frame that is not a whole number.");
    }
    if (!stamps.empty() && numbers[0] <= stamps.back()) {
      fail(path, number,
           form == Form::kitti_360 ? "has a frame that is not later than the one before."
                                   : "has a stamp that is not later than the one before.");
    }
    std::string_view word{content};
    if (form == Form::airsim) word.remove_prefix(word.find_first_of("\t "));
    word.remove_prefix(std::min(word.find_first_not_of("\t "), word.size()));
    words.emplace_back(word.substr(0, word.find_first_of(" \t")));
    stamps.push_back(numbers[0]);
  }
  if (body_from_camera && form == Form::euroc) {
    cv::Matx44d camera{cv::Matx44d::eye()};
    std::copy_n(body_from_camera->begin(), body_from_camera->size(), camera.val);
    for (cv::Matx44d& pose : poses) pose = pose * camera;
    is_of_camera = true;
  }
  const bool is_z_down{form == Form::airsim || form == Form::tartan_air || (form == Form::kitti_360 && !is_of_camera)};
  found.are_of_body = !is_z_down && !is_of_camera && are_of_body(poses);
  StampUnit unit{stamp_units.back()};
  if (form == Form::euroc) unit = stamp_units.front();
  if (form == Form::airsim) unit = stamp_units[2];
  if (form != Form::kitti_360) unit = stamp_unit(stamps, unit, printable_path(path));
  found.note = unit.note;
  for (std::size_t i{0}; i < poses.size(); ++i) {
    const cv::Matx44d first_from_this{inverse(poses.front()) * poses[i]};
    found.poses.push_back({0, is_z_down           ? pose_of_z_down(first_from_this)
                              : found.are_of_body ? body_pose_of(first_from_this)
                                                  : ground_pose_of(first_from_this)});
    if (form == Form::kitti_360) found.frames.push_back(static_cast<std::int64_t>(stamps[i]));
    if (form != Form::tartan_air && form != Form::kitti_360) {
      found.poses.back().stamp_ns = stamp_of(words[i], stamps[i], unit);
      if (i > 0 && found.poses[i].stamp_ns <= found.poses[i - 1].stamp_ns) {
        throw InputError{printable_path(path), fmt::format("pose {} has the stamp of the one before, to 1 ns.", i + 1),
                         mend};
      }
    }
  }
  found.have_stamps = form != Form::tartan_air && form != Form::kitti_360;
  return found;
}

}  // namespace stereogrid::io
