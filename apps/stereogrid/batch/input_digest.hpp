// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace stereogrid::app::batch {

/// Of how much of a file a digest is: of images and sweeps the size alone, of other large files the two ends; or of
/// every byte.
enum class DigestOf { names_and_sizes, content };

/// Tells inputs apart: of the names of all files below the paths, their sizes and (DigestOf) bytes. "scene:…" counts
/// as its text. Neither the folder that an input lies in nor the times of its files matter. Throws InputError: not
/// there, not readable.
[[nodiscard]] std::string input_digest(const std::vector<std::string>& paths, DigestOf what);

}  // namespace stereogrid::app::batch
