// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "input/input_layout.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "files/unavailable.hpp"
#include "input/natural_order.hpp"
#include "input/poses/kitti_text.hpp"
#include "input/video_files.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

namespace fs = std::filesystem;

const char* const what_input_may_be{
    "INPUT is a folder: a KITTI odometry sequence (image_0/ image_1/ calib.txt), a KITTI raw drive (image_00/data/ "
    "image_01/data/) or left/ right/ (or disparity/) calibration.yaml; or two images LEFT RIGHT with --calibration "
    "FILE."};

/// The first of the candidates that exists; empty: none does.
fs::path first_existing(std::initializer_list<fs::path> candidates) {
  for (const fs::path& candidate : candidates) {
    if (fs::exists(candidate)) return candidate;
  }
  return {};
}

void need_folder(const fs::path& folder) {
  if (!fs::is_directory(folder)) {
    throw InputError{printable_path(folder), "the folder is missing.",
                     "Both cameras' images are needed, left and right."};
  }
}

InputLayout odometry(const fs::path& root) {
  const bool grey{fs::is_directory(root / "image_0") || fs::is_directory(root / "image_1")};
  InputLayout layout{InputKind::kitti_odometry,
                     root,
                     root / (grey ? "image_0" : "image_2"),
                     root / (grey ? "image_1" : "image_3"),
                     {},
                     {},
                     grey ? KittiPair::grey : KittiPair::colour};
  layout.calibration = first_existing({root / "calib.txt", root / "calibration.yaml"});
  layout.scans = first_existing({root / "velodyne"});
  return layout;
}

InputLayout raw_drive(const fs::path& root) {
  const bool grey{fs::is_directory(root / "image_00") || fs::is_directory(root / "image_01")};
  const auto images{[&root](const char* camera) { return root / camera / "data"; }};
  InputLayout layout{InputKind::kitti_raw,
                     root,
                     images(grey ? "image_00" : "image_02"),
                     images(grey ? "image_01" : "image_03"),
                     {},
                     {},
                     grey ? KittiPair::grey : KittiPair::colour};
  layout.calibration =
      first_existing({root / "calib_cam_to_cam.txt",
                      fs::absolute(root / "").lexically_normal().parent_path().parent_path() / "calib_cam_to_cam.txt",
                      root / "calibration.yaml"});
  layout.scans = first_existing({root / "velodyne_points" / "data"});
  return layout;
}

InputLayout plain_folder(const fs::path& root) {
  InputLayout layout{InputKind::plain_folder, root, root / "left", root / "right", {}, {}, KittiPair::grey};
  layout.calibration = first_existing({root / "calibration.yaml", root / "calibration.yml", root / "calib.txt"});
  layout.scans = first_existing({root / "velodyne"});
  if (!fs::exists(layout.right)) layout.disparities = first_existing({root / "disparity", root / "depth"});
  return layout;
}

std::optional<InputLayout> recognise_folder(const fs::path& root) {
  const auto has{[&root](const char* name) { return fs::is_directory(root / name); }};
  if (has("image_00") || has("image_01") || has("image_02") || has("image_03")) return raw_drive(root);
  if (has("image_0") || has("image_1") || has("image_2") || has("image_3")) return odometry(root);
  if (has("left") || has("right")) return plain_folder(root);
  return std::nullopt;
}

std::vector<fs::path> entries_of(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> entries;
  fs::directory_iterator entry{folder, error};
  for (; !error && entry != fs::directory_iterator{}; entry.increment(error)) entries.push_back(entry->path());
  if (error && is_temporary(error.value())) throw_unreadable(folder, error.value());
  if (error) {
    throw InputError{printable_path(folder), "the folder cannot be read (" + error.message() + ").",
                     "Check its permissions."};
  }
  std::ranges::sort(entries);
  return entries;
}

[[noreturn]] void not_recognised(const fs::path& root) {
  std::string inside;
  const std::vector<fs::path> entries{entries_of(root)};
  for (const fs::path& entry : entries) {
    if (inside.empty() && fs::is_directory(entry) && recognise_folder(entry)) inside = printable_path(entry);
  }
  if (inside.empty()) refuse_videos(entries);
  throw InputError{
      printable_path(root), "holds no stereo recording that is known.",
      inside.empty() ? what_input_may_be : "There are recordings inside; name one, such as " + inside + "."};
}

