// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "lidar_drive.hpp"

#include <fstream>
#include <string>
#include <vector>

#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

constexpr int ring_count{64};
constexpr int beam_count{2000};

/// Rings from left to right over a road; every second one of the upper rings, the odd ones, meets a wall 8 m ahead.
std::vector<float> sweep() {
  std::vector<float> scan;
  for (int ring{0}; ring < ring_count; ++ring) {
    const bool is_road{ring < 40 || ring % 2 == 0};
    const double x{is_road ? 3 + 0.2 * (ring % 40) : 8};
    const double z{is_road ? -1.65 : -1.6 + 0.08 * (ring - 40)};
    for (int beam{0}; beam < beam_count; ++beam) {
      const double y{10.0 * (1 - 2.0 * beam / beam_count)};
      for (const double value : {x, y, z, 0.5}) scan.push_back(static_cast<float>(value));
    }
  }
  return scan;
}

}  // namespace

void put_lidar_drive(const fs::path& drive) {
  run_well({"simulate", small_scene("empty", "&frames=3&focal=80&baseline=0.5&camera_height=1.65"), "--out",
            (drive / "plain").string()});
  fs::create_directories(drive / "velodyne");
  fs::rename(drive / "plain" / "left", drive / "image_0");
  fs::rename(drive / "plain" / "right", drive / "image_1");
  std::ofstream{drive / "calib.txt"} << "P0: 80 0 80 0 0 80 50 0 0 0 1 0\nP1: 80 0 80 -40 0 80 50 0 0 0 1 0\n"
                                        "Tr: 0 -1 0 0 0 0 -1 0 1 0 0 0\n";
  std::ofstream{drive / "times.txt"} << "0.0\n0.1\n0.2\n";
  const std::vector<float> scan{sweep()};
  for (const char* name : {"000000", "000002"}) {
    std::ofstream file{drive / "velodyne" / (std::string{name} + ".bin"), std::ios::binary};
    file.write(reinterpret_cast<const char*>(scan.data()), static_cast<std::streamsize>(scan.size() * sizeof(float)));
  }
}

}  // namespace stereogrid::app::testing
