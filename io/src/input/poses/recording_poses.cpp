// SPDX-License-Identifier: Apache-2.0
#include "input/poses/recording_poses.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>

#include "input/calibration/yaml_group.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/paths.hpp"
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

/// The longest time between two poses that is interpolated; the poses' usual interval is their median.
std::int64_t longest_bridged_ns(const std::vector<StampedPose>& poses) {
  constexpr std::int64_t least_ns{1'000'000'000};
  std::vector<std::int64_t> intervals;
  for (std::size_t i{1}; i < poses.size(); ++i) intervals.push_back(poses[i].stamp_ns - poses[i - 1].stamp_ns);
  const auto middle{intervals.begin() + static_cast<std::ptrdiff_t>((intervals.size() - 1) / 2)};
  std::ranges::nth_element(intervals, middle);
  return std::max(least_ns, 3 * std::min(*middle, std::numeric_limits<std::int64_t>::max() / 3));
}

/// Images before the first and after the last pose get none where they are fewer than half, with a warning.
void apply_poses_within(RecordingContents& contents, const fs::path& source, const std::vector<StampedPose>& poses) {
  std::vector<RecordedFrame*> within;
  if (poses.size() >= 2) {
    const std::int64_t reach_ns{usual_interval_ns(poses)};
    for (RecordedFrame& frame : contents.frames) {
      if (frame.stamp_ns < poses.front().stamp_ns - reach_ns || frame.stamp_ns > poses.back().stamp_ns + reach_ns)
        continue;
      within.push_back(&frame);
    }
  }
  const std::size_t outside{contents.frames.size() - within.size()};
  if (outside == 0 || 2 * outside >= contents.frames.size()) {
    return take_poses(contents, interpolate_poses(source, poses, stamps_of(contents)));
  }
  std::vector<std::int64_t> stamps;
  for (const RecordedFrame* frame : within) stamps.push_back(frame->stamp_ns);
  const std::vector<Pose2> found{interpolate_poses(source, poses, stamps)};
  for (std::size_t i{0}; i < within.size(); ++i) within[i]->world_from_vehicle = found[i];
  contents.warnings.push_back(
      fmt::format("{}: {} of {} images have no pose: they are from before the first or after the "
                  "last one. Poses of all images give better grids.",
                  printable_path(source), outside, contents.frames.size()));
}

/// Gives each image its pose between two of `poses`; images in long gaps get none, and are counted in a warning.
void apply_interpolated(RecordingContents& contents, const fs::path& source, const std::vector<StampedPose>& poses) {
  apply_poses_within(contents, source, poses);
  const std::int64_t longest_ns{longest_bridged_ns(poses)};
  std::size_t count{0};
  std::int64_t longest_gap_ns{0};
  for (RecordedFrame& frame : contents.frames) {
    const auto after{std::ranges::lower_bound(poses, frame.stamp_ns, {}, &StampedPose::stamp_ns)};
    if (!frame.world_from_vehicle || after == poses.begin() || after == poses.end() ||
        after->stamp_ns == frame.stamp_ns)
      continue;
    const std::int64_t gap_ns{after->stamp_ns - std::prev(after)->stamp_ns};
    if (gap_ns <= longest_ns) continue;
    frame.world_from_vehicle.reset();
    ++count;
    longest_gap_ns = std::max(longest_gap_ns, gap_ns);
  }
  if (count == 0) return;
  contents.warnings.push_back(fmt::format(
      "{}: {} of {} images have no pose: they lie in gaps of up to {:.3g} s between the poses (interpolated "
      "up to {:.3g} s). The last motion is continued there; give --poses odometry instead.",
      printable_path(source), count, contents.frames.size(), static_cast<double>(longest_gap_ns) * 1e-9,
      static_cast<double>(longest_ns) * 1e-9));
}

void take_stamped_poses(RecordingContents& contents, const fs::path& file, const std::vector<NamedPose>& rows,
                        bool stamps_known) {
  if (!stamps_known) {
    throw InputError{printable_path(file), "its poses have stamps and no names, but the images have no stamps.",
                     "Add a times.txt with the images' times (s), or a column 'name' that says whose the poses are."};
  }
  std::vector<double> stamps;
  for (const NamedPose& row : rows) stamps.push_back(static_cast<double>(row.stamp_ns));
  const StampUnit unit{stamp_unit(stamps, stamp_units.front(), printable_path(file))};
  if (!unit.note.empty()) contents.notes.push_back(printable_path(file) + ": " + unit.note);
  std::vector<StampedPose> poses;
  for (const NamedPose& row : rows) poses.push_back({row.stamp_ns * unit.ns, row.world_from_vehicle});
  apply_interpolated(contents, file, poses);
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
    apply_interpolated(contents, folder, stamped);
  } else {
    take_poses(contents, poses.world_from_vehicle);
  }
  contents.notes.push_back(fmt::format("poses: {} (GPS/IMU{}{})", printable_path(folder),
                                       timed ? ", interpolated to the times of the images" : "",
                                       poses.of_camera ? ", moved to the left camera"
                                                       : "; of the IMU, since calib_imu_to_velo.txt, "
                                                         "calib_velo_to_cam.txt or calib_cam_to_cam.txt is missing"));
}

