// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "input/layout/input_layout.hpp"
#include "stereogrid/io/poses.hpp"
#include "stereogrid/io/recording.hpp"

namespace stereogrid::io {

/// Named poses belong to frames; others have times of their own.
bool are_named(const std::vector<NamedPose>& rows);

/// Chooses where the poses of a recording come from, and gives each frame its own. `wanted`: see InputArguments;
/// `stamps_known`: the frames' stamps are the images' and not assumed.
void find_poses_of(RecordingContents& contents, const InputLayout& layout, const std::string& wanted,
                   bool stamps_known);

/// The same with poses that came with the images, of contents.poses_source. `file`: where they are.
void take_own_poses(RecordingContents& contents, const std::filesystem::path& file,
                    const std::vector<StampedPose>& poses);

/// Warns of stamps that come more seldom or more often than those of any camera: they are in another unit.
void warn_of_rate(RecordingContents& contents, const std::filesystem::path& file);

/// Gives each frame its stamp. False: the images have no stamps, some are assumed.
bool find_stamps(RecordingContents& contents, const InputLayout& layout, const std::string& poses);

/// KITTI odometry's times.txt: seconds, a line per frame. Throws InputError: no number, not `expected` of them, not
/// increasing.
[[nodiscard]] std::vector<std::int64_t> read_times(const std::filesystem::path& path, std::size_t expected);

/// KITTI raw's timestamps.txt: "2011-09-26 13:02:25.964389445" a line, as nanoseconds since 1970. Throws InputError:
/// not understood, not increasing; `mend` says what to do then.
extern const char* const without_stamps;
[[nodiscard]] std::vector<std::int64_t> read_timestamps(const std::filesystem::path& path,
                                                        const char* mend = without_stamps);

/// The stamp in a frame's name: 16 to 19 digits are nanoseconds, 1305031102.175304 seconds since 1970.
[[nodiscard]] std::optional<std::int64_t> stamp_in(std::string_view name);

/// data.csv of a EuRoC (ASL) folder: stamps (ns) by the images' names without extension.
[[nodiscard]] std::map<std::string, std::int64_t> read_euroc_stamps(const std::filesystem::path& path);

}  // namespace stereogrid::io
