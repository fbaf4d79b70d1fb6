// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <iterator>

#include "input/calibration/calibration_forms.hpp"
#include "input/layout/input_layout.hpp"
#include "input/poses/recording_poses.hpp"
#include "input/recording_images.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/poses.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/io/rectifier.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

namespace fs = std::filesystem;

void warn_of_missing_images(RecordingContents& contents) {
  constexpr std::size_t most{5};
  std::size_t count{0};
  for (const RecordedFrame& frame : contents.frames) {
    if (frame.left_exists && frame.right_exists) continue;
    const bool left{!frame.left_exists};
    if (++count <= most) {
      const bool right{contents.disparities.empty()};
      const fs::path& file{left ? frame.left : right ? frame.right : frame.disparity};
      contents.warnings.push_back(fmt::format("frame {}: the {} image is missing ({})", frame.name,
                                              left    ? "left"
                                              : right ? "right"
                                                      : "disparity",
                                              printable_path(file)));
    }
  }
  if (count > most) {
    contents.warnings.push_back(fmt::format("{} more frames have only one image of the pair", count - most));
  }
}

void note_disparities(RecordingContents& contents) {
  const fs::path own{contents.root / "disparity"};
  if (!contents.disparities.empty()) {
    contents.notes.push_back(
        contents.has_depth
            ? fmt::format("depth: given in {}, no matching; {:g} units of whole numbers are a metre (--depth-scale)",
                          printable_path(contents.disparities), contents.depth_units_per_m)
            : fmt::format("disparities: given in {}, no matching{}", printable_path(contents.disparities),
                          contents.frames.front().right.empty() ? "" : "; right images for features"));
  } else if (contents.kind == name_of(InputKind::plain_folder) && is_folder(own)) {
    contents.notes.push_back(
        fmt::format("disparities: those in {} are not taken, since there are right images "
                    "(--disparities takes them)",
                    printable_path(own)));
  }
}

void note_calibration(RecordingContents& contents, const fs::path& source) {
  contents.notes.push_back(fmt::format("calibration: {} ({}{})", printable_path(source), contents.calibration.kind,
                                       contents.calibration.raw ? ", raw pair: rectified on loading" : ""));
  for (const std::string& note : contents.calibration.notes) contents.notes.push_back(note);
  if (!contents.calibration.has_extrinsics) {
    const Rig& rig{contents.calibration.rig};
    contents.notes.push_back(
        fmt::format("extrinsics: not in the calibration; camera height {:.2f} m and pitch {:g} "
                    "assumed",
                    rig.camera_height_m, rig.camera_pitch_rad));
  }
  Rig rig{contents.calibration.rig};
  if (const auto& raw{contents.calibration.raw}) {  // as it is in the file: the rectified pair has another one
    rig.focal_px = std::min(raw->left.focal_u_px, raw->right.focal_u_px);
  }
  std::vector<std::string> warnings{oddities(rig)};
  std::ranges::copy(contents.calibration.warnings, std::back_inserter(warnings));
  for (const std::string& warning : warnings) contents.warnings.push_back(printable_path(source) + ": " + warning);
}

fs::path calibration_file_of(const fs::path& root, const InputLayout& layout, const InputArguments& arguments,
                             bool has_depth) {
  const fs::path file{arguments.calibration.value_or(layout.calibration)};
  const bool may_be_beside{layout.kind == InputKind::plain_folder || layout.kind == InputKind::euroc};
  if (!file.empty()) return file;
  const fs::path beside{may_be_beside ? find_calibration_in(layout.root, has_depth) : fs::path{}};
  if (!beside.empty()) return beside;
  throw InputError{printable_path(root), "there is no calibration.",
                   layout.kind == InputKind::image_pair
                       ? "Name a file with --calibration."
                       : "Put a calibration.yaml there, or name a file with --calibration."};
}

