// SPDX-License-Identifier: Apache-2.0
#include "input/layout/input_layout.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "input/calibration/calibration_forms.hpp"
#include "input/layout/side_names.hpp"
#include "input/recording_images.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

namespace fs = std::filesystem;

const char* const what_input_may_be{
    "INPUT is a folder: a KITTI odometry sequence (image_0/ image_1/ calib.txt), a KITTI raw drive (image_00/data/ "
    "image_01/data/), a EuRoC folder (mav0/cam0/data/), or left/ right/ (or disparity/) calibration.yaml; or two "
    "images "
    "LEFT RIGHT, folders or videos with --calibration FILE."};

/// The first of the candidates that exists; empty: none does.
fs::path first_existing(std::initializer_list<fs::path> candidates) {
  for (const fs::path& candidate : candidates) {
    if (is_there(candidate)) return candidate;
  }
  return {};
}

}  // namespace

fs::path own_calibration_in(const fs::path& folder) {
  return first_existing(
      {folder / "calibration.yaml", folder / "calibration.yml", folder / "calib.yaml", folder / "calib.yml"});
}

namespace {

void need_folder(const fs::path& folder) {
  if (!is_folder(folder)) {
    throw InputError{printable_path(folder), "the folder is missing.",
                     "Both cameras' images are needed, left and right."};
  }
}

InputLayout odometry(const fs::path& root) {
  const bool grey{is_folder(root / "image_0") || is_folder(root / "image_1")};
  InputLayout layout{InputKind::kitti_odometry,
                     root,
                     root / (grey ? "image_0" : "image_2"),
                     root / (grey ? "image_1" : "image_3"),
                     {},
                     {},
                     grey ? KittiPair::grey : KittiPair::colour};
  layout.calibration = first_existing({root / "calib.txt", own_calibration_in(root)});
  layout.scans = first_existing({root / "velodyne"});
  return layout;
}

InputLayout raw_drive(const fs::path& root) {
  const bool grey{is_folder(root / "image_00") || is_folder(root / "image_01")};
  const auto images{[&root](const char* camera) {
    const fs::path folder{root / camera};
    if (is_folder(folder / "data_rect")) return folder / "data_rect";  // KITTI-360
    const bool is_flat{!is_folder(folder / "data") && is_folder(folder) &&
                       !images_in(folder, image_extensions).empty()};
    return is_flat ? folder : folder / "data";
  }};
  InputLayout layout{InputKind::kitti_raw,
                     root,
                     images(grey ? "image_00" : "image_02"),
                     images(grey ? "image_01" : "image_03"),
                     {},
                     {},
                     grey ? KittiPair::grey : KittiPair::colour};
  const fs::path day{fs::absolute(root / "").lexically_normal().parent_path().parent_path()};
  layout.calibration =
      first_existing({root / "calib_cam_to_cam.txt", day / "calib_cam_to_cam.txt", own_calibration_in(root),
                      day.parent_path() / "calibration" / "perspective.txt"});  // KITTI-360
  layout.scans = first_existing({root / "velodyne_points" / "data"});
  return layout;
}

/// The folder itself, or the one in it that has the images.
fs::path images_of(const fs::path& camera) {
  for (const char* const inside : {"data", "images", "image", "rgb", "frames", "image_raw", "image_rect"}) {
    if (is_folder(camera / inside)) return camera / inside;
  }
  return camera;
}

/// Disparities or depth instead of right images.
fs::path depth_in(const fs::path& root) {
  return first_existing({root / "disparity", root / "disparities", root / "disp", root / "depth", root / "depths",
                         root / "depth_image", root / "depth_images", root / "aligned_depth", root / "depth_left",
                         root / "distance_to_image_plane", root / "depth_meter"});
}

InputLayout plain_folder(const fs::path& root) {
  InputLayout layout{InputKind::plain_folder, root, images_of(root / "left"), images_of(root / "right"), {}, {},
                     KittiPair::grey};
  layout.calibration = first_existing({own_calibration_in(root), root / "calib.txt"});
  layout.scans = first_existing({root / "velodyne"});
  if (!is_there(layout.right)) layout.disparities = depth_in(root);
  return layout;
}

std::vector<fs::path> folders_in(const fs::path& root) {
  std::vector<fs::path> folders{entries_of(root)};
  std::erase_if(folders, [](const fs::path& entry) { return !is_folder(entry); });
  return folders;
}

/// As data sets of EuRoC (ASL): cam0/data/NANOSECONDS.png, cam0/sensor.yaml.
std::optional<InputLayout> euroc(const fs::path& root) {
  const fs::path base{is_folder(root / "mav0") ? root / "mav0" : root};
  if (!is_folder(base / "cam0" / "data") || !is_folder(base / "cam1" / "data")) return std::nullopt;
  InputLayout layout{InputKind::euroc, root, base / "cam0" / "data", base / "cam1" / "data", {}, {}, KittiPair::grey};
  layout.calibration = first_existing({own_calibration_in(root), base / "cam0" / "sensor.yaml"});
  if (is_cam0_right(base / "cam0" / "sensor.yaml", base / "cam1" / "sensor.yaml")) std::swap(layout.left, layout.right);
  return layout;
}

/// As TUM RGB-D and ScanNet: images of one camera in a folder, depth or disparities of them in another, or in `depth`.
std::optional<InputLayout> images_with_depth(const fs::path& root, const fs::path& depth) {
  const fs::path images{
      first_existing({root / "rgb", root / "color", root / "colour", root / "image", root / "images", root / "cam0",
                      root / "infra1", root / "grey", root / "gray", root / "image_left"})};
  if (images.empty() || !is_folder(images) || !is_folder(depth)) return std::nullopt;
  InputLayout layout{plain_folder(root)};
  layout.left = images_of(images);
  layout.disparities = images_of(depth);
  return layout;
}

std::optional<InputLayout> recognise_folder(const fs::path& root, const std::optional<fs::path>& disparities = {}) {
  const auto has{[&root](const char* name) { return is_folder(root / name); }};
  if (has("image_00") || has("image_01") || has("image_02") || has("image_03")) return raw_drive(root);
  if (has("image_0") || has("image_1") || has("image_2") || has("image_3")) return odometry(root);
  if (has("left") || has("right")) return plain_folder(root);
  if (auto layout{euroc(root)}) return layout;
  const auto sides{side_folders(folders_in(root))};
  if (!sides) return images_with_depth(root, disparities.value_or(depth_in(root)));
  InputLayout layout{plain_folder(root)};
  layout.disparities.clear();
  layout.left = images_of(sides->left);
  layout.right = images_of(sides->right);
  return layout;
}

struct OtherFile {
  const char* extension;
  const char* what;
  const char* mend;
};
constexpr const char* unpack_it{"Unpack it, and name the folder."};
constexpr const char* extract_it{"Extract the images of both cameras into left/ and right/, or a ROS 2 bag."};
constexpr OtherFile other_files[]{{".svo", "a recording of ZED's SDK (SVO)",
                                   "Export it with ZED's SVO Export sample, as images or a side-by-side AVI."},
                                  {".svo2", "a recording of ZED's SDK (SVO)",
                                   "Export it with ZED's SVO Export sample, as images or a side-by-side AVI."},
                                  {".zip", "a zip archive", unpack_it},
                                  {".tar", "a tar archive", unpack_it},
                                  {".tgz", "a tar archive (gzip)", unpack_it},
                                  {".gz", "compressed with gzip", unpack_it},
                                  {".bz2", "compressed with bzip2", unpack_it},
                                  {".xz", "compressed with xz", unpack_it},
                                  {".7z", "a 7z archive", unpack_it},
                                  {".rar", "a rar archive", unpack_it},
                                  {".h5", "an HDF5 file", extract_it},
                                  {".hdf5", "an HDF5 file", extract_it},
                                  {".rrd", "a recording of Rerun", extract_it},
                                  {".oni", "a recording of OpenNI", extract_it},
                                  {".aedat4", "a recording of events", extract_it},
                                  {".tfrecord", "a TFRecord file", extract_it}};

/// Throws InputError where the file is of a known format that is not read.
void refuse_other_file(const fs::path& file) {
  std::string extension{file.extension().string()};
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const OtherFile& other : other_files) {
    if (extension != other.extension) continue;
    throw InputError{printable_path(file), fmt::format("is {}, which is not read.", other.what), other.mend};
  }
}

