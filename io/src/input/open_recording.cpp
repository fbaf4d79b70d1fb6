// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <iterator>
#include <map>
#include <set>

#include "input/calibration/calibration_files.hpp"
#include "input/input_layout.hpp"
#include "input/poses/recording_poses.hpp"
#include "input/poses/stamps.hpp"
#include "input/recording_images.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/mask.hpp"
#include "stereogrid/io/poses.hpp"
#include "stereogrid/io/recording.hpp"
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
            : fmt::format("disparities: given in {}, no matching", printable_path(contents.disparities)));
  } else if (contents.kind == name_of(InputKind::plain_folder) && fs::is_directory(own)) {
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
  if (!contents.calibration.has_mounting) {
    contents.notes.push_back("mounting: not in the calibration; camera height 1.65 m and pitch 0 assumed");
  }
  std::vector<std::string> warnings{oddities(contents.calibration.rig)};
  std::ranges::copy(contents.calibration.warnings, std::back_inserter(warnings));
  for (const std::string& warning : warnings) contents.warnings.push_back(printable_path(source) + ": " + warning);
}

void find_calibration(RecordingContents& contents, const InputLayout& layout, const InputArguments& arguments,
                      Size size) {
  contents.calibration_file = arguments.calibration.value_or(layout.calibration);
  if (contents.calibration_file.empty() && layout.kind == InputKind::plain_folder) {
    contents.calibration_file = find_calibration_in(layout.root);
  }
  if (contents.calibration_file.empty()) {
    throw InputError{printable_path(contents.root), "there is no calibration.",
                     layout.kind == InputKind::image_pair
                         ? "Name a file with --calibration."
                         : "Put a calibration.yaml there, or name a file with --calibration."};
  }
  contents.calibration = read_calibration(contents.calibration_file, size.width_px, size.height_px, layout.pair);
  note_calibration(contents, contents.calibration_file);
}

void find_mask(RecordingContents& contents, const InputArguments& arguments) {
  contents.mask_file = arguments.mask.value_or(contents.calibration.mask);
  if (contents.mask_file.empty()) return;
  contents.mask = read_mask(contents.mask_file, contents.calibration);
  const auto masked{std::ranges::count(contents.mask, 0)};
  contents.notes.push_back(
      fmt::format("mask: {}, {:.1f} % of the image are not used", printable_path(contents.mask_file),
                  100.0 * static_cast<double>(masked) / static_cast<double>(contents.mask.size())));
}

/// Stamps by name. False: the frames are not all named in the file.
bool take_stamps(RecordingContents& contents, const std::vector<NamedPose>& rows) {
  std::map<std::string, std::int64_t> stamps;
  for (const NamedPose& row : rows) stamps[row.name] = row.stamp_ns;
  for (RecordedFrame& frame : contents.frames) {
    const auto found{stamps.find(frame.name)};
    if (found == stamps.end()) return false;
    frame.stamp_ns = found->second;
  }
  return true;
}

void take_stamps(RecordingContents& contents, const std::vector<std::int64_t>& stamps) {
  for (std::size_t i{0}; i < stamps.size(); ++i) contents.frames[i].stamp_ns = stamps[i];
}

/// Line i of timestamps.txt belongs to the image of number i: single images of a drive may have been left out.
bool take_numbered_stamps(RecordingContents& contents, const std::vector<std::int64_t>& stamps) {
  for (RecordedFrame& frame : contents.frames) {
    std::size_t number{0};
    const auto [end, error]{std::from_chars(frame.name.data(), frame.name.data() + frame.name.size(), number)};
    if (error != std::errc{} || *end != '\0' || number >= stamps.size()) return false;
    frame.stamp_ns = stamps[number];
  }
  return true;
}

fs::path stamps_file(const InputLayout& layout, const std::string& poses) {
  std::vector<fs::path> candidates{layout.root / "times.txt", layout.root / "poses.csv"};
  if (layout.kind == InputKind::plain_folder) std::ranges::reverse(candidates);
  if (layout.kind == InputKind::kitti_raw) candidates = {layout.left.parent_path() / "timestamps.txt"};
  if (layout.kind == InputKind::image_pair) candidates.clear();
  if (fs::path{poses}.extension() == ".csv") candidates.emplace_back(poses);
  const auto gives_stamps = [](const fs::path& path) {
    return fs::exists(path) && (path.extension() != ".csv" || are_named(read_poses_csv(path)));
  };
  const auto found{std::ranges::find_if(candidates, gives_stamps)};
  return found == candidates.end() ? fs::path{} : *found;
}

