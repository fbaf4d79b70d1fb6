// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "stereogrid/camera.hpp"
#include "stereogrid/grid.hpp"

namespace stereogrid {

/// Origin of the extrinsics (height, pitch and roll of the camera over its ground).
enum class GroundMode : std::uint8_t {
  assumed,  ///< none given and none found: no plane is used
  found,    ///< estimated from frames; replaced only by GroundEstimator's two rules
  given,    ///< from the calibration: never replaced
};

/// Ground between two frames. Planes are relative to the level rig's camera.
struct GroundState {
  GroundMode mode{GroundMode::given};
  Ground extrinsics;                ///< values in use, with their uncertainty: change slowly
  Ground plane;                     ///< last frame's ground; `estimated`: it was measured
  std::optional<Ground> given;      ///< extrinsics of the calibration
  std::optional<Ground> candidate;  ///< `assumed`: plane that frames have weakly supported; mean of them
  int candidate_frames{0};          ///< number of these frames
  int agreeing{0};                  ///< frames that have confirmed the extrinsics, at most agreeing_min
  double unmeasured_s{0};           ///< time since the ground was measured
  std::optional<Ground> better;     ///< `found`: plane that explains the nearest ground since `better_from`
  Point2 better_from;               ///< position of the vehicle in the world frame, m
  bool on_slope{false};             ///< a slope fills the view, since `slope_from`
  Point2 slope_from;                ///< position of the vehicle in the world frame, m

  template <class State>
  void exchange(State& state) {
    state(mode, extrinsics, plane, given, candidate, candidate_frames, agreeing, unmeasured_s, better, better_from,
          on_slope, slope_from);
  }
};

/// Frames that must confirm found extrinsics before only travel can replace them.
constexpr int agreeing_min{3};

/// State before the first frame with these extrinsics. Their standard deviations are those of a measurement by hand.
GroundState first_ground(const Ground& extrinsics, GroundMode mode);

}  // namespace stereogrid
