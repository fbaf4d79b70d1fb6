// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/calibration.hpp"

#include "targets.hpp"

namespace stereogrid::fuzz {
namespace {

void check_rig(const io::Calibration& calibration) {
  require(problems(calibration.rig).empty(), "a calibration was accepted whose rig is none");
}

}  // namespace

void calibration_kitti(Bytes input) {
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

void calibration_yaml(Bytes input) {
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
