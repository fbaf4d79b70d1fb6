// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace stereogrid::io {

/// KITTI odometry's times.txt: seconds, a line per frame. Throws InputError: no number, not `expected` of them, not
/// increasing.
[[nodiscard]] std::vector<std::int64_t> read_times(const std::filesystem::path& path, std::size_t expected);

/// KITTI raw's timestamps.txt: "2011-09-26 13:02:25.964389445" a line, as nanoseconds since 1970. Throws InputError:
/// not understood, not increasing; `mend` says what to do then.
extern const char* const without_stamps;
[[nodiscard]] std::vector<std::int64_t> read_timestamps(const std::filesystem::path& path,
                                                        const char* mend = without_stamps);

}  // namespace stereogrid::io
