// SPDX-License-Identifier: Apache-2.0
//
// The weights are written by research/fit_rays.py, which has the same constants.
#pragma once

#include "host_device.hpp"

namespace stereogrid {

/// Kinds of counted rays of a cell. Nearer disparities are larger: near, far are those of the cell's ends.
enum CellRayKind {
  ending,           ///< obstacle pixels from far − blur to near + blur, in `columns_around` more columns
  behind,           ///< obstacle pixels from far − 4 px to far
  in_front,         ///< obstacle pixels from near to near + 4 px
  road_in_front,    ///< road pixels from near to near + 1 px
  arriving,         ///< rays that come as far as near
  passing,          ///< rays that continue behind far
  passing_farther,  ///< rays that continue behind far − 1 px
  cell_rays
};

/// For each column of the cell on average.
struct CellRays {
  float count[cell_rays];
};

constexpr int columns_around{5};        ///< to either side
constexpr float widest_blur_px{0.5f};   ///< the weights are fitted with it
constexpr float half_known_rays{0.5f};  ///< as many arriving rays make a cell half as known as many would
constexpr float log_odds_max{6.9f};     ///< P from 0.001 to 0.999

/// Log odds against an obstacle that are halved; larger ones count more, smaller ones hardly.
constexpr float weak_log_odds{3.0f};
constexpr float power_of_weak_log_odds{weak_log_odds * weak_log_odds * weak_log_odds * weak_log_odds * weak_log_odds *
                                       weak_log_odds};

/// The unit of pixels and of rays within ln(1 + count / unit).
STEREOGRID_HD constexpr float unit_of(int kind) {
  return kind < arriving ? 0.3f : 1.0f;
}

/// Fitted on kitti_odo04, kitti_raw0009, B-crossing, C-street, E-kitti-like: the logarithm of the odds by each input.
struct RayWeights {
  float value[cell_rays]{1.700f, 0.311f, 0.521f, -1.091f, 3.930f, -5.625f, 0.848f};
};

}  // namespace stereogrid