/// Images by their name without extension.
using Images = std::map<std::string, fs::path, NaturalOrder>;

const std::set<std::string> image_extensions{".png", ".pgm", ".ppm", ".pnm", ".jpg", ".jpeg"};
const std::set<std::string> disparity_extensions{".png", ".pfm", ".tif", ".tiff", ".npy"};

// A frame's files are named after it: NAME.npz has to be a name that a file can have.
void check_length(const fs::path& file, const std::string& name) {
  constexpr std::size_t longest{251};
  if (name.size() <= longest) return;
  throw InputError{printable_path(file),
                   fmt::format("the name of the frame has {} bytes, more than {}.", name.size(), longest),
                   "Give the frame's files a shorter name."};
}

Images images_in(const fs::path& folder, const std::set<std::string>& extensions) {
  Images images;
  for (const fs::path& entry : entries_of(folder)) {
    std::string extension{entry.extension().string()};
    std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return std::tolower(c); });
    const std::string stem{entry.stem().string()};
    if (!extensions.contains(extension) || stem.starts_with('.')) continue;
    const std::string name{frame_name(stem)};
    check_length(entry, name);
    if (!images.emplace(name, entry).second) {
      throw InputError{printable_path(entry), "there is another image of the same name in this folder.",
                       "Keep one image for each name."};
    }
  }
  return images;
}

/// A line of frames.txt: a frame's name, or the name of its image.
std::string name_in(std::string_view line, const Images& left, const Images& right) {
  std::string name{frame_name(line)};
  if (left.contains(name) || right.contains(name)) return name;
  std::string stem{fs::path{name}.stem().string()};
  return left.contains(stem) || right.contains(stem) ? stem : name;
}

/// frames.txt: a name per line; lines of poses*.txt and times.txt belong to them.
std::vector<std::string> names_in(const fs::path& frames_file, const Images& left, const Images& right) {
  const std::string text{read_text(frames_file, largest_bytes::lines)};
  std::vector<std::string> names;
  std::set<std::string> known;
  for (const std::string_view line : lines_of(text)) {
    const auto start{line.find_first_not_of(" \t")};
    if (start == std::string_view::npos) continue;
    names.push_back(name_in(line.substr(start, line.find_last_not_of(" \t") - start + 1), left, right));
    if (!known.insert(names.back()).second) {
      throw InputError{printable_path(frames_file), "names frame " + printable(names.back()) + " twice.",
                       "Name each frame once, in their order."};
    }
  }
  const auto is_there{[&](const std::string& name) { return left.contains(name) || right.contains(name); }};
  if (std::ranges::any_of(names, is_there)) return names;
  throw InputError{printable_path(frames_file),
                   names.empty() ? "names no frames."
                                 : "names no frame that is there; the first is " + printable(names.front()) + ".",
                   "A line is the name of a frame's images, such as " + left.begin()->first +
                       "; without the file every image is taken."};
}

struct Side {
  fs::path folder;
  Images images;

  /// Where the image is or should be.
  [[nodiscard]] fs::path path_of(const std::string& name) const {
    const auto found{images.find(name)};
    return found != images.end() ? found->second : folder / (name + images.begin()->second.extension().string());
  }
};

struct Sides {
  Side left;
  Side right;        ///< may be empty where there are disparities
  Side disparities;  ///< no folder: none

  /// What a left image needs.
  [[nodiscard]] const Side& second() const { return disparities.folder.empty() ? right : disparities; }
};

Side side_of(const fs::path& folder, const std::set<std::string>& extensions, const char* mend) {
  Side side{folder, images_in(folder, extensions)};
  if (side.images.empty()) throw InputError{printable_path(folder), "holds no images.", mend};
  return side;
}

Sides sides_of(const InputLayout& layout) {
  const char* const mend{"PNG, PGM or JPEG files belong there, one per frame."};
  Sides sides;
  if (layout.kind == InputKind::image_pair) {
    sides.left = {layout.left.parent_path(), {{frame_name(layout.left.stem().string()), layout.left}}};
  } else {
    sides.left = side_of(layout.left, image_extensions, mend);
  }
  if (layout.disparities.empty()) {
    sides.right = side_of(layout.right, image_extensions, mend);
    return sides;
  }
  sides.disparities = side_of(layout.disparities, disparity_extensions,
                              "Disparities as PNG, PFM, TIFF or NPY belong there, one per left image.");
  // the drive's lines of poses and stamps belong to the frames of either camera
  if (fs::is_directory(layout.right)) sides.right = {layout.right, images_in(layout.right, image_extensions)};
  return sides;
}

