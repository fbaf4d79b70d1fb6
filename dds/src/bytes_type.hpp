// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>

#include <cstddef>
#include <span>
#include <string>

namespace stereogrid::dds {

// A type of Cyclone DDS whose samples are bytes: what messages/ encodes goes out, and what comes is decoded there. So
// it serves every type of ROS by its name, as ROS's own layer over Cyclone DDS does it. No keys, CDR of version 1.

/// `name`: "nav_msgs::msg::dds_::OccupancyGrid_". The caller owns it until a topic is made with it.
[[nodiscard]] ddsi_sertype* new_bytes_type(const std::string& name);

/// A sample with a copy of the bytes, CDR with its first four, for dds_writecdr(). Throws InputError: more than DDS can
/// take, 2³² − 4.
[[nodiscard]] ddsi_serdata* new_sample(const ddsi_sertype* type, std::span<const std::byte> cdr);

/// Of a sample that dds_takecdr() gave; they last as long as it.
[[nodiscard]] std::span<const std::byte> bytes_of(const ddsi_serdata* sample);

}  // namespace stereogrid::dds
