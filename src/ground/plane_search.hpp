// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "ground/plane_evidence.hpp"

namespace stereogrid {

/// Prior of a ground plane: Gaussian in (height, pitch, roll).
struct PlanePrior {
  Ground mean{0, 0, 0};
  Matrix3 precision{};  ///< inverse covariance of (m, rad, rad); a row of 0: anything

  /// Logarithm of the density, less a constant; nats.
  [[nodiscard]] double log_density(const Ground& ground) const;
};

/// Cameras whose ground is searched: height 0.12 … 4.5 m, pitch −12 … 45°, and a limited roll.
struct SearchBounds {
  double turned_rad{0};  ///< pitch of the camera relative to the levelled images, positive downwards
  double roll_sigma_rad{radians(3)};
  double roll_max_rad{radians(12)};
  std::size_t hypotheses{1500};
};

/// Prior of a camera whose extrinsics are unknown.
PlanePrior any_extrinsics_prior(const SearchBounds& bounds);
/// Prior with the mean and covariance of `ground`.
PlanePrior prior_of(const Ground& ground);

bool is_within(const Ground& ground, const SearchBounds& bounds);

/// A plane fitted to the samples of a frame.
struct FittedPlane {
  RoadPlane plane;
  Ground ground;                 ///< the same; standard deviations include the prior's information
  PlaneHypothesis hypothesis;    ///< the same, with the usual noise
  float noise_px;                ///< noise of the samples on it
  PlaneMeasurement measurement;  ///< plane by the samples alone; valid where `is_measured`
  bool is_measured{false};
  PlaneSupport support;
  double total{0};  ///< evidence and log-density of the prior, nats
};

/// Buffers of the search.
struct PlaneSearchWorkspace {
  struct Scored {
    double score;  ///< evidence and log-density of the prior, nats
    double near;   ///< the same with the evidence of the nearest half alone
    RoadPlane plane;
  };

  void reserve(std::size_t samples);
  [[nodiscard]] std::size_t memory_bytes() const {
    return memory_bytes_of(few, some, turned, order, scored, tried, found);
  }

  PlaneSamples few;                ///< rate every hypothesis
  PlaneSamples some;               ///< rate and refine the best ones
  PlaneSamples turned;             ///< samples of turned images
  std::vector<std::size_t> order;  ///< their order by row
  std::vector<Scored> scored;
  std::vector<PlaneHypothesis> tried;  ///< distinct hypotheses that have been refined
  std::vector<FittedPlane> found;
};

/// Plane of a fit, and the noise of the samples on it.
struct RefinedPlane {
  RoadPlane plane;
  float noise_px{PlaneHypothesis{}.noise_px};
};

/// Fits a plane to the samples by Gauss–Newton steps from `start`; each sample is weighted by the probability that it
/// lies on the plane. Empty: no plane below the camera. `rounds`: maximum number of steps. `weights`: see
/// equations_of.
std::optional<RefinedPlane> refined_plane(const Rig& rig, const PlaneSamples& samples, const PlanePrior& prior,
                                          RefinedPlane start, int rounds, std::span<const float> weights);
/// `refined`, with covariance and support by the samples.
FittedPlane fitted_plane(const Rig& rig, const PlaneSamples& samples, const PlanePrior& prior,
                         const RefinedPlane& refined, std::span<const float> weights);

/// The most likely distinct planes in `space.found`, best first: hypotheses through two or three samples, of which the
/// best are refined. The same samples give the same planes.
void search_planes(const Rig& rig, const PlaneSamples& samples, const SearchBounds& bounds,
                   PlaneSearchWorkspace& space);

/// The same for a camera with a roll within 48° of `quarters` of 90°. FittedPlane::ground is relative to the camera,
/// the other members to images turned by these quarters.
void search_rolled_planes(const Rig& rig, const PlaneSamples& samples, double turned_rad, int quarters,
                          PlaneSearchWorkspace& space);

}  // namespace stereogrid