/// Names of the frames in their order: those of frames.txt, else every image of either camera.
std::vector<std::string> order_of(const InputLayout& layout, const Images& left, const Images& right) {
  const auto frames_file{layout.root / "frames.txt"};
  if (layout.kind != InputKind::kitti_raw && fs::exists(frames_file)) return names_in(frames_file, left, right);
  std::set<std::string, NaturalOrder> names;
  for (const auto& [name, path] : left) names.insert(name);
  for (const auto& [name, path] : right) names.insert(name);
  return {names.begin(), names.end()};
}

}  // namespace

std::string name_of(InputKind kind) {
  switch (kind) {
    case InputKind::kitti_odometry:
      return "KITTI odometry sequence";
    case InputKind::kitti_raw:
      return "KITTI raw drive";
    case InputKind::plain_folder:
      return "plain folder";
    case InputKind::image_pair:
      return "image pair";
  }
  return {};
}

InputLayout recognise(const std::vector<fs::path>& paths, const std::optional<fs::path>& disparities) {
  if (disparities && !fs::is_directory(*disparities)) {
    throw InputError{printable_path(*disparities), "there is no such folder.",
                     "--disparities, or --depth, is a folder with an image for each left image."};
  }
  if (paths.empty() || paths.size() > 2) throw InputError{"INPUT", "is missing.", what_input_may_be};
  for (const fs::path& path : paths) {
    if (!fs::exists(path))
      throw InputError{printable_path(path), "there is no such file or folder.", what_input_may_be};
  }
  if (paths.size() == 2) {
    refuse_videos(paths);
    return {InputKind::image_pair,           paths[0], paths[0], paths[1], {}, {}, KittiPair::grey,
            disparities.value_or(fs::path{})};
  }
  if (!fs::is_directory(paths[0])) {
    refuse_videos(paths);
    throw InputError{printable_path(paths[0]), "is one file; a pair needs two images.", what_input_may_be};
  }
  static_cast<void>(entries_of(paths[0]));  // complains where the folder cannot be read
  auto layout{recognise_folder(paths[0])};
  if (!layout) not_recognised(paths[0]);
  if (disparities) layout->disparities = *disparities;
  need_folder(layout->left);
  if (layout->disparities.empty()) need_folder(layout->right);
  return *layout;
}

std::vector<RecordedFrame> find_frames(const InputLayout& layout) {
  if (layout.kind == InputKind::image_pair && layout.disparities.empty()) {
    const std::string name{frame_name(layout.left.stem().string())};
    check_length(layout.left, name);
    return {{name, 0, layout.left, layout.right, true, true, {}, {}, {}}};
  }
  const Sides sides{sides_of(layout)};
  std::vector<RecordedFrame> frames;
  for (const std::string& name : order_of(layout, sides.left.images, sides.right.images)) {
    RecordedFrame& frame{frames.emplace_back()};
    frame.name = name;
    frame.left = sides.left.path_of(name);
    frame.left_exists = sides.left.images.contains(name);
    frame.right_exists = sides.second().images.contains(name);
    (layout.disparities.empty() ? frame.right : frame.disparity) = sides.second().path_of(name);
    const auto scan{layout.scans / (frame.left.stem().string() + ".bin")};
    std::error_code error;  // a file that cannot be opened, such as a link without a target, is reported on reading
    const bool is_listed{fs::symlink_status(scan, error).type() != fs::file_type::not_found};
    if (!layout.scans.empty() && is_listed) frame.scan = scan;
  }
  if (std::ranges::none_of(frames, [](const RecordedFrame& f) { return f.left_exists && f.right_exists; })) {
    throw InputError{
        printable_path(layout.root),
        fmt::format("no left image has a {} one of the same name.", layout.disparities.empty() ? "right" : "disparity"),
        fmt::format("The images of a frame have the same name in {} and {}.", printable_path(layout.left.filename()),
                    printable_path(sides.second().folder.filename()))};
  }
  return frames;
}

}  // namespace stereogrid::io