/// T_BS of the left camera of a EuRoC folder; none: not there.
std::optional<Transform> body_from_camera(const InputLayout& layout) {
  const fs::path file{layout.left.parent_path() / "sensor.yaml"};
  if (layout.kind != InputKind::euroc || !is_file(file)) return std::nullopt;
  const YamlGroup sensor{read_yaml(file)};
  const std::vector<double> numbers{sensor.matrix("T_BS", 4, 4)};
  Transform transform{};
  std::copy_n(numbers.begin(), transform.size(), transform.begin());
  return transform;
}

/// Poses with the numbers of their frames: those of images that have none stay empty, and are counted in a warning.
void apply_numbered(RecordingContents& contents, const fs::path& file, const Trajectory& trajectory) {
  std::map<std::int64_t, Pose2> poses;
  for (std::size_t i{0}; i < trajectory.frames.size(); ++i) {
    poses[trajectory.frames[i]] = trajectory.poses[i].world_from_vehicle;
  }
  std::size_t missing{0};
  for (RecordedFrame& frame : contents.frames) {
    std::int64_t number{-1};
    std::from_chars(frame.name.data(), frame.name.data() + frame.name.size(), number);
    const auto found{poses.find(number)};
    if (found == poses.end()) {
      ++missing;
    } else {
      frame.world_from_vehicle = found->second;
    }
  }
  if (missing == contents.frames.size()) {
    throw InputError{printable_path(file), "has no pose for any of the frames.", "Name the poses of this drive."};
  }
  if (missing > 0) {
    contents.warnings.push_back(
        fmt::format("{}: {} of {} images have no pose", printable_path(file), missing, contents.frames.size()));
  }
  contents.notes.push_back("poses: " + printable_path(file));
}

/// Poses with stamps are interpolated where the images have some, too, else a line belongs to each image.
void apply_trajectory(RecordingContents& contents, const InputLayout& layout, const fs::path& file, bool stamps_known) {
  const Trajectory trajectory{read_trajectory(file, body_from_camera(layout))};
  const std::vector<StampedPose>& poses{trajectory.poses};
  if (!trajectory.note.empty()) contents.notes.push_back(printable_path(file) + ": " + trajectory.note);
  if (trajectory.are_of_body) {
    contents.notes.emplace_back(
        "poses: taken as a body's, x ahead and z up, since they move along x; a camera's have z ahead");
  }
  if (!trajectory.frames.empty()) return apply_numbered(contents, file, trajectory);
  const bool is_single{poses.size() == 1 && contents.frames.size() == 1};
  if (stamps_known && trajectory.have_stamps && !is_single) {
    apply_interpolated(contents, file, poses);
    contents.notes.push_back(fmt::format("poses: {}, interpolated to the times of the images", printable_path(file)));
    return;
  }
  if (poses.size() != contents.frames.size()) {
    throw InputError{printable_path(file),
                     fmt::format("has {} poses{}, but the {} images have {}.", poses.size(),
                                 trajectory.have_stamps ? " with stamps" : "", contents.frames.size(),
                                 trajectory.have_stamps ? "no stamps" : "to have one each"),
                     "Add a times.txt with the images' times (s), or give a pose for each image."};
  }
  for (std::size_t i{0}; i < poses.size(); ++i) {
    if (trajectory.have_stamps && !stamps_known) contents.frames[i].stamp_ns = poses[i].stamp_ns;
    contents.frames[i].world_from_vehicle = poses[i].world_from_vehicle;
  }
  contents.notes.push_back(fmt::format("poses: {}{}, in their order", printable_path(file),
                                       trajectory.have_stamps && !stamps_known ? ", and the images' stamps" : ""));
}

