// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "stereogrid/camera.hpp"

namespace stereogrid {

/// Ground plane according to the rig's extrinsics.
Ground mounting_of(const Rig& rig);

/// The rig, mounted so that it sees the road as `ground`.
Rig mounted_as(Rig rig, const Ground& ground);

/// Rig with the extrinsics rounded to the digits of sentence_of_mounting(), so that a calibration with them gives the
/// same results.
Rig as_written(Rig rig);

/// Message about estimated extrinsics, with the line for calibration.yaml.
std::string sentence_of_mounting(const Rig& rig);

}  // namespace stereogrid