void read_calibration_of(RecordingContents& contents, const InputLayout& layout, Size size) {
  CalibrationRequest request{size.width_px, size.height_px, layout.pair};
  request.has_depth = contents.has_depth;
  request.cameras = camera_numbers(layout);
  contents.calibration = read_calibration(contents.calibration_file, request);
  if (contents.calibration.is_upside_down && !contents.external.empty()) {
    throw InputError{printable_path(contents.calibration_file), "has 'rotate', which needs right images.",
                     "Turn the images and their depth or disparities before."};
  }
  note_calibration(contents, contents.calibration_file);
}

/// Size of a camera's image where each image shows both.
Size find_layout_of(RecordingContents& contents, const InputLayout& layout, const InputArguments& arguments,
                    Size size) {
  if (!layout.is_shared) {
    if (!arguments.layout || *arguments.layout == ImageLayout::separate) return size;
    throw InputError{printable_path(contents.root), "has images of each camera: --layout has no effect on them.",
                     "Leave --layout out."};
  }
  contents.layout = find_layout(size, arguments.layout, contents.calibration_file, contents.root);
  contents.notes.emplace_back(contents.layout == ImageLayout::side_by_side
                                  ? "images: left and right one side by side"
                                  : "images: the left one above the right one");
  return size_of_part(size, contents.layout);
}

/// Label images of the left images, by their names.
void find_labels(RecordingContents& contents, const InputArguments& arguments) {
  const fs::path folder{arguments.labels.value_or(contents.root / "labels")};
  const bool has_classes{!contents.calibration.labels.empty()};
  if (!is_folder(folder)) {
    if (arguments.labels)
      throw InputError{printable_path(folder), "there is no such folder.", "It has a label image per left image."};
    if (has_classes) contents.warnings.push_back("labels: the calibration has classes, but there is no folder labels/");
    return;
  }
  if (!has_classes) {
    const std::string text{fmt::format("labels: {} is not used: calibration.yaml has no 'labels: {{ignore: […], …}}'",
                                       printable_path(folder))};
    if (arguments.labels)
      throw InputError{printable_path(folder), "has labels without a meaning.",
                       "Add 'labels: {ignore: […], passable: […], obstacle: […], mover: […]}' to calibration.yaml."};
    contents.notes.push_back(text);
    return;
  }
  const Images images{images_in(folder, {".png", ".tif", ".tiff", ".pgm"})};
  std::size_t found{0};
  for (RecordedFrame& frame : contents.frames) {
    const auto image{images.find(frame.name)};
    if (image == images.end()) continue;
    frame.labels = image->second;
    ++found;
  }
  contents.labels = folder;
  if (found == contents.frames.size()) {
    contents.notes.push_back(fmt::format("labels: {}", printable_path(folder)));
  } else {
    contents.warnings.push_back(fmt::format("labels: {} has images of {} of {} frames, by their names",
                                            printable_path(folder), found, contents.frames.size()));
  }
}

void find_mask(RecordingContents& contents, const InputArguments& arguments) {
  contents.mask_file = arguments.mask.value_or(contents.calibration.mask);
  if (contents.mask_file.empty()) return;
  contents.mask = read_mask(contents.mask_file, contents.calibration);
  MaskUse use{use_of_mask(contents.mask_file, contents.mask)};
  (use.is_odd ? contents.warnings : contents.notes).push_back(std::move(use.text));
}

/// Throws InputError where a folder has distances from the camera's centre, as simulators name them.
void refuse_distances(const fs::path& folder) {
  std::string name{printable_path(folder.filename() == "data" ? folder.parent_path().filename() : folder.filename())};
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (name.find("distance_to_camera") == std::string::npos && name.find("perspective") == std::string::npos) return;
  throw InputError{printable_path(folder), "has distances from the camera's centre, not depths along its axis.",
                   "Record distance_to_image_plane (Isaac Sim) or DepthPlanar (AirSim), or multiply each pixel by "
                   "f / sqrt(f² + (u − cx)² + (v − cy)²)."};
}

