// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/road_plane.hpp"
#include "stereogrid/camera.hpp"
#include "stereogrid/io/calibration.hpp"
#include "stereogrid/io/scan.hpp"
#include "stereogrid/truth.hpp"

namespace stereogrid::bench {

/// Surface of a truth point; also a matcher's label of a pixel, `other` for none.
enum class Surface : std::uint8_t { other = 0, road = 1, obstacle = 2 };

/// A point whose disparity is known. u, v need not be integers: it is compared with the pixel it falls into.
struct TruthPoint {
  float u{0};  ///< px, left image
  float v{0};
  float disparity{0};  ///< px, > 0
  Surface surface{Surface::other};
  bool near_contact{false};  ///< a point of the other surface (road, obstacle) lies within contact_px
};

/// Half of the largest window that is compared, 21: nearer to the boundary of road and obstacle, a window sees both.
constexpr int contact_px{10};

/// A point of truth for every return that falls into the left image, at least 2 m ahead.
std::vector<TruthPoint> points_of_scan(const std::vector<io::ScanPoint>& scan,
                                       const io::Transform& camera_from_velodyne, const Rig& rig);

/// A point for every pixel that has a disparity.
std::vector<TruthPoint> points_of_image(const Image<float>& disparity);

/// A point for every pixel that both cameras see, with its surface; near_contact uses all pixels.
std::vector<TruthPoint> points_of_scene(const FrameTruth& truth);

/// Removes the points that something nearer hides from the left or the right camera. The lidar sits above the cameras
/// and sees over things; its points are some 2 px apart across and 5 px down, so that a thing is a lattice of points:
/// a point is hidden if a clearly nearer one projects within 3 columns and between 2 rows above and 7 below it. Nearer
/// by 1 px of disparity, and by more the further down: a road, or a car's roof, gets nearer downwards by itself.
void remove_hidden(const Rig& rig, std::vector<TruthPoint>& points);

/// Ground plane in disparity space, fitted to the low points 4–30 m ahead and up to 8 m aside. Least squares of the
/// height in ever narrower bands, starting from the rig's extrinsics.
RoadPlane fit_road(const Rig& rig, const std::vector<TruthPoint>& points);

/// Height above the plane, m.
double height_above(const RoadPlane& plane, double camera_height_m, const TruthPoint& point);

/// Sets surface by height above the plane: road within 0.10 m of it, obstacle above 0.30 m; other in between, below,
/// and further than 40 m, where the plane is no longer known well enough. Sets near_contact too.
void label_by_height(const Rig& rig, const RoadPlane& plane, std::vector<TruthPoint>& points);

/// Takes points of a pitched camera's image to that of the level camera (see LevelMapping).
void turn_level(const Rig& pitched, const Rig& level, std::vector<TruthPoint>& points);

/// Keeps points that every matcher can find: in the image, disparity below `disparities` − 1, and at least
/// `disparities` + 10 columns from the left border, since OpenCV leaves the first `disparities` columns empty.
void keep_comparable(const Rig& rig, int disparities, std::vector<TruthPoint>& points);

}  // namespace stereogrid::bench
