// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "stereogrid/pipeline.hpp"

namespace stereogrid {

/// Throws ConfigError with all that a pipeline cannot be made of.
void check(const Config& config, const Rig& rig, const PipelineOptions& options);

/// Throws InputError where a frame's images, pose or other grids cannot be used.
void check(const StereoFrame& frame, const FrameImages& images, const Rig& rig);

/// Finite, and in a range with a resolution much finer than a cell.
bool is_place(const Pose2& pose);

}  // namespace stereogrid