[[noreturn]] void not_recognised(const fs::path& root) {
  std::string inside;
  const std::vector<fs::path> entries{entries_of(root)};
  for (const fs::path& entry : entries) {
    if (inside.empty() && is_folder(entry) && recognise_folder(entry)) inside = printable_path(entry);
  }
  if (inside.empty() && is_there(root / "run.json")) {
    throw InputError{printable_path(root), "holds results of stereogrid, and no recording.",
                     "Show them with 'stereogrid view'; INPUT is the recording that they are of."};
  }
  if (inside.empty()) refuse_videos(entries);
  for (const fs::path& entry : entries) {
    if (inside.empty()) refuse_other_file(entry);
  }
  throw InputError{
      printable_path(root), "holds no stereo recording that is known.",
      inside.empty() ? what_input_may_be : "There are recordings inside; name one, such as " + inside + "."};
}

/// Both cameras' images in one folder, recognised by their names, or both in each image.
std::optional<InputLayout> folder_of_images(const fs::path& root) {
  const fs::path folder{images_in(root, image_extensions).empty() ? images_of(root) : root};
  const Images images{images_in(folder, image_extensions)};
  if (images.empty()) return std::nullopt;
  InputLayout layout{plain_folder(root)};
  layout.disparities.clear();
  layout.left = layout.right = folder;
  layout.is_shared = !split_by_name(images, images).has_value();
  if (layout.is_shared && !images_in(folder, {".pfm"}).empty()) {  // disparities beside their images, as Middlebury's
    layout.disparities = folder;
    layout.is_shared = false;
  }
  return layout;
}

