// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "input/layout/input_layout.hpp"
#include "stereogrid/io/recording.hpp"

namespace stereogrid::io {

/// Warns of stamps that come more seldom or more often than those of any camera: they are in another unit.
void warn_of_rate(RecordingContents& contents, const std::filesystem::path& file);

/// Gives each frame its stamp. False: the images have no stamps, some are assumed.
bool find_stamps(RecordingContents& contents, const InputLayout& layout, const std::string& poses);

}  // namespace stereogrid::io
