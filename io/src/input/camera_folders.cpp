// SPDX-License-Identifier: Apache-2.0
#include "input/camera_folders.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <utility>

#include "input/calibration/yaml_group.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {

namespace fs = std::filesystem;

namespace {

/// Name of the camera of a folder (PipelineOptions::camera_names).
std::string camera_name(const fs::path& folder) {
  std::string name{folder.filename().string()};
  std::ranges::replace_if(
      name, [](unsigned char letter) { return letter > 127 || std::isalnum(letter) == 0; }, '_');
  return name.empty() || std::isalpha(static_cast<unsigned char>(name.front())) == 0 ? "camera" + name : name;
}

/// Names of the folders' cameras, numbered where they would be equal.
std::vector<std::string> camera_names(const std::vector<fs::path>& folders) {
  std::vector<std::string> names;
  for (const fs::path& folder : folders) {
    std::string name{camera_name(folder)};
    while (std::ranges::count(names, name) > 0) name += "_" + std::to_string(names.size());
    names.push_back(std::move(name));
  }
  return names;
}

}  // namespace

std::vector<fs::path> cameras_in(const InputArguments& arguments) {
  if (arguments.paths.size() != 1) return {};
  const fs::path file{arguments.paths.front() / "calibration.yaml"};
  try {
    if (!is_there(file)) return {};
  } catch (const InputError&) {  // named where the folder is looked at
    return {};
  }
  const YamlGroup root{read_yaml(file)};
  if (!root.has_list("cameras")) return {};
  root.need_only({"cameras"});
  std::vector<fs::path> folders{root.file_names("cameras")};
  if (folders.empty() || folders.size() > 8)
    root.fail(fmt::format("lists {} folders in 'cameras'; 1 to 8 are possible.", folders.size()));
  for (fs::path& folder : folders) folder = (arguments.paths.front() / folder / "").lexically_normal().parent_path();
  for (const fs::path& folder : folders) {
    if (std::ranges::count(folders, folder) > 1)
      root.fail(fmt::format("lists {} twice in 'cameras'.", printable_path(folder)));
  }
  return folders;
}

std::unique_ptr<Recording> open_cameras(InputArguments arguments, const std::vector<fs::path>& folders) {
  if (arguments.calibration || arguments.disparities || arguments.depth || arguments.mask || arguments.labels) {
    throw ConfigError{
        "--calibration, --disparities, --depth, --mask and --labels are of one camera: put the files "
        "into the cameras' folders."};
  }
  const fs::path poses{arguments.paths.front() / "poses.csv"};
  if (arguments.poses.empty() && is_there(poses)) arguments.poses = poses.string();
  const std::vector<std::string> names{camera_names(folders)};
  std::unique_ptr<Recording> all;
  for (std::size_t i{0}; i < folders.size(); ++i) {
    const fs::path& folder{folders[i]};
    arguments.paths = {folder};
    if (!cameras_in(arguments).empty()) {
      throw InputError{printable_path(folder), "lists cameras itself.",
                       "Name the folders of all stereo pairs in one calibration.yaml."};
    }
    arguments.calibration.reset();
    if (const fs::path file{folder / "calibration.yaml"}; is_there(file)) arguments.calibration = file;
    std::unique_ptr<Recording> camera{open_recording(arguments)};
    if (folders.size() > 1 && !camera->contents().calibration.has_extrinsics &&
        camera_place(camera->rig()) == Pose2{}) {
      throw InputError{printable_path(camera->contents().calibration_file),
                       "has no mount: where this camera is in the vehicle is unknown.",
                       "Give calibration.yaml with mount: {camera_x_m, camera_y_m, camera_yaw_rad, camera_height_m}; "
                       "'from' names another calibration."};
    }
    if (folders.size() > 1) camera->set_camera_name(names[i]);
    all ? all->add_camera(std::move(camera)) : void(all = std::move(camera));
  }
  return all;
}

}  // namespace stereogrid::io
