// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stereogrid/camera.hpp"
#include "stereogrid/export.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/image.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"

namespace stereogrid::messages {

/// Nearest obstacle at each bearing in the camera's field of view, relative to the origin of the vehicle frame
/// (docs/messages.md, topic `scan`). Writes all fields but the header; reuses the message's memory.
///
/// `geometry`: in the vehicle frame; `occupancy` has its size. `rig`: Pipeline::rig().
STEREOGRID_EXPORT void fill(sensor_msgs::LaserScan& message, const Rig& rig, const GridGeometry& geometry,
                            View<const float> occupancy);

}  // namespace stereogrid::messages
