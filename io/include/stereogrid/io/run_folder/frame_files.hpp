// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "stereogrid/export.hpp"
#include "stereogrid/result.hpp"

namespace stereogrid::io {

// The .npz files of a frame; their arrays are listed in docs/format.md. Throw DeviceError.

STEREOGRID_EXPORT void write_grids(const std::filesystem::path& path, const FrameResult& result);
/// The frame must have predictions.
STEREOGRID_EXPORT void write_predictions(const std::filesystem::path& path, const FrameResult& result);
STEREOGRID_EXPORT void write_stages(const std::filesystem::path& path, const StageImages& stages);

}  // namespace stereogrid::io
