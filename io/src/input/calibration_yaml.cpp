// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "input/calibration_yaml.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <opencv2/calib3d.hpp>
#include <string_view>

#include "files/yaml_complaint.hpp"
#include "input/kitti_text.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/rectifier.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

const char* const see_documentation{"docs/input.md shows what a calibration.yaml holds."};

/// A mapping of the file, that knows where it stands, for complaints.
class Group {
 public:
  Group(std::string file, std::string name, YAML::Node node, std::initializer_list<std::string_view> known)
      : file_{std::move(file)}, name_{std::move(name)}, node_{std::move(node)} {
    if (!node_.IsMap()) fail(name_.empty() ? "is no YAML mapping." : "'" + name_ + "' is no group of keys.");
    for (const auto& item : node_) {
      if (!item.first.IsScalar()) fail("has a key in line " + line_of(item.first) + " that is no word.");
      const std::string& key{item.first.Scalar()};
      if (std::find(known.begin(), known.end(), key) == known.end()) {
        fail("has an unknown key '" + full(printable(key)) + "' in line " + line_of(item.first) + ".");
      }
    }
  }

  [[nodiscard]] bool has(const char* key) const { return node_[key].IsDefined(); }

  [[nodiscard]] Group group(const char* key, std::initializer_list<std::string_view> known) const {
    return {file_, full(key), required(key), known};
  }

  [[nodiscard]] std::vector<double> numbers(const char* key) const {
    const YAML::Node value{required(key)};
    std::vector<double> numbers;
    if (value.IsScalar()) return {number_of(value, key)};
    if (!value.IsSequence()) fail("'" + full(key) + "' is no list of numbers.");
    const auto take{[&](const YAML::Node& node) {
      if (numbers.size() == most_numbers)
        fail("'" + full(key) + "' has more than " + std::to_string(most_numbers) + " numbers.");
      numbers.push_back(number_of(node, key));
    }};
    for (const auto& item : value) {
      if (item.IsSequence()) {  // a matrix written as a list of rows
        for (const auto& element : item) take(element);
      } else {
        take(item);
      }
    }
    return numbers;
  }

  [[nodiscard]] std::filesystem::path file_name(const char* key) const {
    const YAML::Node value{required(key)};
    if (!value.IsScalar() || value.Scalar().empty() || value.Scalar().find('\0') != std::string::npos) {
      fail("'" + full(key) + "' in line " + line_of(value) + " is no file's name.");
    }
    return value.Scalar();
  }

  [[nodiscard]] double number(const char* key) const { return number_of(required(key), key); }

  [[nodiscard]] double number(const char* key, double otherwise) const { return has(key) ? number(key) : otherwise; }

  [[nodiscard]] int pixels(const char* key) const {
    const double value{number(key)};
    if (value != std::floor(value) || value < 1 || value > 100000) {
      fail("'" + full(key) + "' is no size in pixels.");
    }
    return static_cast<int>(value);
  }

  [[noreturn]] void fail(const std::string& what) const { throw InputError{file_, what, see_documentation}; }

 private:
  [[nodiscard]] std::string full(const std::string& key) const { return name_.empty() ? key : name_ + "." + key; }

  [[nodiscard]] YAML::Node required(const char* key) const {
    const YAML::Node found{node_[key]};
    if (!found.IsDefined()) fail("has no '" + full(key) + "'.");
    return found;
  }

  static std::string line_of(const YAML::Node& node) { return std::to_string(node.Mark().line + 1); }

  [[nodiscard]] double number_of(const YAML::Node& node, const char* key) const {
    std::vector<double> numbers;
    if (!node.IsScalar() || !parse_numbers(node.Scalar(), numbers) || numbers.size() != 1 ||
        !(std::abs(numbers[0]) <= largest_number)) {
      fail("'" + full(key) + "' in line " + line_of(node) + " is no number.");
    }
    return numbers[0];
  }

  static constexpr std::size_t most_numbers{16};
  static constexpr double largest_number{1e9};

  std::string file_;
  std::string name_;
  YAML::Node node_;
};

CameraModel read_camera(const Group& root, const char* name) {
  const Group group{root.group(name, {"focal_u_px", "focal_v_px", "centre_u_px", "centre_v_px", "distortion"})};
  CameraModel camera{group.number("focal_u_px"),
                     group.number("focal_v_px"),
                     group.number("centre_u_px"),
                     group.number("centre_v_px"),
                     {}};
  if (camera.focal_u_px <= 0 || camera.focal_v_px <= 0) group.fail("has a focal length that is not positive.");
  if (camera.focal_u_px < 1 || camera.focal_v_px < 1) group.fail("has a focal length below one pixel.");
  if (std::abs(camera.focal_u_px - camera.focal_v_px) > 0.2 * camera.focal_u_px) {
    group.fail("has focal lengths along u and v that differ by more than a fifth.");
  }
  if (group.has("distortion")) camera.distortion = group.numbers("distortion");
  const std::size_t count{camera.distortion.size()};
  if (count != 0 && count != 4 && count != 5 && count != 8) {
    group.fail("has " + std::to_string(count) +
               " distortion numbers; there are 0, 4, 5 or 8 (k1 k2 p1 p2 k3 k4 k5 k6).");
  }
  return camera;
}

