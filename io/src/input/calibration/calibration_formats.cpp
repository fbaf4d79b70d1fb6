// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

#include "input/calibration/calibration_forms.hpp"
#include "input/calibration/yaml_group.hpp"
#include "input/poses/kitti_text.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

namespace fs = std::filesystem;

/// A file, or two that belong together.
struct Files {
  const std::vector<fs::path>& paths;
  const YamlGroup& root;  ///< root of the first one

  /// The two files in the order of `pair_of`.
  [[nodiscard]] FilePair pair(FilePair (*pair_of)(const fs::path&)) const {
    return paths.size() == 2 ? FilePair{paths[0], paths[1]} : pair_of(paths[0]);
  }
};

bool has_any(const YamlGroup& root, std::initializer_list<const char*> keys) {
  return std::ranges::any_of(keys, [&](const char* key) { return root.has(key); });
}

Calibration read_ros(const Files& files, const CalibrationRequest& request) {
  const FilePair both{files.pair(left_and_right)};
  return read_ros_calibration(read_calibration_tree(both.first), read_calibration_tree(both.second), request);
}

/// Both cameras in one file, the right one first where the names say so.
Calibration read_ost(const Files& files, const CalibrationRequest& request) {
  const auto cameras{files.root.groups("cameras")};
  if (cameras.size() != 2) {
    files.root.fail(fmt::format("has {} cameras, not 2: it has no baseline.", cameras.size()),
                    "Give the ost.txt of a stereo calibration, or left.yaml and right.yaml.");
  }
  const auto name_of{[&](std::size_t i) {
    return cameras[i].group.has("camera_name") ? cameras[i].group.word("camera_name") : std::string{};
  }};
  const std::size_t left{name_of(0).find("right") != std::string::npos ? 1U : 0U};
  return read_ros_calibration(cameras[left].group, cameras[1 - left].group, request);
}

Calibration read_opencv(const Files& files, const CalibrationRequest& request) {
  const OpencvParts parts{opencv_parts(files.root)};
  if (parts.has_intrinsics && parts.has_extrinsics) return read_opencv_calibration(files.root, files.root, request);
  const std::string name{files.paths[0].filename().string()};
  const bool is_named{name.find("intrinsic") != std::string::npos || name.find("extrinsic") != std::string::npos};
  if (!is_named && files.paths.size() == 1 && parts.has_intrinsics) {
    files.root.fail("has both camera matrices, but no 'R' and 'T' from the left camera to the right one.",
                    "Give the whole result of stereoCalibrate; two files are called …intrinsics… and …extrinsics….");
  }
  const FilePair both{files.pair(intrinsics_and_extrinsics)};
  return read_opencv_calibration(read_calibration_tree(both.first), read_calibration_tree(both.second), request);
}

Calibration read_euroc(const Files& files, const CalibrationRequest& request) {
  const FilePair both{files.pair(left_and_right)};
  return read_euroc_calibration(read_calibration_tree(both.first), read_calibration_tree(both.second), request);
}

Calibration read_vins(const Files& files, const CalibrationRequest& request) {
  return read_vins_calibration(files.root, files.paths[0], request);
}

Calibration refuse_maps(const Files& files, const CalibrationRequest&) {
  files.root.fail("holds rectification maps, which have neither focal length nor baseline.",
                  "Save K, D, R and T of stereoCalibrate, or P1 and P2 or Q of stereoRectify, beside the maps.");
}

Calibration refuse_message(const Files& files, const CalibrationRequest&) {
  files.root.fail("is a CameraInfo message of ROS, not a calibration file.",
                  "Give the files that camera_calibration has written, left.yaml and right.yaml (docs/input.md).");
}

Calibration refuse_one_camera(const Files& files, const CalibrationRequest&) {
  files.root.fail("is the calibration of one camera: it has no baseline and no extrinsics to a second camera.",
                  "Write both cameras and their transform into a calibration.yaml (docs/input.md), or give Kalibr's "
                  "camchain.yaml.");
}

