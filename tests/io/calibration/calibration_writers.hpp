// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>

#include "stereogrid/io/calibration.hpp"
#include "support.hpp"

namespace stereogrid::io::testing {

/// A pair of cameras, to be written as different tools would write it.
struct CameraPair {
  RawPair cameras;
  int width_px{0};
  int height_px{0};
};

/// Files by their names.
using Files = std::map<std::string, std::string>;

/// left.yaml and right.yaml. With the projections that OpenCV finds; of a rectified pair its own.
[[nodiscard]] Files ros_files(const CameraPair& pair);
/// intrinsics.yml and extrinsics.yml, by OpenCV itself. Perspective lenses only.
[[nodiscard]] Files opencv_files(const CameraPair& pair);
/// camchain.yaml. Distortion of four numbers, or none.
[[nodiscard]] Files kalibr_files(const CameraPair& pair);
/// calibration.yaml.
[[nodiscard]] Files own_files(const CameraPair& pair);

void put_files(const fs::path& folder, const Files& files);

/// A pair that is rectified already.
[[nodiscard]] CameraPair rectified_pair(const Rig& rig);

/// Turned cameras with distortion.
[[nodiscard]] CameraPair raw_pair(std::vector<double> left_distortion, std::vector<double> right_distortion,
                                  LensModel lens = LensModel::perspective);

}  // namespace stereogrid::io::testing