/// The file or oxts folder of poses; empty: none. Notes ignored ones.
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
  if (is_folder(layout.root / "oxts" / "data")) return layout.root / "oxts" / "data";
  if (layout.kind == InputKind::euroc) {
    const fs::path base{layout.left.parent_path().parent_path()};
    for (const char* const truth : {"state_groundtruth_estimate0", "mocap0"}) {
      if (is_file(base / truth / "data.csv")) return base / truth / "data.csv";
    }
  }
  // as KITTI's odometry benchmark is unpacked: sequences/04 and poses/04.txt
  const fs::path root{fs::absolute(layout.root / "").lexically_normal().parent_path()};
  const fs::path kitti_360{root.parent_path().parent_path() / "data_poses" / root.filename() / "cam0_to_world.txt"};
  if (layout.kind == InputKind::kitti_raw && is_file(kitti_360)) return kitti_360;
  const fs::path benchmark{root.parent_path().parent_path() / "poses" / (root.filename().string() + ".txt")};
  const bool there{layout.kind == InputKind::kitti_odometry && is_file(benchmark)};
  return there ? benchmark : fs::path{};
}

void do_without_poses(RecordingContents& contents, const std::string& wanted) {
  const std::string& why{contents.poses_source};
  if (wanted == "file") {
    throw InputError{printable_path(contents.root),
                     why.empty() ? "there are no poses." : fmt::format("there are no poses to be used: {}.", why),
                     "Name a pose file with --poses FILE (docs/input.md), or take --poses odometry."};
  }
  contents.wants_odometry = wanted == "odometry" || (wanted.empty() && contents.frames.size() > 1);
  contents.notes.push_back(fmt::format("poses: {}{}",
                                       !contents.wants_odometry ? "none, the camera is taken to stand still"
                                       : wanted.empty()         ? "none, visual odometry from the images"
                                                                : "visual odometry from the images",
                                       why.empty() ? "" : fmt::format(" ({})", why)));
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
  if (is_folder(file)) {
    const fs::path& calibration{layout.calibration.empty() ? contents.calibration_file : layout.calibration};
    return take_oxts(contents, file, calibration.parent_path(), stamps_known);
  }
  if (is_trajectory(file)) return apply_trajectory(contents, layout, file, stamps_known);
  if (file.extension() == ".csv") {
    const std::vector<NamedPose> rows{read_poses_csv(file)};
    const bool named{rows.empty() || are_named(rows)};
    return named ? take_named_poses(contents, file, rows) : take_stamped_poses(contents, file, rows, stamps_known);
  }
  take_poses(contents, read_kitti_poses(file, contents.frames.size()));
  contents.notes.push_back("poses: " + printable_path(file));
}

void warn_of_speed(RecordingContents& contents) {
  constexpr double fastest_mps{150};
  constexpr double step_min_s{5e-3};  // shorter ones are hardly a camera's
  std::vector<double> speeds_mps;
  for (std::size_t i{1}; i < contents.frames.size(); ++i) {
    const RecordedFrame& from{contents.frames[i - 1]};
    const RecordedFrame& to{contents.frames[i]};
    const double dt_s{static_cast<double>(to.stamp_ns - from.stamp_ns) * 1e-9};
    if (!from.world_from_vehicle || !to.world_from_vehicle || !(dt_s >= step_min_s)) continue;
    const Pose2 step{inverse(*from.world_from_vehicle) * *to.world_from_vehicle};
    speeds_mps.push_back(std::hypot(step.x_m, step.y_m) / dt_s);
  }
  if (speeds_mps.empty()) return;
  const auto middle{speeds_mps.begin() + static_cast<std::ptrdiff_t>(speeds_mps.size() / 2)};
  std::ranges::nth_element(speeds_mps, middle);
  if (*middle <= fastest_mps) return;
  contents.warnings.push_back(fmt::format(
      "poses: half of the steps are faster than {:.0f} m/s: are they in millimetres? Positions are in metres.",
      *middle));
}

void take_own_poses(RecordingContents& contents, const fs::path& file, const std::vector<StampedPose>& poses) {
  contents.poses_file = file;
  apply_interpolated(contents, file.string() + ", " + contents.poses_source, poses);
  contents.notes.push_back(fmt::format("poses: {}, interpolated to the times of the images", contents.poses_source));
}

}  // namespace stereogrid::io