/// The folder of both.
fs::path common_folder(const fs::path& one, const fs::path& other) {
  const fs::path a{fs::absolute(one).lexically_normal()};
  const fs::path b{fs::absolute(other).lexically_normal()};
  fs::path common;
  for (auto i{a.begin()}, j{b.begin()}; i != a.end() && j != b.end() && *i == *j; ++i, ++j) common /= *i;
  return common;
}

InputLayout two_folders(const fs::path& left, const fs::path& right) {
  InputLayout layout{plain_folder(common_folder(left, right))};
  layout.disparities.clear();
  layout.left = images_of(left);
  layout.right = images_of(right);
  return layout;
}

/// "3" of cam3, as in a Kalibr file.
std::optional<int> camera_number(const fs::path& folder, const fs::path& root) {
  const fs::path relative{folder.lexically_relative(root)};
  const std::string name{relative.empty() ? std::string{} : relative.begin()->string()};
  constexpr std::string_view word{"cam"};
  if (name.size() != word.size() + 1 || !name.starts_with(word) || name.back() < '0' || name.back() > '9') return {};
  return name.back() - '0';
}

}  // namespace

std::array<int, 2> camera_numbers(const InputLayout& layout) {
  const auto left{camera_number(layout.left, layout.root)};
  const auto right{camera_number(layout.right, layout.root)};
  if (!left || !right || *left == *right) return {0, 1};
  return {std::min(*left, *right), std::max(*left, *right)};
}

bool is_depth_folder(const fs::path& folder) {
  const fs::path name{folder.filename() == "data" ? folder.parent_path().filename() : folder.filename()};
  return name.string().find("depth") != std::string::npos || name == "distance_to_image_plane";
}

std::string name_of(InputKind kind) {
  switch (kind) {
    case InputKind::kitti_odometry:
      return "KITTI odometry sequence";
    case InputKind::kitti_raw:
      return "KITTI raw drive";
    case InputKind::euroc:
      return "EuRoC (ASL) folder";
    case InputKind::plain_folder:
      return "plain folder";
    case InputKind::image_pair:
      return "image pair";
  }
  return {};
}

InputLayout recognise(const std::vector<fs::path>& paths, const std::optional<fs::path>& disparities) {
  if (disparities && !is_folder(*disparities)) {
    throw InputError{printable_path(*disparities), "there is no such folder.",
                     "--disparities, or --depth, is a folder with an image for each left image."};
  }
  if (paths.empty() || paths.size() > 2) throw InputError{"INPUT", "is missing.", what_input_may_be};
  for (const fs::path& path : paths) {
    if (!is_there(path)) throw InputError{printable_path(path), "there is no such file or folder.", what_input_may_be};
  }
  if (paths.size() == 2 && is_folder(paths[0]) && is_folder(paths[1])) {
    InputLayout layout{two_folders(paths[0], paths[1])};
    layout.disparities = disparities.value_or(fs::path{});
    return layout;
  }
  if (paths.size() == 2) {
    refuse_videos(paths);
    return {InputKind::image_pair,           paths[0], paths[0], paths[1], {}, {}, KittiPair::grey,
            disparities.value_or(fs::path{})};
  }
  if (!is_folder(paths[0])) {
    refuse_other_file(paths[0]);
    refuse_videos(paths);
    throw InputError{printable_path(paths[0]), "is one file; a pair needs two images.", what_input_may_be};
  }
  static_cast<void>(entries_of(paths[0]));  // complains where the folder cannot be read
  auto layout{recognise_folder(paths[0], disparities)};
  if (!layout) layout = folder_of_images(paths[0]);
  if (!layout) not_recognised(paths[0]);
  if (disparities) {
    layout->disparities = *disparities;
    layout->is_shared = false;
  }
  need_folder(layout->left);
  if (layout->disparities.empty()) need_folder(layout->right);
  return *layout;
}

}  // namespace stereogrid::io
