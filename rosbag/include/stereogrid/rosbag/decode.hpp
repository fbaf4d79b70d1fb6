// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "stereogrid/io/image_file.hpp"
#include "stereogrid/messages/std_msgs.hpp"

namespace stereogrid::rosbag {

/// The header, with which messages of images begin. Throws InputError.
[[nodiscard]] std::int64_t header_stamp_ns(std::span<const std::byte> cdr);
[[nodiscard]] std::int64_t ns_of(const messages::builtin_interfaces::Time& stamp);

/// A sensor_msgs/Image or CompressedImage at its own scale. `name`: for complaints. Throws InputError: damaged, of an
/// encoding that is not read.
[[nodiscard]] io::ScaledImage decode_image(std::span<const std::byte> cdr, bool is_compressed, const std::string& name);

}  // namespace stereogrid::rosbag
