// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "input/calibration/calibration_forms.hpp"
#include "input/calibration/raw_pair.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

LensModel read_lens(const YamlGroup& group) {
  const std::string lens{group.word("lens")};
  if (lens == "fisheye") return LensModel::fisheye;
  if (lens != "perspective") group.fail("has a 'lens' that is neither perspective nor fisheye.");
  return LensModel::perspective;
}

CameraModel read_camera(const YamlGroup& root, const char* name) {
  const YamlGroup group{root.group(name, {"focal_u_px", "focal_v_px", "cx_px", "cy_px", "distortion", "lens"})};
  CameraModel camera{
      group.number("focal_u_px"), group.number("focal_v_px"), group.number("cx_px"), group.number("cy_px"), {}};
  if (group.has("distortion")) camera.distortion = group.numbers("distortion");
  if (group.has("lens")) camera.lens = read_lens(group);
  check_camera(camera, group);
  return camera;
}

RawPair read_raw(const YamlGroup& root) {
  RawPair raw;
  raw.left = read_camera(root, "left");
  raw.right = read_camera(root, "right");
  const YamlGroup group{root.group("right_from_left", {"rotation", "translation_m"})};
  const cv::Matx33d rotation{rotation_of(group.numbers("rotation"), group, "rotation")};
  const std::vector<double> t{group.numbers("translation_m")};
  if (t.size() != 3) group.fail("has a translation that is not 3 numbers.");
  set_transform(raw, rotation, {t[0], t[1], t[2]});
  return raw;
}

/// Values of label images by their meaning.
std::map<int, PixelLabel> read_labels(const YamlGroup& root) {
  constexpr double largest{65535};
  const YamlGroup group{root.group("labels", {"ignore", "passable", "obstacle", "mover"})};
  std::map<int, PixelLabel> labels;
  for (const PixelLabel label : {PixelLabel::ignore, PixelLabel::passable, PixelLabel::obstacle, PixelLabel::mover}) {
    const std::string key{names_of(label)[static_cast<std::size_t>(label)]};
    if (!group.has(key.c_str())) continue;
    for (const double value : group.vector(key.c_str())) {
      if (!(value >= 0 && value <= largest) || value != std::floor(value)) {
        group.fail("has a value in '" + key + "' that is not an integer in 0 … 65535.");
      }
      if (!labels.emplace(static_cast<int>(value), label).second) {
        group.fail("has a value in '" + key + "' that is listed twice.", "Each value has one meaning.");
      }
    }
  }
  return labels;
}

void read_size(const YamlGroup& root, Rig& rig) {
  if (!root.has("image")) return;
  const YamlGroup image{root.group("image", {"width_px", "height_px"})};
  rig.width_px = image.pixels("width_px");
  rig.height_px = image.pixels("height_px");
}

/// Principal point of the right camera where it differs from the left one's.
void take_right_centre(Calibration& calibration, const YamlGroup& root) {
  if (!root.has("cx_right_px")) return;
  if (calibration.raw) {
    root.fail("has 'cx_right_px', but the calibration is of raw images, which are rectified on loading.",
              "Leave it out, or name the calibration of the rectified images.");
  }
  const Rig rig{calibration.rig};
  take_row_aligned(calibration, rig, root.number("cx_right_px"));
}

