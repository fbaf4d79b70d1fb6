// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "support.hpp"

namespace stereogrid::fuzz {

// Fuzz targets: each accepts any bytes, and throws or crashes on a fault. A fuzzer is made of each (CMakeLists.txt
// lists them too), and the replay runs them all on the stored inputs.

void bag_db3(Bytes input);
void bag_metadata(Bytes input);   ///< file metadata.yaml of a bag without parts
void bag_recording(Bytes input);  ///< a digit for the kind of bag, then files: five messages
void calibration_kalibr(Bytes input);
void calibration_kitti(Bytes input);   ///< files calib_cam_to_cam.txt and calib_velo_to_cam.txt
void calibration_opencv(Bytes input);  ///< files intrinsics.yml and extrinsics.yml
void calibration_other(Bytes input);   ///< any other tool's, by its content or as YAML
void calibration_ros(Bytes input);     ///< files left.yaml and right.yaml
void calibration_yaml(Bytes input);
void cdr(Bytes input);  ///< a byte for the type, then a message
void config_yaml(Bytes input);
void disparity(Bytes input);
void foxglove_client(Bytes input);  ///< messages of a WebSocket client, separated as files are; binary: after a 'b'
void http_target(Bytes input);  ///< a request: target, Host, Origin, Authorization, Cookie, ranges, tags, sub-protocols
void image(Bytes input);
void mcap(Bytes input);
void npy(Bytes input);
void npz(Bytes input);
void object_labels(Bytes input);
void oxts(Bytes input);      ///< files: two records, timestamps.txt, three calibrations
void pipeline(Bytes input);  ///< decisions
void poses_csv(Bytes input);
void poses_kitti(Bytes input);
void poses_tum(Bytes input);
void run_folder(Bytes input);  ///< files run.json, frames.jsonl and a frame's grids
void scan(Bytes input);
void scene(Bytes input);
void settings(Bytes input);  ///< lines KEY=VALUE
void times(Bytes input);
void timestamps(Bytes input);
void truth(Bytes input);  ///< files grid.json and objects.jsonl

struct Target {
  const char* name;
  void (*run)(Bytes input);
};

inline constexpr Target targets[]{{"bag_db3", bag_db3},
                                  {"bag_metadata", bag_metadata},
                                  {"bag_recording", bag_recording},
                                  {"calibration_kalibr", calibration_kalibr},
                                  {"calibration_kitti", calibration_kitti},
                                  {"calibration_opencv", calibration_opencv},
                                  {"calibration_other", calibration_other},
                                  {"calibration_ros", calibration_ros},
                                  {"calibration_yaml", calibration_yaml},
                                  {"cdr", cdr},
                                  {"config_yaml", config_yaml},
                                  {"disparity", disparity},
                                  {"foxglove_client", foxglove_client},
                                  {"http_target", http_target},
                                  {"image", image},
                                  {"mcap", mcap},
                                  {"npy", npy},
                                  {"npz", npz},
                                  {"object_labels", object_labels},
                                  {"oxts", oxts},
                                  {"pipeline", pipeline},
                                  {"poses_csv", poses_csv},
                                  {"poses_kitti", poses_kitti},
                                  {"poses_tum", poses_tum},
                                  {"run_folder", run_folder},
                                  {"scan", scan},
                                  {"scene", scene},
                                  {"settings", settings},
                                  {"times", times},
                                  {"timestamps", timestamps},
                                  {"truth", truth}};

}  // namespace stereogrid::fuzz
