// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "stereogrid/camera.hpp"

namespace stereogrid {

/// How a camera that is mounted as the rig says sees the road.
Ground mounting_of(const Rig& rig);

/// The rig, mounted so that it sees the road as `ground`.
Rig mounted_as(Rig rig, const Ground& ground);

/// With the mounting to the digits of sentence_of_mounting(), so that a calibration with them does the same.
Rig as_written(Rig rig);

/// Says that another mounting than the calibration's was found, and what to write into calibration.yaml.
std::string sentence_of_mounting(const Rig& rig);

}  // namespace stereogrid
