// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/calibration.hpp"

#include "support.hpp"

namespace stereogrid::fuzz {
namespace {

void check_rig(const io::Calibration& calibration) {
  require(problems(calibration.rig).empty(), "a calibration was accepted whose rig is none");
}

/// As it is, of images of one size, and named by a calibration.yaml.
void read_in_all_ways(const Folder& folder, const std::string& name) {
  accepts([&] { check_rig(io::read_calibration(folder / name)); });
  accepts([&] { check_rig(io::read_calibration(folder / name, 96, 64)); });
  for (const char* const more : {"", "images: rectified\n", "baseline_m: 0.25\n"}) {
    const auto path{folder.write("calibration.yaml", "from: " + name + "\n" + more)};
    accepts([&] { check_rig(io::read_calibration(path, 96, 64)); });
  }
}

}  // namespace

FUZZ_TARGET(calibration_kalibr) {
  static const Folder folder;
  folder.write("camchain.yaml", text_of(input));
  read_in_all_ways(folder, "camchain.yaml");
}

/// Files calib_cam_to_cam.txt and calib_velo_to_cam.txt.
FUZZ_TARGET(calibration_kitti) {
  static const Folder folder;
  const auto files{parts_of(input, 2)};
  const auto path{folder.write("calib_cam_to_cam.txt", files[0])};
  std::filesystem::remove(folder / "calib_velo_to_cam.txt");
  if (!files[1].empty()) folder.write("calib_velo_to_cam.txt", files[1]);
  for (const io::KittiPair pair : {io::KittiPair::grey, io::KittiPair::colour}) {
    accepts([&] { check_rig(io::read_calibration(path, 0, 0, pair)); });
    accepts([&] { check_rig(io::read_calibration(path, 96, 64, pair)); });
  }
}

/// Files intrinsics.yml and extrinsics.yml.
FUZZ_TARGET(calibration_opencv) {
  static const Folder folder;
  const auto files{parts_of(input, 2)};
  folder.write("intrinsics.yml", files[0]);
  folder.write("extrinsics.yml", files[1]);
  read_in_all_ways(folder, "extrinsics.yml");
}

/// Any other tool's, by its content or as YAML.
FUZZ_TARGET(calibration_other) {
  static const Folder folder;
  for (const char* const name : {"other.txt", "other.yml"}) {
    folder.write(name, text_of(input));
    read_in_all_ways(folder, name);
    accepts([&] { check_rig(io::read_depth_calibration(folder / name, 96, 64)); });
  }
}

/// Files left.yaml and right.yaml.
FUZZ_TARGET(calibration_ros) {
  static const Folder folder;
  const auto files{parts_of(input, 2)};
  folder.write("left.yaml", files[0]);
  folder.write("right.yaml", files[1]);
  read_in_all_ways(folder, "left.yaml");
}

FUZZ_TARGET(calibration_yaml) {
  static const Folder folder;
  const auto path{folder.write("calibration.yaml", text_of(input))};
  accepts([&] { check_rig(io::read_calibration(path, 96, 64)); });
  io::Calibration calibration;
  if (!accepts([&] { calibration = io::read_calibration(path); })) return;
  check_rig(calibration);
  if (calibration.raw || calibration.rig.width_px == 0) return;
  io::write_calibration_yaml(folder / "again.yaml", calibration.rig);
  require(io::read_calibration(folder / "again.yaml").rig == calibration.rig, "a rig changes when it is written");
}

}  // namespace stereogrid::fuzz
