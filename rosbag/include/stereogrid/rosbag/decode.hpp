// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "stereogrid/image.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/mcap/bag.hpp"
#include "stereogrid/messages/std_msgs.hpp"

namespace stereogrid::rosbag {

/// The header, with which messages of images begin. Throws InputError.
[[nodiscard]] std::int64_t header_stamp_ns(std::span<const std::byte> cdr);
[[nodiscard]] std::int64_t ns_of(const messages::builtin_interfaces::Time& stamp);

/// A sensor_msgs/Image or CompressedImage, as io::decode_ros_image().
[[nodiscard]] io::ScaledImage decode_image(std::span<const std::byte> cdr, bool is_compressed, const std::string& name);

/// As io::decode_ros_depth() or io::decode_ros_disparities(). `topic`: of the message.
[[nodiscard]] Image<float> decode_depth(std::span<const std::byte> cdr, const mcap::Topic& topic,
                                        const std::string& name);

/// T of a DisparityImage, m; 0: it has none. Throws InputError: damaged.
[[nodiscard]] double disparity_baseline_m(std::span<const std::byte> cdr);
/// T of the first DisparityImage of a topic, m; 0: it has none.
[[nodiscard]] double first_baseline_m(const mcap::Bag& bag, const std::string& topic);

}  // namespace stereogrid::rosbag
