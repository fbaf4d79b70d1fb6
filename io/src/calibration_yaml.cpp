// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "calibration_yaml.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <opencv2/calib3d.hpp>
#include <string_view>

#include "kitti_text.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/rectifier.hpp"

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
      const auto key{item.first.as<std::string>()};
      if (std::find(known.begin(), known.end(), key) == known.end()) {
        fail("has an unknown key '" + full(key) + "' in line " + std::to_string(item.first.Mark().line + 1) + ".");
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
    for (const auto& item : value) {
      if (item.IsSequence()) {  // a matrix written as a list of rows
        for (const auto& element : item) numbers.push_back(number_of(element, key));
      } else {
        numbers.push_back(number_of(item, key));
      }
    }
    return numbers;
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
    if (!has(key)) fail("has no '" + full(key) + "'.");
    return node_[key];
  }

  [[nodiscard]] double number_of(const YAML::Node& node, const char* key) const {
    std::vector<double> numbers;
    if (!node.IsScalar() || !parse_numbers(node.Scalar(), numbers) || numbers.size() != 1 ||
        !std::isfinite(numbers[0])) {
      fail("'" + full(key) + "' in line " + std::to_string(node.Mark().line + 1) + " is no number.");
    }
    return numbers[0];
  }

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
  const std::string text{read_file(path)};
  try {
    return {
        path.string(),
        "",
        YAML::Load(text),
        {"image", "mount", "focal_px", "centre_u_px", "centre_v_px", "baseline_m", "left", "right", "right_from_left"}};
  } catch (const YAML::Exception& error) {
    throw InputError{path.string(), std::string{"is no YAML ("} + error.what() + ").", see_documentation};
  }
}

Rig rectified_rig(const Group& root, const RawPair& raw, int width_px, int height_px) {
  if (width_px == 0 || height_px == 0) root.fail("has no 'image' size, which a raw pair needs.");
  try {
    return Rectifier{raw, width_px, height_px}.rig();
  } catch (const InputError& error) {
    root.fail(error.what());
  }
}

}  // namespace

Calibration read_calibration_yaml(const std::filesystem::path& path, int width_px, int height_px) {
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
  const Group mount{root.group("mount", {"camera_height_m", "camera_pitch_rad", "camera_roll_rad"})};
  calibration.rig.camera_height_m = mount.number("camera_height_m");
  calibration.rig.camera_pitch_rad = mount.number("camera_pitch_rad", 0);
  calibration.rig.camera_roll_rad = mount.number("camera_roll_rad", 0);
  return calibration;
}

}  // namespace stereogrid::io
