// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
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

}  // namespace stereogrid::io
