// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "ground/plane_numbers.hpp"
#include "memory_bytes.hpp"

namespace stereogrid {

/// exp(x) for −80 ≤ x ≤ 0; smaller x are clamped. Relative error below 1e-5. The same bits on every platform, and
/// vectorised by compilers.
inline float exp_of(float x) {
  constexpr float log2_e{1.44269504F};
  const float scaled{(x < -80 ? -80 : x) * log2_e};
  const int whole{static_cast<int>(scaled)};
  const float f{scaled - static_cast<float>(whole)};  // −1 < f ≤ 0
  // Chebyshev approximation of 2^f
  const float power{0.9999981F + f * (0.6930507F + f * (0.23943922F + f * (0.05322683F + f * 0.00684199F)))};
  return power * std::bit_cast<float>((whole + 127) << 23);
}

/// Natural logarithm of a normal positive number. Absolute error below 2e-5.
inline float ln_of(float x) {
  constexpr float ln_2{0.69314718F};
  const std::int32_t bits{std::bit_cast<std::int32_t>(x)};
  const float t{std::bit_cast<float>((bits & 0x007fffff) | 0x3f800000) - 1};  // 0 ≤ t < 1
  // Chebyshev approximation of ln(1 + t)/t
  const float series{0.99999183F +
                     t * (-0.4993726F + t * (0.32529515F + t * (-0.2102937F + t * (0.10150005F - t * 0.02397957F))))};
  return static_cast<float>((bits >> 23) - 127) * ln_2 + t * series;
}

/// 1/√x of a normal positive number. Relative error below 1e-5.
inline float inverse_root_of(float x) {
  float y{std::bit_cast<float>(0x5f375a86 - (std::bit_cast<std::int32_t>(x) >> 1))};
  for (int round{0}; round < 2; ++round) y = y * (1.5F - 0.5F * x * y * y);
  return y;
}

/// Disparities of a frame at lattice pixels, of either hypothesis, in the order of their rows.
struct PlaneSamples {
  [[nodiscard]] std::size_t size() const { return x.size(); }
  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_of(x, y, disparity, weight, fit_weight); }
  void reserve(std::size_t count);
  void clear();

  std::vector<float> x;           ///< u − cx_px
  std::vector<float> y;           ///< v − cy_px
  std::vector<float> disparity;   ///< px
  std::vector<float> weight;      ///< part of an independent observation; a block of 32 × 32 px is one
  std::vector<float> fit_weight;  ///< weight in the fit around an expected plane: less for samples matched as upright
  float first_x{0};               ///< left border of the image, less cx_px
  float last_x{0};                ///< right border
  float last_y{0};                ///< lowest row that can have samples, less cy_px
  float disparities{0};           ///< number of disparities searched
  float noise_px{0.5F};           ///< standard deviation of disparities on ground
};

/// Side of a square whose samples are one independent observation: errors of neighbours are alike, on one thing and
/// within a window of the matcher.
inline int block_px(const Rig& rig) {
  return std::clamp(rig.width_px / 20, 12, 32);
}

/// Number of such squares in the image, whole or not.
inline std::size_t blocks_of(const Rig& rig) {
  const int side{block_px(rig)};
  return static_cast<std::size_t>(rig.width_px / side + 1) * static_cast<std::size_t>(rig.height_px / side + 1);
}

/// Sets `out` to `samples`. `spacing_px`: distance of neighbouring samples in rows and columns. `last_row`: lowest
/// image row that is not masked. `counts`: scratch.
void weigh(const Rig& rig, std::span<const GroundSample> samples, double spacing_px, int last_row, int disparities,
           std::vector<int>& counts, PlaneSamples& out);

/// A plane as the evidence needs it: its disparities are those of RoadPlane.
struct PlaneHypothesis {
  PlaneHypothesis() = default;
  PlaneHypothesis(const RoadPlane& plane, const Rig& rig, const PlaneSamples& samples);

  [[nodiscard]] float expected(float x, float y) const { return at_centre + per_u * x + per_v * y; }

  float at_centre{0};
  float per_u{0};
  float per_v{0};
  float flatness{0.02F};  ///< unevenness of ground, share of the disparity: roads are cambered
  float noise_px{0.5F};   ///< standard deviation of the matcher's disparities on ground
  float near_px{1};       ///< largest disparity in view that can be matched
  float per_half_px{2};   ///< 2 / near_px
  float per_path_px{0};   ///< expected disparity at the border of the vehicle's path, per px from the image's centre
};

/// Smallest expected disparity of ground whose distance is known well enough to distinguish planes, px.
constexpr float ground_px_min{1.5F};

