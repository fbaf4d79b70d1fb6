// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "stereogrid/camera.hpp"
#include "stereogrid/export.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/image.hpp"
#include "stereogrid/truth.hpp"

namespace stereogrid::evaluation {

// Values of Labels::cells.
inline constexpr std::int8_t not_scored{-1};
inline constexpr std::int8_t labelled_free{0};
inline constexpr std::int8_t labelled_occupied{1};

/// True state of the cells of one frame, on the vehicle-frame grid that is scored.
struct Labels {
  GridGeometry geometry;
  Rig rig;                   ///< rig whose image columns define hidden cells and free space
  Image<std::int8_t> cells;  ///< not_scored, labelled_free or labelled_occupied
  Image<std::uint8_t>
      partly_hidden;  ///< 1: labelled, though every image column of the cell meets an obstacle before it
  Image<std::uint8_t> hidden_ground{};  ///< 1: labelled free, though the camera cannot see it; empty: exact truth
};

/// A point in the left camera's frame: x right, y down, z forward.
struct CameraPoint {
  double x_m{0};
  double y_m{0};
  double z_m{0};
};

/// Minimum depth difference (m) between an obstacle and a cell's near edge for the obstacle to hide the cell from the
/// nearest-obstacle rule.
inline constexpr double hiding_margin_m{0.5};

/// Start of the search for the road, measured on KITTI's drives, whose calibrations have no height.
inline constexpr double kitti_camera_height_m{1.64};

/// Labels from one lidar sweep (docs/evaluation.md). A plane is fitted to low points 4–30 m ahead and within 8 m of the
/// axis, starting where the rig's pitch and roll have it, `camera_height_m` below the camera. Of the points that the
/// camera could see, a cell is occupied with 2 or more that are 0.3–1.8 m above the plane; free with one within 0.12 m
/// of it and none of 0.3–1.8 m.
///
/// Partly hidden: every image column that the cell covers holds a point of a cell labelled occupied that is nearer by
/// hiding_margin_m and 3 m ahead or more. A point covers its column and one more at each side: that is how far apart
/// returns are.
///
/// Hidden ground: a free cell with an occupied one 0.25–4 m nearer in at least two of the three bearings of 0.5° around
/// it. The scanner is higher than the camera and reaches the road under and behind vehicles.
///
/// `points` are in the frame of the camera as it is mounted; where the rig's pitch exceeds 1° they are turned level, as
/// its images are. KITTI's calibrations give neither pitch nor roll: 0.
[[nodiscard]] STEREOGRID_EXPORT Labels lidar_labels(std::span<const CameraPoint> points, const Rig& rig,
                                                    const GridGeometry& grid,
                                                    double camera_height_m = kitti_camera_height_m);

/// Labels from exact truth: what the left camera sees of a cell, nothing: not scored. `grid` is the grid to be scored;
/// cells that the truth does not reach are not scored. Throws InputError where the cells of both do not coincide, with
/// the setting that would mend it.
///
/// Partly hidden: as above, with the pixels of obstacles between the truth's height limits. `rig`: of the recording.
[[nodiscard]] STEREOGRID_EXPORT Labels truth_labels(const FrameTruth& truth, const TruthGrid& truth_grid,
                                                    const Rig& rig, const GridGeometry& grid);

/// Position of cell (0, 0) of `truth` in the cells of `grid`. Throws InputError as truth_labels.
struct CellShift {
  int x{0};
  int y{0};
};
/// Throws InputError: other cell sizes, or origins that are no whole number of cells apart.
[[nodiscard]] STEREOGRID_EXPORT CellShift shift_between(const GridGeometry& grid, const GridGeometry& truth);

}  // namespace stereogrid::evaluation