RecordingContents look_at(const InputArguments& arguments) {
  if (arguments.depth && arguments.disparities) {
    throw ConfigError{"--depth and --disparities are given: one of them takes the place of the right images."};
  }
  if (arguments.with_right && !arguments.disparities) {
    throw ConfigError{"--with-right needs --disparities: it adds the right images to disparities from files."};
  }
  InputLayout layout{recognise(arguments.paths, arguments.depth ? arguments.depth : arguments.disparities)};
  layout.with_right = arguments.with_right;
  RecordingContents contents;
  contents.kind = name_of(layout.kind);
  contents.root = layout.root;
  contents.disparities = layout.disparities;
  contents.has_depth = arguments.depth.has_value() || (!arguments.disparities && is_depth_folder(layout.disparities));
  if (contents.has_depth) refuse_distances(layout.disparities);
  constexpr double tum_units_per_m{5000};
  const bool is_of_tum{is_there(layout.root / "depth.txt") && is_there(layout.root / "rgb.txt")};
  contents.depth_units_per_m = arguments.depth_units_per_m.value_or(is_of_tum ? tum_units_per_m : 1000);
  if (!layout.disparities.empty()) {
    contents.external = (contents.has_depth ? "depth: " : "") + printable_path(layout.disparities);
  }
  contents.frames = find_frames(layout);
  note_disparities(contents);
  warn_of_missing_images(contents);
  const Size whole{look_at_images(contents)};
  contents.calibration_file = calibration_file_of(contents.root, layout, arguments, contents.has_depth);
  read_calibration_of(contents, layout, find_layout_of(contents, layout, arguments, whole));
  find_mask(contents, arguments);
  find_labels(contents, arguments);
  const bool stamps_known{find_stamps(contents, layout, arguments.poses)};
  find_poses_of(contents, layout, arguments.poses, stamps_known);
  warn_of_speed(contents);
  if (is_folder(layout.root / "truth") && layout.kind == InputKind::plain_folder) {
    contents.truth_folder = layout.root / "truth";
  }
  return contents;
}

/// `found` keeps its images.
RecordingContents look_at(const InputArguments& arguments, ForeignRecording& found) {
  RecordingContents contents;
  contents.kind = std::move(found.kind);
  contents.root = found.root;
  contents.sample_bits = found.sample_bits;
  contents.external = std::move(found.external);
  contents.has_depth = !contents.external.empty();
  contents.poses_source = std::move(found.poses_source);
  contents.grids_source = std::move(found.grids_source);
  contents.why_no_grids = std::move(found.why_no_grids);
  contents.notes = std::move(found.notes);
  contents.warnings = std::move(found.warnings);
  for (const std::int64_t stamp_ns : found.stamps_ns) {
    RecordedFrame& frame{contents.frames.emplace_back()};
    frame.name = fmt::format("{:06}", contents.frames.size() - 1);
    frame.stamp_ns = stamp_ns;
    frame.left = found.root;
    frame.right = found.root;
  }
  InputLayout layout;  // with nothing beside the images
  layout.kind = InputKind::image_pair;
  layout.root = found.root;
  if (arguments.calibration) {
    contents.calibration_file = *arguments.calibration;
    read_calibration_of(contents, layout, {found.width_px, found.height_px});
  } else {
    contents.calibration = std::move(found.calibration).value();
    note_calibration(contents, found.root);
  }
  find_mask(contents, arguments);
  settle_stamps(contents, found.root);
  const bool are_own{found.poses.size() > 1 && (arguments.poses.empty() || arguments.poses == "file")};
  if (are_own) {
    take_own_poses(contents, found.root, found.poses);
  } else {
    find_poses_of(contents, layout, arguments.poses, true);
  }
  warn_of_speed(contents);
  return contents;
}

}  // namespace

