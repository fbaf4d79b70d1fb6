// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "type_hashes.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace stereogrid::dds {

std::string_view type_hash(std::string_view ros_type) {
  using Known = std::pair<std::string_view, std::string_view>;
  static constexpr std::array<Known, 6> known{
      {{"nav_msgs/msg/OccupancyGrid", "RIHS01_8d348150c12913a31ee0ec170fbf25089e4745d17035792a1ba94d6f0bc0cfc7"},
       {"sensor_msgs/msg/Image", "RIHS01_d31d41a9a4c4bc8eae9be757b0beed306564f7526c88ea6a4588fb9582527d47"},
       {"sensor_msgs/msg/CameraInfo", "RIHS01_b3dfd68ff46c9d56c80fd3bd4ed22c7a4ddce8c8348f2f59c299e73118e7e275"},
       {"stereo_msgs/msg/DisparityImage", "RIHS01_1ec1ff6b5bace919e4544a37f2d96ead9f81783701b7b7a4d97a09325ecf2711"},
       {"sensor_msgs/msg/PointCloud2", "RIHS01_9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5"},
       {"visualization_msgs/msg/MarkerArray",
        "RIHS01_86cb8800b6fb05b5eff1abd7a56f62a5641d3ae9a1c29e78e67e704f1d067dcf"}}};
  const auto* const found{std::ranges::find(known, ros_type, &Known::first)};
  return found == known.end() ? std::string_view{} : found->second;
}

}  // namespace stereogrid::dds
