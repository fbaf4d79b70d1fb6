// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
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

}  // namespace stereogrid::io
