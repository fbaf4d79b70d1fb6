// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "input/recording_poses.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "stereogrid/error.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> names_of(const RecordingContents& contents) {
  std::vector<std::string> names;
  for (const RecordedFrame& frame : contents.frames) names.push_back(frame.name);
  return names;
}

std::vector<std::int64_t> stamps_of(const RecordingContents& contents) {
  std::vector<std::int64_t> stamps;
  for (const RecordedFrame& frame : contents.frames) stamps.push_back(frame.stamp_ns);
  return stamps;
}

void take_poses(RecordingContents& contents, const std::vector<Pose2>& poses) {
  for (std::size_t i{0}; i < poses.size(); ++i) contents.frames[i].world_from_vehicle = poses[i];
}

void take_stamped_poses(RecordingContents& contents, const fs::path& file, const std::vector<NamedPose>& rows,
                        bool stamps_known) {
  if (!stamps_known) {
    throw InputError{printable_path(file), "its poses have stamps and no names, but the images have no stamps.",
                     "Add a times.txt with the images' times (s), or a column 'name' that says whose the poses are."};
  }
  std::vector<StampedPose> poses;
  for (const NamedPose& row : rows) poses.push_back({row.stamp_ns, row.world_from_vehicle});
  take_poses(contents, interpolate_poses(file, poses, stamps_of(contents)));
  contents.notes.push_back(fmt::format("poses: {}, interpolated to the times of the images", printable_path(file)));
}

void take_named_poses(RecordingContents& contents, const fs::path& file, const std::vector<NamedPose>& rows) {
  std::map<std::string, Pose2> poses;
  for (const NamedPose& row : rows) poses[row.name] = row.world_from_vehicle;
  for (RecordedFrame& frame : contents.frames) {
    const auto found{poses.find(frame.name)};
    if (found == poses.end()) {
      throw InputError{printable_path(file),
                       fmt::format("has {} poses, but there are {} frames: frame {} has none.", rows.size(),
                                   contents.frames.size(), frame.name),
                       "Add a line for it; leave the column 'name' out where poses have times of their own; or run "
                       "with --poses none."};
    }
    frame.world_from_vehicle = found->second;
  }
  if (rows.size() > contents.frames.size()) {
    contents.warnings.push_back(fmt::format("{}: {} poses, but there are {} frames: the others are not used",
                                            printable_path(file), rows.size(), contents.frames.size()));
  }
  contents.notes.push_back("poses: " + printable_path(file));
}

/// Records have times of their own where both they and the images are stamped; else they go by name.
void take_oxts(RecordingContents& contents, const fs::path& folder, const fs::path& calibration_folder,
               bool stamps_known) {
  const OxtsTimes times{stamps_known ? read_oxts_times(folder) : OxtsTimes{}};
  const bool timed{!times.names.empty()};
  OxtsPoses poses{read_oxts(folder, timed ? times.names : names_of(contents), calibration_folder)};
  if (timed) {
    std::vector<StampedPose> stamped;
    for (std::size_t i{0}; i < times.names.size(); ++i) {
      stamped.push_back({times.stamps_ns[i], poses.world_from_vehicle[i]});
    }
    poses.world_from_vehicle = interpolate_poses(folder, stamped, stamps_of(contents));
  }
  take_poses(contents, poses.world_from_vehicle);
  contents.notes.push_back(fmt::format("poses: {} (GPS/IMU{}{})", printable_path(folder),
                                       timed ? ", interpolated to the times of the images" : "",
                                       poses.of_camera ? ", moved to the left camera"
                                                       : "; of the IMU, since calib_imu_to_velo.txt, "
                                                         "calib_velo_to_cam.txt or calib_cam_to_cam.txt is missing"));
}

/// The file or oxts folder of poses; empty: none. Notes what was passed over.
fs::path choose_poses(RecordingContents& contents, const InputLayout& layout, const std::string& wanted) {
  if (wanted == "none" || wanted == "odometry") return {};
  if (!wanted.empty() && wanted != "file") return wanted;
  if (layout.kind == InputKind::image_pair) return {};
  if (const auto choice{find_poses(layout.root)}) {
    std::string others;
    for (const fs::path& other : choice->others) others += fmt::format(" {}", printable_path(other.filename()));
    if (!others.empty()) contents.notes.push_back(fmt::format("poses: not taken:{} (--poses FILE takes them)", others));
    return choice->file;
  }
  if (fs::is_directory(layout.root / "oxts" / "data")) return layout.root / "oxts" / "data";
  // as KITTI's odometry benchmark is unpacked: sequences/04 and poses/04.txt
  const fs::path root{fs::absolute(layout.root / "").lexically_normal().parent_path()};
  const fs::path benchmark{root.parent_path().parent_path() / "poses" / (root.filename().string() + ".txt")};
  const bool there{layout.kind == InputKind::kitti_odometry && fs::is_regular_file(benchmark)};
  return there ? benchmark : fs::path{};
}

void do_without_poses(RecordingContents& contents, const std::string& wanted) {
  if (wanted == "file") {
    throw InputError{printable_path(contents.root.empty() ? contents.frames.front().left : contents.root),
                     "there are no poses.",
                     "Put a pose file there (docs/input.md), name one with --poses FILE, or take --poses odometry."};
  }
  contents.wants_odometry = wanted == "odometry" || (wanted.empty() && contents.frames.size() > 1);
  contents.notes.emplace_back(!contents.wants_odometry ? "poses: none, the camera is taken to stand still"
                              : wanted.empty()         ? "poses: none, visual odometry from the images"
                                                       : "poses: visual odometry from the images");
}

}  // namespace

bool are_named(const std::vector<NamedPose>& rows) {
  return !rows.empty() && !rows.front().name.empty();
}

void find_poses_of(RecordingContents& contents, const InputLayout& layout, const std::string& wanted,
                   bool stamps_known) {
  const fs::path file{choose_poses(contents, layout, wanted)};
  contents.poses_file = file;
  if (file.empty()) return do_without_poses(contents, wanted);
  if (fs::is_directory(file)) {
    const fs::path& calibration{layout.calibration.empty() ? contents.calibration_file : layout.calibration};
    return take_oxts(contents, file, calibration.parent_path(), stamps_known);
  }
  if (file.extension() == ".csv") {
    const std::vector<NamedPose> rows{read_poses_csv(file)};
    const bool named{rows.empty() || are_named(rows)};
    return named ? take_named_poses(contents, file, rows) : take_stamped_poses(contents, file, rows, stamps_known);
  }
  take_poses(contents, read_kitti_poses(file, contents.frames.size()));
  contents.notes.push_back("poses: " + printable_path(file));
}

void take_own_poses(RecordingContents& contents, const fs::path& file, const std::string& source,
                    const std::vector<StampedPose>& poses) {
  contents.poses_file = file;
  take_poses(contents, interpolate_poses(file, poses, stamps_of(contents)));
  contents.notes.push_back(fmt::format("poses: {}, interpolated to the times of the images", source));
}

}  // namespace stereogrid::io