/// No camera takes images so seldom or so often: the stamps are in another unit.
void warn_of_rate(RecordingContents& contents, const fs::path& file) {
  constexpr double slowest_hz{0.1};
  constexpr double fastest_hz{1000};
  constexpr double counted_s{1.5e-9};
  std::vector<double> steps_s;
  for (std::size_t i{1}; i < contents.frames.size(); ++i) {
    const auto stamp_ns = [&](std::size_t frame) { return static_cast<double>(contents.frames[frame].stamp_ns); };
    steps_s.push_back((stamp_ns(i) - stamp_ns(i - 1)) * 1e-9);
  }
  if (steps_s.empty()) return;
  const auto middle = steps_s.begin() + static_cast<std::ptrdiff_t>((steps_s.size() - 1) / 2);
  std::ranges::nth_element(steps_s, middle);
  if (*middle < counted_s) {
    contents.notes.push_back(
        "stamps: a nanosecond apart, as if frames had been counted; times and speeds mean nothing");
    return;
  }
  if (*middle >= 1 / fastest_hz && *middle <= 1 / slowest_hz) return;
  contents.warnings.push_back(fmt::format(
      "{}: frames come at {:.3g} Hz, as hardly any camera's do. Stamps are seconds in times.txt, nanoseconds "
      "in poses.csv.",
      printable_path(file), 1 / *middle));
}

/// False: the images have no stamps, some are assumed.
bool find_stamps(RecordingContents& contents, const InputLayout& layout, const std::string& poses) {
  const fs::path file{stamps_file(layout, poses)};
  bool known{!file.empty()};
  if (file.filename() == "times.txt") {
    take_stamps(contents, read_times(file, contents.frames.size()));
  } else if (file.filename() == "timestamps.txt") {
    known = take_numbered_stamps(contents, read_timestamps(file));
  } else if (known) {
    known = take_stamps(contents, read_poses_csv(file));
  }
  if (!known) {
    for (std::size_t i{0}; i < contents.frames.size(); ++i) {
      contents.frames[i].stamp_ns = static_cast<std::int64_t>(i) * 100'000'000;
    }
    if (contents.frames.size() > 1) contents.notes.push_back("stamps: none, 10 frames a second assumed");
    return false;
  }
  contents.notes.push_back("stamps: " + printable_path(file));
  for (std::size_t i{1}; i < contents.frames.size(); ++i) {
    if (contents.frames[i].stamp_ns > contents.frames[i - 1].stamp_ns) continue;
    throw InputError{
        printable_path(file),
        fmt::format("frame {} is not later than frame {}.", contents.frames[i].name, contents.frames[i - 1].name),
        "Frames are taken in the order of their names; their stamps have to grow."};
  }
  warn_of_rate(contents, file);
  return true;
}

RecordingContents look_at(const InputArguments& arguments) {
  if (arguments.depth && arguments.disparities) {
    throw ConfigError{"--depth and --disparities are given: one of them takes the place of the right images."};
  }
  const InputLayout layout{recognise(arguments.paths, arguments.depth ? arguments.depth : arguments.disparities)};
  RecordingContents contents;
  contents.kind = name_of(layout.kind);
  contents.root = layout.root;
  contents.disparities = layout.disparities;
  contents.has_depth =
      arguments.depth.has_value() || (!arguments.disparities && layout.disparities.filename() == "depth");
  contents.depth_units_per_m = arguments.depth_units_per_m;
  if (!layout.disparities.empty()) {
    contents.external = (contents.has_depth ? "depth: " : "") + printable_path(layout.disparities);
  }
  contents.frames = find_frames(layout);
  note_disparities(contents);
  warn_of_missing_images(contents);
  const Size size{look_at_images(contents)};
  find_calibration(contents, layout, arguments, size);
  find_mask(contents, arguments);
  const bool stamps_known{find_stamps(contents, layout, arguments.poses)};
  find_poses_of(contents, layout, arguments.poses, stamps_known);
  if (fs::is_directory(layout.root / "truth") && layout.kind == InputKind::plain_folder) {
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
    find_calibration(contents, layout, arguments, {found.width_px, found.height_px});
  } else {
    contents.calibration = std::move(found.calibration).value();
    note_calibration(contents, found.root);
  }
  find_mask(contents, arguments);
  warn_of_rate(contents, found.root);
  const bool are_own{found.poses.size() > 1 && (arguments.poses.empty() || arguments.poses == "file")};
  if (are_own) {
    take_own_poses(contents, found.root, found.poses);
  } else {
    find_poses_of(contents, layout, arguments.poses, true);
  }
  return contents;
}

}  // namespace

std::unique_ptr<Recording> open_recording(const InputArguments& arguments, ForeignRecording found) {
  if (arguments.disparities || arguments.depth) {
    throw ConfigError{"--disparities and --depth belong to images in files, by their names; this input has none."};
  }
  return std::make_unique<Recording>(look_at(arguments, found), std::move(found.images));
}

std::unique_ptr<Recording> open_recording(const InputArguments& arguments) {
  try {
    return std::make_unique<Recording>(look_at(arguments));
  } catch (const fs::filesystem_error& error) {  // a folder on the way that may not be entered
    throw InputError{printable_path(error.path1()), "cannot be read (" + error.code().message() + ").",
                     "Check its permissions and those of the folders above it."};
  }
}

}  // namespace stereogrid::io
