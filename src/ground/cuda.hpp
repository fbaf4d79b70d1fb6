// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/cuda.hpp"
#include "ground/fit_model.hpp"

namespace stereogrid {

/// Value where the lattice has no road pixel, in px.
constexpr float no_ground_sample{1e30f};

/// Input of the fit; the host makes it.
struct GroundPrior {
  Ground previous;  ///< the frame before's
  Ground before;    ///< `previous`, brought to this frame
  RoadPlane expected;
  Matrix3 covariance;  ///< covariance of the plane's numbers
  int first_row;       ///< first row of the lattice that the fit reads
  int horizon_row;     ///< row of the lattice from which distances are counted
};
/// `previous` is the ground dt_s ago.
GroundPrior prior_of(const Rig& rig, const GroundConfig& config, const Ground& previous, double dt_s);

struct GroundOnDevice {
  GroundOnDevice(int width, int height);

  DeviceImage<float> residual;  ///< distance of the lattice's road pixels from the expected plane, or no_ground_sample
  DeviceBuffer<int> distances;  ///< pixels by their distance from it; all 0 between frames
};

/// From the lattice's residuals on. A part of estimate_ground.
void fit_ground(Cuda& cuda, const Rig& rig, const GroundConfig& config, const GroundPrior* prior, GroundOnDevice& space,
                Ground* ground, int* lost);

/// `estimate_ground` and `is_lost` of ground.hpp at once, since both read the same lattice of pixels. All pointers are
/// on the device: `ground` gets this frame's, `lost` 1 or 0.
///
/// Residuals are floats, from the expected plane, and so are the sums of a thread, so that cards with few units for
/// doubles are quick, too; everything else is double. The order of summation is fixed. Before rounding, the ground is
/// that of the CPU to about 1e-9 m and rad, with correlations to 1e-6: afterwards equal but for about one frame in a
/// hundred, in which one of its numbers is a step of `rounded` off (tests/cuda/ground_test.cu); `lost` is equal.
void estimate_ground(Cuda& cuda, const Rig& rig, const GroundConfig& config, View<const float, Device> obstacle,
                     View<const float, Device> road, const GroundPrior* prior, GroundOnDevice& space, Ground* ground,
                     int* lost);

}  // namespace stereogrid