template <Calibration (*read)(const YamlGroup&, const CalibrationRequest&)>
Calibration read_one(const Files& files, const CalibrationRequest& request) {
  return read(files.root, request);
}

struct Format {
  bool (*is_it)(const YamlGroup& root);
  Calibration (*read)(const Files& files, const CalibrationRequest& request);
};

bool has_zed_section(const YamlGroup& root) {
  return root.has("STEREO") ||
         std::ranges::any_of(root.keys(), [](std::string_view key) { return key.starts_with("LEFT_CAM_"); });
}

/// stereoMapL_x, map1x, left_map_y and the like, of OpenCV's tutorials.
bool has_maps(const YamlGroup& root) {
  return std::ranges::any_of(root.keys(), [](std::string key) {
    std::erase(key, '_');
    std::ranges::transform(key, key.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const std::size_t place{key.find("map")};
    if (place == std::string::npos) return false;
    const std::string_view rest{std::string_view{key}.substr(place + 3)};
    return rest.size() <= 3 && rest.find_first_not_of("lrxy012") == std::string_view::npos;
  });
}

/// The first that fits.
constexpr std::array<Format, 17> formats{{
    {[](const YamlGroup& r) { return has_any(r, {"T_BS"}); }, read_euroc},
    {[](const YamlGroup& r) {
       return has_any(r, {"value0", "T_imu_cam"});
     },
     read_one<read_basalt_calibration>},
    {[](const YamlGroup& r) { return has_any(r, {"cameraData"}); }, read_one<read_depthai_calibration>},
    {has_zed_section, read_one<read_zed_calibration>},
    {[](const YamlGroup& r) { return has_any(r, {"cameras"}); }, read_ost},
    {[](const YamlGroup& r) { return r.has("cam0") && r.has("baseline"); }, read_one<read_middlebury_calibration>},
    {[](const YamlGroup& r) {
       return has_any(r, {"cam0", "cam1"});
     },
     read_one<read_kalibr_calibration>},
    {[](const YamlGroup& r) {
       return has_any(r, {"Camera.fx", "Camera1.fx", "LEFT.K"});
     },
     read_one<read_orbslam_calibration>},
    {[](const YamlGroup& r) { return r.has("body_T_cam0") && r.has("body_T_cam1"); }, read_vins},
    {is_vins_camera, refuse_one_camera},
    {[](const YamlGroup& r) {
       return has_any(r, {"CameraParameters1", "TranslationOfCamera2"});
     },
     read_one<read_matlab_calibration>},
    {[](const YamlGroup& r) {
       const OpencvParts parts{opencv_parts(r)};
       return parts.has_intrinsics && parts.has_extrinsics;
     },
     read_opencv},
    {[](const YamlGroup& r) {
       return has_any(r, {"camera_matrix", "projection_matrix"});
     },
     read_ros},
    {[](const YamlGroup& r) {
       return has_any(r, {"K", "k"}) && has_any(r, {"P", "p"});
     },
     refuse_message},
    {[](const YamlGroup& r) { return opencv_parts(r).has_projections; }, read_one<read_opencv_projections>},
    {[](const YamlGroup& r) {
       const OpencvParts parts{opencv_parts(r)};
       return parts.has_intrinsics || has_any(r, {"R", "T"});
     },
     read_opencv},
    {has_maps, refuse_maps},
}};

const Format* format_of(const YamlGroup& root) {
  const auto found{std::ranges::find_if(formats, [&](const Format& format) { return format.is_it(root); })};
  return found == formats.end() ? nullptr : found;
}

enum class Notation { yaml, xml, sections, assignments, ost, matrix, npz, colmap, kitti };

Notation notation_of(const fs::path& path, std::string_view text) {
  if (text.starts_with("PK\x03\x04")) return Notation::npz;
  const std::string_view start{text.substr(std::min(text.find_first_not_of(" \t\r\n"), text.size()))};
  const auto has_line{[&](std::string_view beginning) {
    return text.starts_with(beginning) || text.find("\n" + std::string{beginning}) != std::string_view::npos;
  }};
  if (path.extension() == ".yaml" || path.extension() == ".yml" || start.starts_with("%YAML")) return Notation::yaml;
  if (start.starts_with('<')) return Notation::xml;
  if (start.starts_with('{')) return Notation::yaml;
  if (has_line("[image]")) return Notation::ost;
  if (has_line("[LEFT_CAM_") || has_line("[STEREO]")) return Notation::sections;
  if (has_line("cam0=") || has_line("cam0 =") || has_line("fx=") || has_line("fx =")) return Notation::assignments;
  if (has_line("1 PINHOLE ") || has_line("1 SIMPLE_") || has_line("1 OPENCV") || has_line("1 RADIAL "))
    return Notation::colmap;
  const bool is_matrix{text.find_first_not_of("0123456789+-.eE \t\r\n,") == std::string_view::npos};
  return is_matrix && !start.empty() ? Notation::matrix : Notation::kitti;
}

YamlGroup tree_of(const fs::path& path, std::string text, Notation notation) {
  const std::string file{printable_path(path)};
  switch (notation) {
    case Notation::xml:
      return {file, "", parse_xml(file, text)};
    case Notation::sections:
      return {file, "", parse_sections(file, text)};
    case Notation::assignments:
      return {file, "", parse_assignments(file, text)};
    case Notation::matrix:
      return {file, "", parse_matrix(file, text)};
    case Notation::npz:
      return {file, "", parse_npz(path)};
    case Notation::colmap:
      return {file, "", parse_colmap(file, text)};
    case Notation::ost:
      return {file, "", parse_ost(file, text)};
    default:
      return parse_yaml(path, std::move(text));
  }
}

}  // namespace

