// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "input/calibration/calibration_forms.hpp"
#include "input/origin.hpp"
#include "stereogrid/io/calibration.hpp"

namespace stereogrid::io {

/// Adapts the cameras of `raw`, or else the rig, to the images' size; no effect where that is unknown. Scales a
/// calibration of another size where the ratio is exact, and notes it. Warns of a principal point that is probably that
/// of other images. Throws InputError: no exact ratio; in a calibration without a size, a principal point far from the
/// middle. The caller rectifies a raw pair again.
void fit_size(Calibration& calibration, const Origin& origin, const CalibrationRequest& request);

}  // namespace stereogrid::io
