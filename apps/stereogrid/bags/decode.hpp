// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "stereogrid/image.hpp"
#include "stereogrid/messages/std_msgs.hpp"

namespace stereogrid::app {

/// The header, with which messages of images begin. Throws InputError.
[[nodiscard]] std::int64_t header_stamp_ns(std::span<const std::byte> cdr);
[[nodiscard]] std::int64_t ns_of(const messages::builtin_interfaces::Time& stamp);

/// A sensor_msgs/Image or CompressedImage as 8-bit grey. `bits`: how many of 16 carry the picture (io::read_grey); 0:
/// becomes those of this image. `name`: for complaints. Throws InputError: damaged, of an encoding that is not read.
[[nodiscard]] Image<std::uint8_t> decode_image(std::span<const std::byte> cdr, bool is_compressed,
                                               const std::string& name, int& bits);

}  // namespace stereogrid::app