namespace {

/// The first pair that can be loaded, as recorded.
std::optional<StereoFrame> first_pair(const Recording& recording) {
  constexpr std::size_t most_tried{15};
  for (std::size_t i{0}; i < std::min(most_tried, recording.size()); ++i) {
    try {
      return recording.load_unrectified(i);
    } catch (const InputError&) {  // reported where the frame is loaded
    }
  }
  return std::nullopt;
}

/// Turns the images of cameras that are upside down. Cameras turned one by one have negative disparities.
std::unique_ptr<Recording> with_turned_images(std::unique_ptr<Recording> recording) {
  if (!recording->contents().calibration.is_upside_down) return recording;
  const auto pair{first_pair(*recording)};
  const bool are_exchanged{pair &&
                           coarse_match_share(pair->left, pair->right) > coarse_match_share(pair->right, pair->left)};
  recording->turn_images(are_exchanged);
  return recording;
}

/// Takes the lens model under which the rows of left and right images match.
std::unique_ptr<Recording> with_lens(std::unique_ptr<Recording> recording) {
  if (!recording->contents().calibration.is_lens_unnamed || recording->gives_disparities()) return recording;
  constexpr std::size_t most_frames{5};
  constexpr std::size_t fewest_corners{20};
  constexpr double clearly{0.8};  // ratio of the residuals
  std::vector<StereoFrame> frames;
  for (std::size_t i{0}; i < recording->size() && frames.size() < most_frames; ++i) {
    const std::size_t index{i * std::max<std::size_t>(1, recording->size() / most_frames)};
    try {
      if (index < recording->size()) frames.push_back(recording->load_unrectified(index));
    } catch (const InputError&) {  // reported where the frame is loaded
    }
  }
  if (frames.empty()) return recording;
  RawPair raw{*recording->contents().calibration.raw};
  const RowResidual perspective{row_residual(raw, frames)};
  raw.left.lens = raw.right.lens = LensModel::fisheye;
  const RowResidual fisheye{row_residual(raw, frames)};
  const auto wins{[&](const RowResidual& one, const RowResidual& other) {
    return one.corners >= fewest_corners && (other.corners < fewest_corners || one.rms_rad < clearly * other.rms_rad);
  }};
  const std::string residuals{
      fmt::format("vertical residuals {:.2g} and {:.2g} mrad", 1e3 * fisheye.rms_rad, 1e3 * perspective.rms_rad)};
  if (wins(fisheye, perspective)) {
    recording->set_lens(
        LensModel::fisheye,
        fmt::format("lens: four coefficients taken as cv::fisheye's, not as k1 k2 p1 p2 ({})", residuals));
  } else if (wins(perspective, fisheye)) {
    recording->set_lens(
        LensModel::perspective,
        fmt::format("lens: four coefficients taken as k1 k2 p1 p2, not as cv::fisheye's ({})", residuals));
  } else {
    throw InputError{
        printable_path(recording->contents().calibration_file),
        fmt::format("has four distortion coefficients and no lens model, and the images do not show which it "
                    "is ({}, fisheye and perspective).",
                    residuals),
        "Name the file in a calibration.yaml with 'from: FILE' and 'lens: fisheye', or 'lens: perspective'."};
  }
  return recording;
}

/// With a calibration that lies beside the videos, where none is named.
std::unique_ptr<Recording> open_recording_of(const VideoPair& videos, InputArguments arguments) {
  const fs::path folder{videos.left.parent_path().empty() ? "." : videos.left.parent_path()};
  if (!arguments.calibration) {
    const fs::path own{own_calibration_in(folder)};
    const fs::path found{own.empty() ? find_calibration_in(folder) : own};
    if (found.empty()) {
      throw InputError{printable_path(videos.left), "there is no calibration beside the video.",
                       "Put a calibration.yaml there, or name a file with --calibration."};
    }
    arguments.calibration = found;
  }
  ForeignRecording found{open_videos(videos, arguments.layout, *arguments.calibration)};
  return open_recording(arguments, std::move(found));
}

}  // namespace

std::unique_ptr<Recording> open_recording(const InputArguments& arguments, ForeignRecording found) {
  if (arguments.disparities || arguments.depth) {
    throw ConfigError{"--disparities and --depth belong to images in files, by their names; this input has none."};
  }
  RecordingContents contents{look_at(arguments, found)};
  return with_lens(with_turned_images(std::make_unique<Recording>(std::move(contents), std::move(found.images))));
}

std::unique_ptr<Recording> open_recording(const InputArguments& arguments) {
  if (auto cameras{open_camera_folders(arguments)}) return cameras;
  if (const auto videos{find_videos(arguments.paths)}) return open_recording_of(*videos, arguments);
  return with_lens(with_turned_images(std::make_unique<Recording>(look_at(arguments))));
}

}  // namespace stereogrid::io
