// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "stereogrid/io/calibration.hpp"

namespace stereogrid::io {

/// Reads either form of calibration.yaml; a raw pair's rig is that of the pair after rectification. Throws InputError:
/// no YAML, keys missing or unknown, values that are no numbers. The numbers themselves are checked by the caller.
[[nodiscard]] Calibration read_calibration_yaml(const std::filesystem::path& path, int width_px, int height_px);

}  // namespace stereogrid::io
