// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "input/poses/recording_poses.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>

#include "stereogrid/error.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/poses.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

namespace fs = std::filesystem;

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

/// By the list of a EuRoC folder, else as the frames' names are. False: not all have some.
bool take_own_stamps(RecordingContents& contents, const InputLayout& layout) {
  const fs::path list{layout.left.parent_path() / "data.csv"};
  std::map<std::string, std::int64_t> listed;
  if (layout.kind == InputKind::euroc && is_there(list)) listed = read_euroc_stamps(list);
  for (RecordedFrame& frame : contents.frames) {
    const auto found{listed.find(frame.name)};
    const auto stamp_ns{found == listed.end() ? stamp_in(frame.name) : std::optional{found->second}};
    if (!stamp_ns) return false;
    frame.stamp_ns = *stamp_ns;
  }
  contents.notes.emplace_back(listed.empty() ? "stamps: the names of the images" : "stamps: " + printable_path(list));
  return true;
}

fs::path stamps_file(const InputLayout& layout, const std::string& poses) {
  std::vector<fs::path> candidates{layout.root / "times.txt", layout.root / "poses.csv"};
  if (layout.kind == InputKind::plain_folder) std::ranges::reverse(candidates);
  if (layout.kind == InputKind::kitti_raw) candidates = {layout.left.parent_path() / "timestamps.txt"};
  if (layout.kind == InputKind::image_pair) candidates.clear();
  if (fs::path{poses}.extension() == ".csv") candidates.emplace_back(poses);
  const auto gives_stamps = [](const fs::path& path) {
    return is_there(path) && (path.extension() != ".csv" || are_named(read_poses_csv(path)));
  };
  const auto found{std::ranges::find_if(candidates, gives_stamps)};
  return found == candidates.end() ? fs::path{} : *found;
}

void check_stamps_grow(const RecordingContents& contents, const fs::path& file) {
  for (std::size_t i{1}; i < contents.frames.size(); ++i) {
    if (contents.frames[i].stamp_ns > contents.frames[i - 1].stamp_ns) continue;
    throw InputError{
        printable_path(file),
        fmt::format("frame {} is not later than frame {}.", contents.frames[i].name, contents.frames[i - 1].name),
        "Frames are taken in the order of their names; their stamps have to grow."};
  }
}

}  // namespace

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
  if (!known && take_own_stamps(contents, layout)) {
    check_stamps_grow(contents, layout.left);
    return true;
  }
  if (!known) {
    for (std::size_t i{0}; i < contents.frames.size(); ++i) {
      contents.frames[i].stamp_ns = static_cast<std::int64_t>(i) * 100'000'000;
    }
    if (contents.frames.size() > 1) contents.notes.push_back("stamps: none, 10 frames a second assumed");
    return false;
  }
  contents.notes.push_back("stamps: " + printable_path(file));
  check_stamps_grow(contents, file);
  warn_of_rate(contents, file);
  return true;
}

}  // namespace stereogrid::io
