// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "stereogrid/export.hpp"
#include "stereogrid/truth.hpp"

namespace stereogrid::io {

/// The labels of a frame.
struct LabelledFrame {
  std::string name;
  std::vector<LabelledObject> objects;
};

/// Reads a drive's objects.jsonl (docs/input.md): a line per frame, in the order of the file. Throws InputError:
/// missing, not understood, numbers out of all range, a frame named twice.
[[nodiscard]] STEREOGRID_EXPORT std::vector<LabelledFrame> read_object_labels(const std::filesystem::path& path);

}  // namespace stereogrid::io
