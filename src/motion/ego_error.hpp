// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "memory_bytes.hpp"
#include "motion/symmetric2.hpp"
#include "stereogrid/camera.hpp"
#include "stereogrid/frame.hpp"

namespace stereogrid {

/// Velocity of an obstacle's point over the ground. World axes.
struct FlowVector {
  Point2 place;
  Symmetric2 place_covariance;  ///< m²
  Point2 velocity;
  Symmetric2 velocity_covariance;  ///< m²/s²; without `common_covariance`
  Symmetric2 common_covariance{};  ///< m²/s²; error of the ego-motion, which all vectors share
};

/// Error of the ego-motion against the disparities, measured by the features of a frame: the scale of the motion and a
/// constant offset of all disparities. It makes static objects move along the vehicle's direction, in proportion to its
/// speed. docs/method.md §9.2.
class EgoError {
 public:
  EgoError(const Rig& rig, std::size_t points_reserved);

  /// Measures the error by a frame's vectors and corrects their velocities. `vehicle`: its place in the world; `dt_s`:
  /// since the last call.
  void correct(Point2 vehicle, double dt_s, std::vector<FlowVector>& vectors);

  /// Share by which the ego-motion is too fast.
  [[nodiscard]] double scale() const { return sum_.mean().x; }
  /// Constant that all disparities are too small by.
  [[nodiscard]] double offset_px() const { return sum_.mean().y; }

  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_of(samples_); }

  template <class State>
  void exchange(State& state) {
    state(sum_.information, sum_.weighted, before_);
  }

 private:
  // Motion of the vehicle in a frame.
  struct Motion {
    Point2 place;
    Point2 direction;
    double speed_mps;
  };
  struct Sample {
    int sector;
    double misfit_mps;  // velocity along the direction, less the expected one
    double variance;
    Point2 slope;  // derivatives of the velocity by scale and offset
  };

  [[nodiscard]] Point2 slope_at(const Motion& motion, Point2 place) const;
  void take_samples(const Motion& motion, std::span<const FlowVector> vectors);
  void measure();

  double focal_baseline_pxm_;
  InformationSum sum_;              // measurements of scale and offset
  std::optional<Point2> before_{};  // the vehicle's place; none: no frame yet
  std::vector<Sample> samples_;     // working memory
};

}  // namespace stereogrid
