// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "stereogrid/camera.hpp"

namespace stereogrid {

/// Extrinsics of the rig as a ground plane.
Ground extrinsics_of(const Rig& rig);

/// The rig with `ground` as extrinsics.
Rig with_extrinsics(Rig rig, const Ground& ground);

/// Rig with the extrinsics rounded to the digits of extrinsics_message(), so that a calibration with them gives the
/// same results.
Rig as_written(Rig rig);

/// Message about estimated extrinsics, with the line for calibration.yaml.
std::string extrinsics_message(const Rig& rig);

}  // namespace stereogrid
