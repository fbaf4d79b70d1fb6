// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <exception>
#include <optional>
#include <utility>

#include "input/calibration/yaml_group.hpp"
#include "input/layout/input_layout.hpp"
#include "input/recording_images.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {

namespace fs = std::filesystem;

void check_cameras(std::span<const std::string> cameras) {
  constexpr std::size_t most_cameras{8};
  if (cameras.empty() || cameras.size() > most_cameras)
    throw ConfigError{fmt::format("cameras: {} stereo pairs (allowed 1 to {}).", cameras.size(), most_cameras)};
  for (const std::string& camera : cameras) {
    if (camera.empty()) throw ConfigError{"cameras: an entry is empty (allowed: a folder or namespace)."};
    if (std::ranges::count(cameras, camera) > 1)
      throw ConfigError{fmt::format("cameras: lists {} twice.", printable(camera))};
  }
}

std::vector<std::string> camera_names(std::span<const std::string> cameras) {
  std::vector<std::string> names;
  for (const std::string& camera : cameras) {
    std::string name{fs::path{camera}.filename().string()};
    std::ranges::replace_if(
        name, [](unsigned char letter) { return letter > 127 || std::isalnum(letter) == 0; }, '_');
    if (name.empty() || std::isalpha(static_cast<unsigned char>(name.front())) == 0) name.insert(0, "camera");
    while (std::ranges::count(names, name) > 0) name += "_" + std::to_string(names.size());
    names.push_back(std::move(name));
  }
  return names;
}

std::unique_ptr<Recording> open_cameras(std::span<const std::string> cameras, const OpenCamera& open) {
  check_cameras(cameras);
  if (cameras.size() == 1) return open(cameras.front());
  const std::vector<std::string> names{camera_names(cameras)};
  const auto open_one = [&](std::size_t i) {
    try {
      return open(cameras[i]);
    } catch (const InputError& error) {
      const std::string text{error.what()};
      if (text.find(cameras[i]) != std::string::npos) throw;
      throw InputError{names[i] + ": " + text};
    }
  };
  std::unique_ptr<Recording> all{open_one(0)};
  all->set_camera_name(names.front());
  for (std::size_t i{1}; i < cameras.size(); ++i) {
    std::unique_ptr<Recording> camera{open_one(i)};
    camera->set_camera_name(names[i]);
    all->add_camera(std::move(camera));
  }
  return all;
}

namespace {

std::vector<std::string> normalised(const fs::path& root, const std::vector<fs::path>& folders) {
  std::vector<std::string> names;
  for (const fs::path& folder : folders)
    names.push_back((root / folder / "").lexically_normal().parent_path().string());
  return names;
}

/// 'cameras' of calibration.yaml; empty: another input.
std::vector<std::string> listed_cameras(const fs::path& folder) {
  fs::path file;
  try {
    file = own_calibration_in(folder);
  } catch (const InputError&) {  // named where the folder is looked at
    return {};
  }
  if (file.empty()) return {};
  const YamlGroup root{read_yaml(file)};
  if (!root.has_list("cameras")) return {};
  root.need_only({"cameras"});
  const std::vector<std::string> folders{normalised(folder, root.file_names("cameras"))};
  try {
    check_cameras(folders);
  } catch (const ConfigError& error) {
    root.fail(error.what());
  }
  return folders;
}

std::unique_ptr<Recording> open_camera(InputArguments arguments, const fs::path& folder, bool is_alone) {
  arguments.paths = {folder};
  if (!listed_cameras(folder).empty()) {
    throw InputError{printable_path(folder), "lists cameras itself.",
                     "Name the folders of all stereo pairs in one calibration.yaml."};
  }
  if (const fs::path file{own_calibration_in(folder)}; !file.empty()) arguments.calibration = file;
  std::unique_ptr<Recording> camera{open_recording(arguments)};
  if (!is_alone && !camera->contents().calibration.has_extrinsics && camera_place(camera->rig()) == Pose2{}) {
    throw InputError{printable_path(camera->contents().calibration_file),
                     "has no mount: where this camera is in the vehicle is unknown.",
                     "Give calibration.yaml with mount: {camera_x_m, camera_y_m, camera_yaw_rad, camera_height_m}; "
                     "'from' names another calibration."};
  }
  return camera;
}

}  // namespace

std::unique_ptr<Recording> open_camera_folders(InputArguments arguments) {
  if (arguments.paths.size() != 1) {
    if (!arguments.cameras.empty()) throw ConfigError{"cameras: are folders in one folder, INPUT."};
    return nullptr;
  }
  const fs::path root{arguments.paths.front()};
  const std::vector<std::string> asked{std::exchange(arguments.cameras, {})};
  if (!asked.empty()) check_cameras(asked);
  const std::vector<std::string> folders{asked.empty() ? listed_cameras(root)
                                                       : normalised(root, {asked.begin(), asked.end()})};
  if (folders.empty()) return nullptr;
  if (arguments.calibration || arguments.disparities || arguments.depth || arguments.mask || arguments.labels) {
    throw ConfigError{
        "--calibration, --disparities, --depth, --mask and --labels are of one camera: put the files "
        "into the cameras' folders."};
  }
  const fs::path poses{root / "poses.csv"};
  if (arguments.poses.empty() && is_there(poses)) arguments.poses = poses.string();
  return open_cameras(folders,
                      [&](const std::string& folder) { return open_camera(arguments, folder, folders.size() == 1); });
}

