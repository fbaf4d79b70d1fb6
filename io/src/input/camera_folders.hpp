// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "stereogrid/io/recording.hpp"

namespace stereogrid::io {

/// Folders of the stereo pairs of one vehicle: 'cameras' of calibration.yaml. Empty: another input. Throws InputError.
std::vector<std::filesystem::path> cameras_in(const InputArguments& arguments);

/// The first folder's recording, with the others as further cameras. Poses beside the folders are all cameras'. Throws
/// InputError for a camera without a mount, ConfigError for options that belong to one camera.
std::unique_ptr<Recording> open_cameras(InputArguments arguments, const std::vector<std::filesystem::path>& folders);

}  // namespace stereogrid::io
