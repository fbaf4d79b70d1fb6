// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "stereogrid/camera.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid::app {

/// Grid of labelled pixels, PixelLabel (H, W), on level ground below a camera mounted as `rig` says. In each column of
/// the image the lowest obstacle or mover stands on the ground at its lowest pixel: its cell is occupied, passable
/// pixels before it are free, and the rest is unknown. Confidence: 0.8, and less where a row of pixels is deeper than a
/// cell.
[[nodiscard]] ObservedGrid label_grid(const Image<std::uint8_t>& labels, const Rig& rig, const GridGeometry& grid);

}  // namespace stereogrid::app