namespace {

/// The frame nearest in time, within half of its interval; none: there is none.
std::optional<std::size_t> frame_at(const std::vector<RecordedFrame>& frames, std::int64_t stamp_ns) {
  if (frames.empty()) return std::nullopt;
  const auto after{std::ranges::lower_bound(frames, stamp_ns, {}, &RecordedFrame::stamp_ns)};
  const auto away{[&](auto frame) { return std::abs(frame->stamp_ns - stamp_ns); }};
  const bool is_before{after == frames.end() || (after != frames.begin() && away(after - 1) < away(after))};
  const auto nearest{is_before ? after - 1 : after};
  const auto first{nearest == frames.begin() ? nearest : nearest - 1};
  const auto next{first + 1 == frames.end() ? first : first + 1};
  if (first != next && 2 * away(nearest) > next->stamp_ns - first->stamp_ns) return std::nullopt;
  return static_cast<std::size_t>(nearest - frames.begin());
}

/// Index of the frame of `frames` that belongs to frame `index` of the first camera; none: there is none. A frame of a
/// slower camera belongs to the nearer one of two frames only.
std::optional<std::size_t> partner_of(const std::vector<RecordedFrame>& first, std::size_t index,
                                      const std::vector<RecordedFrame>& frames) {
  const std::optional<std::size_t> nearest{frame_at(frames, first[index].stamp_ns)};
  if (!nearest) return std::nullopt;
  const auto away_ns = [&](std::size_t one) { return std::abs(first[one].stamp_ns - frames[*nearest].stamp_ns); };
  const bool has_before{index > 0 && frame_at(frames, first[index - 1].stamp_ns) == nearest};
  const bool has_after{index + 1 < first.size() && frame_at(frames, first[index + 1].stamp_ns) == nearest};
  if ((has_before && away_ns(index - 1) <= away_ns(index)) || (has_after && away_ns(index + 1) < away_ns(index)))
    return std::nullopt;
  return nearest;
}

/// Warns of a camera with few frames beside those of the first one, or with missing images.
void warn_of_frames(const Recording& camera, RecordingContents& contents) {
  const std::vector<RecordedFrame>& frames{camera.contents().frames};
  std::size_t partners{0};
  std::size_t incomplete{0};
  for (std::size_t i{0}; i < contents.frames.size(); ++i) {
    const auto partner{partner_of(contents.frames, i, frames)};
    if (!partner) continue;
    ++partners;
    incomplete += frames[*partner].left_exists && frames[*partner].right_exists ? 0U : 1U;
  }
  const std::string name{fmt::format("{}, {}", camera.contents().camera_name, printable_path(camera.contents().root))};
  if (2 * partners < contents.frames.size()) {
    contents.warnings.push_back(
        fmt::format("{}: {} of {} frames of the first camera have a frame of it within half an interval. It observes "
                    "nothing in the "
                    "others: check that the cameras have one clock.",
                    name, partners, contents.frames.size()));
  } else if (2 * partners < frames.size()) {
    contents.warnings.push_back(fmt::format(
        "{}: {} of {} frames are used, as the first camera has fewer. List the camera with the most frames first.",
        name, partners, frames.size()));
  }
  if (incomplete > 0) {
    contents.warnings.push_back(fmt::format("{}: an image is missing in {} of {} frames. It observes nothing there.",
                                            name, incomplete, partners));
  }
}

}  // namespace

void Recording::add_camera(std::unique_ptr<Recording> camera) {
  if (rigs_.empty()) rigs_.push_back(rig());
  const auto add = [&camera](const std::vector<std::string>& texts, std::vector<std::string>& to) {
    for (const std::string& text : texts) {
      if (std::ranges::count(to, text) == 0)  // else one of the poses or the whole bag
        to.push_back(camera->contents().camera_name + ": " + text);
    }
  };
  add(camera->contents().notes, contents_.notes);
  add(camera->contents().warnings, contents_.warnings);
  warn_of_frames(*camera, contents_);
  rigs_.push_back(camera->rig());
  others_.push_back(std::move(camera));
}

StereoFrame Recording::load(std::size_t index) const {
  const RecordedFrame& listed{contents_.frames.at(index)};
  StereoFrame frame;
  std::exception_ptr failure;
  try {
    frame = load_own(index);
  } catch (const InputError& error) {
    failure = std::current_exception();
    frame.name = listed.name;
    frame.index = static_cast<std::int64_t>(index);
    frame.stamp_ns = listed.stamp_ns;
    frame.world_from_vehicle = listed.world_from_vehicle;
    frame.fault =
        fmt::format("{}: no usable images; the other cameras are used ({})", contents_.camera_name, error.what());
  }
  for (std::size_t i{0}; i < others_.size(); ++i) {
    const std::vector<RecordedFrame>& listed_others{others_[i]->contents().frames};
    const auto partner{partner_of(contents_.frames, index, listed_others)};
    if (!partner) continue;
    try {
      StereoFrame other{others_[i]->load_own(*partner)};
      other.camera = static_cast<int>(i + 1);
      frame.others.push_back(std::move(other));
    } catch (const InputError& error) {
      if (!frame.fault.empty()) frame.fault += "; ";
      frame.fault += fmt::format("{}: no usable images; it observes nothing ({})", others_[i]->contents().camera_name,
                                 error.what());
    }
  }
  if (failure && frame.others.empty()) std::rethrow_exception(failure);
  return frame;
}

}  // namespace stereogrid::io
