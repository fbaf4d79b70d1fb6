// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/cuda.hpp"
#include "ground/fit_model.hpp"

namespace stereogrid {

/// Where the lattice has no road pixel, in px.
constexpr float no_ground_sample{1e30f};

/// What the fit starts from.
struct GroundPrior {
  Ground before;
  RoadPlane expected;
  Matrix3 covariance;  ///< of the plane's numbers
  int first_row;       ///< of the lattice, that the fit reads
  int horizon_row;     ///< of the lattice, that the distances are counted from
};

/// What the fit ends with.
struct GroundFit {
  RoadPlane plane;
  FitSums sums;
  int is_determined;
};

/// Working memory of this stage on the device.
struct GroundOnDevice {
  GroundOnDevice(int width, int height);

  DeviceImage<float> residual;      ///< of the lattice's road pixels from the expected plane, or no_ground_sample
  DeviceBuffer<int> distances;      ///< pixels by their distance from it
  DeviceBuffer<GroundPrior> prior;  ///< one
  DeviceBuffer<GroundFit> fit;      ///< one
};

/// `refine` and `measure` of fit.hpp. A part of estimate_ground.
void fit_plane(Cuda& cuda, View<const float, Device> residual, const GroundPrior* prior, GroundFit* fit);

/// `estimate_ground` and `is_lost` of ground.hpp at once, since both read the same lattice of pixels. All pointers are
/// on the device: `previous` is the ground dt_s ago, `ground` (may be the same) gets this frame's, `lost` 1 or 0.
///
/// Residuals are floats, from the expected plane, and so are the sums of a thread, so that cards with few units for
/// doubles are quick, too; everything else is double. The order of summation is fixed. Before rounding, the ground is
/// that of the CPU to about 1e-9 m and rad: afterwards equal but for one frame in a thousand, whose ground is a step of
/// 2⁻²⁰ off (tests/cuda/ground_test.cu); `lost` is equal.
void estimate_ground(Cuda& cuda, const Rig& rig, const GroundConfig& config, View<const float, Device> obstacle,
                     View<const float, Device> road, const Ground* previous, const double* dt_s, GroundOnDevice& space,
                     Ground* ground, int* lost);

}  // namespace stereogrid
