// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
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

/// Unit of stamps.
struct StampUnit {
  std::int64_t ns{1};
  const char* name{"nanoseconds"};
  std::string note{};     ///< another unit than the nominal one; empty: nothing to say
  std::string warning{};  ///< frames come more seldom than 0.1 Hz; empty: they do not
};
inline const std::array<StampUnit, 4> stamp_units{
    {{1, "nanoseconds"}, {1000, "microseconds"}, {1'000'000, "milliseconds"}, {1'000'000'000, "seconds"}}};

/// The nominal unit where frames come at 0.1 to 1000 Hz, else the one of the four with a usual rate (0.5 to 250 Hz).
/// `stamps`: in their unit, growing. Throws InputError: faster than 1000 Hz, or beyond largest_stamp_ns, in every unit.
[[nodiscard]] StampUnit stamp_unit(std::span<const double> stamps, const StampUnit& nominal, const std::string& source);

/// Brings the frames' stamps to nanoseconds, and notes another unit. Throws as stamp_unit().
void settle_stamps(RecordingContents& contents, const std::filesystem::path& file);

/// Gives each frame its stamp. False: the images have no stamps, some are assumed.
bool find_stamps(RecordingContents& contents, const InputLayout& layout, const std::string& poses);

/// Median of the intervals. `poses`: two at least.
[[nodiscard]] std::int64_t usual_interval_ns(std::span<const StampedPose> poses);

struct Times {
  std::vector<std::int64_t> stamps_ns;
  std::string note;     ///< as StampUnit::note
  std::string warning;  ///< stamps that count the frames; empty: they do not
};

/// KITTI odometry's times.txt: seconds, or the unit of stamp_unit(), a line per frame. Throws InputError: no number,
/// not `expected` of them, not increasing.
[[nodiscard]] Times read_times(const std::filesystem::path& path, std::size_t expected);

/// KITTI raw's timestamps.txt: "2011-09-26 13:02:25.964389445" a line, as nanoseconds since 1970. Throws InputError:
/// not understood, not increasing; `mend` says what to do then.
extern const char* const without_stamps;
[[nodiscard]] std::vector<std::int64_t> read_timestamps(const std::filesystem::path& path,
                                                        const char* mend = without_stamps);

/// The stamp in a frame's name, behind its last _ or -, in the unit of stamp_unit() with nominal nanoseconds: 13
/// digits, or 16 to 19. Nanoseconds: 1305031102.175304 (s), and dates of 17 digits (year to millisecond).
[[nodiscard]] std::optional<std::int64_t> stamp_in(std::string_view name);

/// data.csv of a EuRoC (ASL) folder: stamps (ns) by the images' names without extension.
[[nodiscard]] std::map<std::string, std::int64_t> read_euroc_stamps(const std::filesystem::path& path);

/// Adds a warning where the median speed between frames is above 150 m/s: positions in another unit.
void warn_of_speed(RecordingContents& contents);

}  // namespace stereogrid::io
