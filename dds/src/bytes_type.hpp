// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>

#include <cstddef>
#include <span>
#include <string>

namespace stereogrid::dds {

// Type of Cyclone DDS whose samples are bytes, which messages/ encodes and decodes. It serves every type of ROS by its
// name, as rmw_cyclonedds does. No keys, CDR of version 1.

/// `name`: "nav_msgs::msg::dds_::OccupancyGrid_". The caller owns it until a topic is made with it.
[[nodiscard]] ddsi_sertype* new_bytes_type(const std::string& name);

/// Sample for dds_writecdr() with a copy of `cdr`, its header of 4 bytes included. Throws InputError: size outside
/// 4 … 2³² − 4 bytes.
[[nodiscard]] ddsi_serdata* new_sample(const ddsi_sertype* type, std::span<const std::byte> cdr);

/// Bytes of a sample from dds_takecdr(); valid while the sample exists.
[[nodiscard]] std::span<const std::byte> bytes_of(const ddsi_serdata* sample);

}  // namespace stereogrid::dds