std::array<double, 9> read_rotation(const Group& group) {
  const std::vector<double> numbers{group.numbers("rotation")};
  cv::Matx33d rotation;
  if (numbers.size() == 3) {
    cv::Rodrigues(cv::Vec3d{numbers[0], numbers[1], numbers[2]}, rotation);
  } else if (numbers.size() == 9) {
    rotation = cv::Matx33d{numbers.data()};
  } else {
    group.fail("has a rotation of " + std::to_string(numbers.size()) +
               " numbers; there are 3 (Rodrigues) or 9 (matrix).");
  }
  const double off{cv::norm(rotation * rotation.t() - cv::Matx33d::eye(), cv::NORM_INF)};
  if (off > 0.01 || cv::determinant(rotation) < 0) group.fail("has a rotation that is no rotation matrix.");
  std::array<double, 9> row_major{};
  std::copy_n(rotation.val, 9, row_major.begin());
  return row_major;
}

RawPair read_raw(const Group& root) {
  RawPair raw;
  raw.left = read_camera(root, "left");
  raw.right = read_camera(root, "right");
  const Group group{root.group("right_from_left", {"rotation", "translation_m"})};
  raw.right_from_left_rotation = read_rotation(group);
  const std::vector<double> translation{group.numbers("translation_m")};
  if (translation.size() != 3) group.fail("has a translation that is not 3 numbers.");
  std::copy_n(translation.begin(), 3, raw.right_from_left_translation_m.begin());
  return raw;
}

Group parse(const std::filesystem::path& path) {
  const std::string text{read_text(path, largest_bytes::calibration)};
  return {printable_path(path),
          "",
          YAML::Load(text),
          {"image", "mount", "focal_px", "centre_u_px", "centre_v_px", "baseline_m", "left", "right", "right_from_left",
           "mask"}};
}

Rig rectified_rig(const Group& root, const RawPair& raw, int width_px, int height_px) {
  if (width_px == 0 || height_px == 0) root.fail("has no 'image' size, which a raw pair needs.");
  try {
    return Rectifier{raw, width_px, height_px}.rig();
  } catch (const InputError& error) {
    root.fail(error.what());
  }
}

Calibration read(const std::filesystem::path& path, int width_px, int height_px) {
  const Group root{parse(path)};
  Calibration calibration;
  calibration.kind = "calibration.yaml";
  int width{0};
  int height{0};
  if (root.has("image")) {
    const Group image{root.group("image", {"width_px", "height_px"})};
    width = image.pixels("width_px");
    height = image.pixels("height_px");
  }
  if (root.has("left") || root.has("right") || root.has("right_from_left")) {
    if (root.has("focal_px") || root.has("baseline_m")) root.fail("mixes the keys of a raw and of a rectified pair.");
    calibration.raw = read_raw(root);
    calibration.rig =
        rectified_rig(root, *calibration.raw, width != 0 ? width : width_px, height != 0 ? height : height_px);
  } else {
    calibration.rig.focal_px = root.number("focal_px");
    calibration.rig.centre_u_px = root.number("centre_u_px");
    calibration.rig.centre_v_px = root.number("centre_v_px");
    calibration.rig.baseline_m = root.number("baseline_m");
  }
  calibration.rig.width_px = width;
  calibration.rig.height_px = height;
  if (root.has("mask")) calibration.mask = path.parent_path() / root.file_name("mask");
  calibration.has_mounting = root.has("mount");
  if (!calibration.has_mounting) return calibration;
  const Group mount{root.group("mount", {"camera_height_m", "camera_pitch_rad", "camera_roll_rad"})};
  calibration.rig.camera_height_m = mount.number("camera_height_m");
  calibration.rig.camera_pitch_rad = mount.number("camera_pitch_rad", 0);
  calibration.rig.camera_roll_rad = mount.number("camera_roll_rad", 0);
  return calibration;
}

}  // namespace

Calibration read_calibration_yaml(const std::filesystem::path& path, int width_px, int height_px) {
  try {
    return read(path, width_px, height_px);
  } catch (const YAML::Exception& error) {
    throw InputError{printable_path(path), fmt::format("line {} {}", error.mark.line + 1, complaint_of(error)),
                     see_documentation};
  } catch (const cv::Exception&) {  // numbers that contradict each other in ways that are not foreseen here
    throw InputError{printable_path(path), "holds a raw pair that cannot be rectified.", see_documentation};
  }
}

}  // namespace stereogrid::io