YamlGroup read_calibration_tree(const fs::path& path) {
  std::string text{read_text(path, largest_bytes::calibration)};
  const Notation notation{notation_of(path, text)};
  return tree_of(path, std::move(text), notation);
}

bool is_calibration_of_other_tool(const fs::path& path, bool has_depth) {
  try {
    std::string text{read_text(path, largest_bytes::calibration)};
    const Notation notation{notation_of(path, text)};
    if (notation == Notation::kitti)
      return text.starts_with("P0:") || text.find("\nP0:") != std::string::npos ||
             text.find("P_rect_") != std::string::npos;
    const YamlGroup root{tree_of(path, std::move(text), notation)};
    return format_of(root) != nullptr || (has_depth && read_single_calibration(root, {}));
  } catch (const InputError&) {
    return false;
  }
}

Calibration read_form(const std::vector<fs::path>& paths, const CalibrationRequest& request) {
  const fs::path& path{paths.front()};
  std::string text{read_text(path, largest_bytes::calibration)};
  const Notation notation{notation_of(path, text)};
  if (notation == Notation::kitti) return read_kitti_calibration(path, request.pair);
  const YamlGroup root{tree_of(path, std::move(text), notation)};
  const Format* const format{format_of(root)};
  const bool is_known{format != nullptr && format->read != refuse_one_camera && format->read != refuse_message &&
                      format->read != refuse_maps};
  if (request.has_depth && !is_known) {
    if (auto single{read_single_calibration(root, request)}) return *std::move(single);
  }
  if (format != nullptr) return format->read({paths, root}, request);
  if (const auto single{read_single_calibration(root, request)}) {
    if (request.baseline_m) return *single;
    root.fail(
        "is the calibration of one camera: it has no baseline.",
        fmt::format("If both cameras are alike and the images rectified, write 'from: {}' and 'baseline_m: …' (m) "
                    "into a calibration.yaml.",
                    printable_path(path.filename())));
  }
  if (notation == Notation::yaml && (path.extension() == ".yaml" || path.extension() == ".yml")) {
    return read_own_calibration(root, path, request);
  }
  root.fail("is not a calibration that is known: no keys of two cameras.", see_documentation);
}

}  // namespace stereogrid::io
