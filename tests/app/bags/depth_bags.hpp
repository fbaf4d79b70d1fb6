// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bag_drive.hpp"
#include "stereogrid/io/calibration.hpp"

namespace stereogrid::app::testing {

/// Images with depth or disparities of them.
class DepthBags : public Bags {
 protected:
  static Rig rig() { return io::read_calibration(drive() / "calibration.yaml", 160, 100).rig; }

  /// Level ground below a camera at 1.65 m, a wall 9 m ahead, and a box 5 m ahead.
  static Image<float> depth_m() {
    const Rig optics{rig()};
    Image<float> depth{160, 100};
    for (const auto [u, v] : raster(depth)) {
      const double below{(v - optics.cy_px) / optics.focal_px};
      const double right{(u - optics.cx_px) / optics.focal_px};
      const bool is_box{std::abs(right) < 0.1 && below > 0};
      const double wall_m{is_box ? 5.0 : 9.0};
      depth(u, v) = static_cast<float>(below > 1.65 / wall_m ? 1.65 / below : wall_m);
    }
    depth(3, 3) = std::numeric_limits<float>::quiet_NaN();
    depth(4, 3) = std::numeric_limits<float>::infinity();
    depth(5, 3) = 0;
    return depth;
  }

  /// Values of `of` by pixel as the bytes of T.
  template <class T, class Of>
  static messages::sensor_msgs::Image message(const std::string& encoding, Of&& of) {
    messages::sensor_msgs::Image image;
    image.width = 160;
    image.height = 100;
    image.encoding = encoding;
    image.step = 160 * sizeof(T);
    image.data.resize(image.step * image.height);
    std::size_t at{0};
    for (const float z : depth_m()) {
      const T value{of(z)};
      std::memcpy(&image.data[at], &value, sizeof value);
      at += sizeof value;
    }
    return image;
  }
  static messages::sensor_msgs::Image metres() {
    return message<float>("32FC1", [](float z) { return z; });
  }
  static messages::sensor_msgs::Image millimetres() {
    return message<std::uint16_t>(
        "16UC1", [](float z) { return static_cast<std::uint16_t>(std::isfinite(z) ? std::lround(1000 * z) : 0); });
  }
  static messages::stereo_msgs::DisparityImage disparities() {
    messages::stereo_msgs::DisparityImage message_of;
    const Rig optics{rig()};
    message_of.f = static_cast<float>(optics.focal_px);
    message_of.t = static_cast<float>(optics.baseline_m);
    message_of.max_disparity = 63;
    message_of.image =
        message<float>("32FC1", [&](float z) { return static_cast<float>(optics.focal_px * optics.baseline_m / z); });
    return message_of;
  }

  /// Left images with their CameraInfo and `second` of each.
  template <class M>
  static std::vector<Entry> entries_of(const std::string& images, const std::string& second_topic, M second,
                                       bool has_right_info = true) {
    std::vector<Entry> all;
    const std::string folder{images.substr(0, images.rfind('/'))};
    for (std::size_t i{0}; i < frames; ++i) {
      all.push_back(image(images, "left", i, "mono8", 0));
      all.push_back(entry(folder + "/camera_info", start_ns + stamp_of(i), info(false)));
      if (has_right_info) all.push_back(entry("/camera/right/camera_info", start_ns + stamp_of(i), info(true)));
      second.header = header(stamp_of(i));
      all.push_back(entry(second_topic, start_ns + stamp_of(i) + 1, second));
    }
    return all;
  }
  template <class M>
  static void write(const std::string& images, const std::string& second_topic, const M& second,
                    bool has_right_info = true) {
    write_mcap(bag(), entries_of(images, second_topic, second, has_right_info));
  }
};

}  // namespace stereogrid::app::testing