/// A calibration that names another tool's file, and says what such a file cannot say.
Calibration read_named(const YamlGroup& root, const std::filesystem::path& path, CalibrationRequest request) {
  root.need_only({"from", "image", "images", "baseline_m", "cx_right_px", "lens", "rotate", "mount", "mask", "labels"});
  request.is_named = true;
  Rig stated;
  read_size(root, stated);
  if (stated.width_px != 0) {
    request.width_px = stated.width_px;
    request.height_px = stated.height_px;
    request.has_stated_size = true;
  }
  if (root.has("images")) {
    const std::string images{root.word("images")};
    if (images != "raw" && images != "rectified")
      root.fail("has a word in 'images' that is neither raw nor rectified.");
    request.images_are_raw = images == "raw";
  }
  if (root.has("lens")) request.lens = read_lens(root);
  if (root.has("baseline_m")) request.baseline_m = root.number("baseline_m");
  if (request.baseline_m && !(*request.baseline_m > 0)) root.fail("'baseline_m' is not positive.");
  std::vector<std::filesystem::path> files{root.file_names("from")};
  if (files.empty() || files.size() > 2) root.fail("'from' is neither one file nor two.");
  for (std::filesystem::path& file : files) file = path.parent_path() / file;
  Calibration calibration{read_form(files, request)};
  fit_size(calibration, Origin{printable_path(files.front())}, request);
  if (request.images_are_raw && calibration.kind != "ROS camera_info") {
    root.fail("has 'images', but the file that it names leaves no choice: " + calibration.kind + ".", "Leave it out.");
  }
  if (request.lens && !calibration.kind.starts_with("OpenCV")) {
    root.fail("has 'lens', but the file that it names leaves no choice: " + calibration.kind + ".", "Leave it out.");
  }
  if (request.baseline_m && calibration.kind.starts_with("KITTI")) {
    root.fail("has 'baseline_m', but KITTI's files are in metres.", "Leave it out.");
  }
  take_right_centre(calibration, root);
  return calibration;
}

Calibration read_whole(const YamlGroup& root, const CalibrationRequest& request) {
  root.need_only({"image", "mount", "focal_px", "cx_px", "cy_px", "cx_right_px", "baseline_m", "left", "right",
                  "right_from_left", "rotate", "mask", "labels"});
  Calibration calibration;
  calibration.kind = "calibration.yaml";
  read_size(root, calibration.rig);
  if (root.has("left") || root.has("right") || root.has("right_from_left")) {
    if (root.has("focal_px") || root.has("baseline_m")) root.fail("mixes the keys of a raw and of a rectified pair.");
    calibration.raw = read_raw(root);
    take_rig_of_raw(calibration, root, request);
    return calibration;
  }
  calibration.rig.focal_px = root.number("focal_px");
  calibration.rig.cx_px = root.number("cx_px");
  calibration.rig.cy_px = root.number("cy_px");
  if (request.has_depth && !root.has("baseline_m")) {
    const Rig& rig{calibration.rig};
    take_single(calibration, {rig.focal_px, rig.focal_px, rig.cx_px, rig.cy_px, {}}, root, request);
    return calibration;
  }
  calibration.rig.baseline_m = root.number("baseline_m");
  take_right_centre(calibration, root);
  return calibration;
}

}  // namespace

Calibration read_own_calibration(const YamlGroup& root, const std::filesystem::path& path,
                                 const CalibrationRequest& request) {
  if (request.is_named) root.fail("is a calibration.yaml that another one names.", "Name another tool's file there.");
  Calibration calibration{root.has("from") ? read_named(root, path, request) : read_whole(root, request)};
  if (root.has("rotate")) {
    const double degrees{root.number("rotate")};
    if (degrees != 0 && degrees != 180) root.fail("has a 'rotate' that is neither 0 nor 180.");
    calibration.is_upside_down = degrees == 180;
  }
  if (root.has("labels")) calibration.labels = read_labels(root);
  if (root.has("mask")) calibration.mask = path.parent_path() / root.file_name("mask");
  if (!root.has("mount")) return calibration;
  const YamlGroup mount{root.group("mount", {"camera_height_m", "camera_pitch_rad", "camera_roll_rad", "camera_x_m",
                                             "camera_y_m", "camera_yaw_rad"})};
  calibration.rig.camera_x_m = mount.number("camera_x_m", 0);
  calibration.rig.camera_y_m = mount.number("camera_y_m", 0);
  calibration.rig.camera_yaw_rad = mount.number("camera_yaw_rad", 0);
  const bool has_place{mount.has("camera_x_m") || mount.has("camera_y_m") || mount.has("camera_yaw_rad")};
  calibration.has_extrinsics = mount.has("camera_height_m") || !has_place;
  if (!calibration.has_extrinsics) return calibration;
  calibration.rig.camera_height_m = mount.number("camera_height_m");
  calibration.rig.camera_pitch_rad = mount.number("camera_pitch_rad", 0);
  calibration.rig.camera_roll_rad = mount.number("camera_roll_rad", 0);
  return calibration;
}

}  // namespace stereogrid::io
