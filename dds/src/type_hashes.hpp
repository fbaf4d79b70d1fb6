// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace stereogrid::dds {

/// What Jazzy tells of a type to find two that have the same name and differ (REP 2011), as its peers' user data has
/// it: "RIHS01_…"; "": not known, which peers take for any.
[[nodiscard]] std::string_view type_hash(std::string_view ros_type);

}  // namespace stereogrid::dds
