// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/ros_image.hpp"

#include "support.hpp"

namespace stereogrid::io::testing {
namespace {

TEST(RosImage, ReadsBayerPatterns) {
  constexpr std::uint32_t width{8};
  constexpr std::uint32_t height{6};
  for (const std::string pattern : {"rggb", "bggr", "gbrg", "grbg"}) {
    for (const std::uint32_t bytes : {1U, 2U}) {
      const std::string encoding{"bayer_" + pattern + (bytes == 1 ? "8" : "16")};
      std::vector<std::uint8_t> data;
      for (std::size_t v{0}; v < height; ++v) {
        for (std::size_t u{0}; u < width; ++u) {
          // red pixels are brighter: 0.299 of the difference remains
          data.push_back(pattern[v % 2 * 2 + u % 2] == 'r' ? 200 : 100);
          if (bytes == 2) data.push_back(0);
        }
      }
      const RosImage image{encoding, data, false, width, height, width * bytes, true};
      EXPECT_NEAR(decode_ros_image(image, "image").grey(4, 3), 130, 2) << encoding;
    }
  }
}

}  // namespace
}  // namespace stereogrid::io::testing
