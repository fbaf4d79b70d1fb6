// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/poses.hpp"

#include <algorithm>
#include <cmath>

#include "input/poses/recording_poses.hpp"
#include "stereogrid/io/file.hpp"
#include "support.hpp"

namespace stereogrid::fuzz {
namespace {

void check_pose(const Pose2& pose) {
  require(std::isfinite(pose.x_m) && std::isfinite(pose.y_m) && std::isfinite(pose.yaw_rad), "a pose is not finite");
}

std::size_t lines_in(Bytes input) {
  return static_cast<std::size_t>(std::ranges::count(input, '\n'));
}

void check_growing(const std::vector<std::int64_t>& stamps_ns) {
  require(std::ranges::adjacent_find(stamps_ns, std::greater_equal{}) == stamps_ns.end(), "stamps that do not grow");
}

void interpolate(const std::filesystem::path& path, const std::vector<io::NamedPose>& poses) {
  std::vector<io::StampedPose> stamped;
  std::vector<std::int64_t> stamps_ns{0, 1'000'000'000};
  for (const io::NamedPose& pose : poses) {
    stamped.push_back({pose.stamp_ns, pose.world_from_vehicle});
    stamps_ns.push_back(pose.stamp_ns);
  }
  for (const std::int64_t stamp_ns : stamps_ns) {
    accepts([&] { std::ranges::for_each(io::interpolate_poses(path, stamped, std::array{stamp_ns}), check_pose); });
  }
}

}  // namespace

FUZZ_TARGET(poses_csv) {
  static const Folder folder;
  const auto path{folder.write("poses.csv", text_of(input))};
  std::vector<io::NamedPose> poses;
  if (!accepts([&] { poses = io::read_poses_csv(path); })) return;
  for (const io::NamedPose& pose : poses) check_pose(pose.world_from_vehicle);
  interpolate(path, poses);
  if (poses.empty() || poses[0].name.empty()) return;
  io::write_poses_csv(folder / "once.csv", poses);
  io::write_poses_csv(folder / "twice.csv", io::read_poses_csv(folder / "once.csv"));
  require(io::read_file(folder / "once.csv") == io::read_file(folder / "twice.csv"), "poses change when written");
}

FUZZ_TARGET(poses_tum) {
  static const Folder folder;
  const auto path{folder.write("poses.txt", text_of(input))};
  accepts([&] {
    static_cast<void>(io::is_trajectory(path));
    const io::Trajectory trajectory{io::read_trajectory(path)};
    std::vector<std::int64_t> stamps_ns;
    for (const io::StampedPose& pose : trajectory.poses) {
      check_pose(pose.world_from_vehicle);
      stamps_ns.push_back(pose.stamp_ns);
    }
    check_growing(trajectory.have_stamps ? stamps_ns : trajectory.frames);
  });
  accepts([&] { static_cast<void>(io::read_euroc_stamps(path)); });
}

FUZZ_TARGET(poses_kitti) {
  static const Folder folder;
  const auto path{folder.write("poses.txt", text_of(input))};
  for (const std::size_t expected : {lines_in(input), lines_in(input) + 1}) {
    accepts([&] { std::ranges::for_each(io::read_kitti_poses(path, expected), check_pose); });
  }
}

FUZZ_TARGET(times) {
  static const Folder folder;
  const auto path{folder.write("times.txt", text_of(input))};
  for (const std::size_t expected : {lines_in(input), lines_in(input) + 1}) {
    accepts([&] { check_growing(io::read_times(path, expected).stamps_ns); });
  }
}

FUZZ_TARGET(timestamps) {
  static const Folder folder;
  accepts([&] { check_growing(io::read_timestamps(folder.write("timestamps.txt", text_of(input)))); });
}

/// Files: two records, timestamps.txt, three calibrations.
FUZZ_TARGET(oxts) {
  static const Folder folder;
  const auto files{parts_of(input, 6)};
  folder.write("oxts/data/0000000000.txt", files[0]);
  folder.write("oxts/data/0000000001.txt", files[1]);
  folder.write("oxts/timestamps.txt", files[2]);
  folder.write("calib_imu_to_velo.txt", files[3]);
  folder.write("calib_velo_to_cam.txt", files[4]);
  folder.write("calib_cam_to_cam.txt", files[5]);
  const std::array<std::string, 2> names{"0000000000", "0000000001"};
  for (const auto& calibration : {folder.path(), folder / "oxts"}) {
    accepts([&] {
      std::ranges::for_each(io::read_oxts(folder / "oxts/data", names, calibration).world_from_vehicle, check_pose);
    });
  }
  accepts([&] { check_growing(io::read_oxts_times(folder / "oxts/data").stamps_ns); });
}

}  // namespace stereogrid::fuzz