/// Weight of a sample by distance, 0.15 … 1: the nearest half of the view counts fully, slopes and stairs ahead less.
inline float weight_of_distance(float expected, float per_half_px) {
  constexpr float far_weight{0.15F};
  const float share{expected * per_half_px};
  const float bounded{share < 1 ? share : 1};
  return bounded < far_weight ? far_weight : bounded;
}

/// Likelihood of one disparity if the plane is the ground, by visibility: a sample lies on the ground, above it
/// (obstacles stand on ground: neutral) or below it (ground is opaque: unlikely).
struct PlaneTerm {
  float evidence;   ///< ln(p(d | plane) / p(d | no ground)), nats; 0 where the plane cannot be seen
  float on;         ///< probability that the sample is on the plane
  float precision;  ///< 1/σ² of samples on the plane, px⁻²
  float residual;   ///< d − expected, px
  float weight;     ///< weight_of_distance; 0 where the plane cannot be seen
};

inline float variance_of(float expected, const PlaneHypothesis& plane) {
  const float uneven{plane.flatness * expected};
  return plane.noise_px * plane.noise_px + uneven * uneven;
}

inline PlaneTerm term_of(const PlaneHypothesis& plane, float disparities, float x, float y, float d) {
  constexpr float on_share{0.5F};
  constexpr float above_share{0.47F};
  constexpr float above_share_ahead{0.12F};  // in front of the wheels the space is free: the vehicle stands there
  constexpr float below_share{0.03F};        // mirrors and mismatches
  constexpr float ahead_part{0.7F};          // share of near_px
  constexpr float least_range_px{4};
  constexpr float inverse_root_2pi{0.39894228F};
  const float e{plane.expected(x, y)};
  const float r{d - e};
  const float variance{variance_of(e, plane)};
  const float root{inverse_root_of(variance)};
  const float precision{root * root};
  const float normal{on_share * inverse_root_2pi * root * exp_of(-0.5F * r * r * precision)};
  const float across{(x < 0 ? -x : x) * plane.per_path_px};
  // sequential selects: compilers vectorise no other conditions
  float above{across <= e ? above_share_ahead : above_share};
  above = e >= ahead_part * plane.near_px ? above : above_share;
  const float range{disparities - e};
  const float side{r > 0 ? above : below_share};
  const float width{r > 0 ? range : e};
  const float all{normal + side / (width < least_range_px ? least_range_px : width)};
  float seen{e > ground_px_min ? 1.0F : 0.0F};  // the plane is there, and can be matched
  seen = range > 1 ? seen : 0.0F;
  return {seen * ln_of(all * disparities), seen * normal / all, precision, r,
          seen * weight_of_distance(e, plane.per_half_px)};
}

/// Evidence of a plane, without prior, in nats, and what it rests on. Counts are sums of weights.
struct PlaneSupport {
  double evidence{0};
  double on{0};
  double below{0};
  double near_all{0};     ///< samples in the nearest half of the view: at least half of the largest disparity
  double near_on{0};      ///< samples among them on the plane
  double ring_all{0};     ///< samples of the nearest ground: at least 0.7 of the largest disparity
  double ring_on{0};      ///< samples among them on the plane
  double depth_ratio{1};  ///< 90th percentile of the expected disparities on the plane, relative to the 10th

  [[nodiscard]] double near_share() const { return near_all > 0 ? near_on / near_all : 0; }
};

/// Sum of PlaneSupport::evidence alone, and its part from the nearest half of the view.
struct PlaneEvidence {
  double all{0};
  double near{0};
};
PlaneEvidence evidence_of(const PlaneHypothesis& plane, const PlaneSamples& samples);
PlaneSupport support_of(const PlaneHypothesis& plane, const PlaneSamples& samples);

/// Evidence of p less that of q over the nearest samples, of at least 0.6 of the largest disparity that either expects
/// in view. Nats.
double ring_margin(const PlaneHypothesis& p, const PlaneHypothesis& q, const PlaneSamples& samples);

/// True where p and q cannot both be the ground: they differ by more than 3 σ of a sample over most of the nearest 60 %
/// of the view.
bool are_in_conflict(const PlaneHypothesis& p, const PlaneHypothesis& q, const PlaneSamples& samples);

/// Normal equations of the samples on a plane, weighted by the probability that they are; complete. Units of
/// numbers_of(RoadPlane). `weights`: of PlaneSamples.
struct PlaneEquations {
  Matrix3 matrix{};
  Vector3 vector{};
  float deviation_px{0};  ///< median distance of the samples around the plane
};
PlaneEquations equations_of(const PlaneHypothesis& plane, const PlaneSamples& samples, std::span<const float> weights);

}  // namespace stereogrid
