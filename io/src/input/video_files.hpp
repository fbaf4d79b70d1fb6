// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>

namespace stereogrid::io {

/// By its name or its first bytes.
[[nodiscard]] bool is_video(const std::filesystem::path& file);
[[nodiscard]] bool has_video_extension(const std::filesystem::path& file);

/// Throws InputError where there are videos among the files, and names them.
void refuse_videos(std::span<const std::filesystem::path> files);

}  // namespace stereogrid::io
