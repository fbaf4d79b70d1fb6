// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "ground/fit.hpp"

namespace stereogrid {
namespace {

constexpr std::size_t jury_size{4000};  // samples that rate a candidate

// Generator of the same numbers on every platform.
class Dice {
 public:
  std::size_t below(std::size_t count) {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return static_cast<std::size_t>((state_ >> 33) % count);
  }

 private:
  std::uint64_t state_{20120912};
};

// Keeps samples that fit some plane within the gates.
void keep_plausible(const Rig& rig, const GroundConfig& config, std::vector<GroundSample>& samples) {
  const double pitch_px{rig.focal_px * std::tan(config.pitch_gate_deg * std::numbers::pi / 180)};
  const double roll{std::sin(config.roll_gate_deg * std::numbers::pi / 180)};
  const double per_row{rig.baseline_m / rig.camera_height_m};
  const RoadPlane calibrated{road_plane(rig, {rig.camera_height_m, rig.camera_pitch_rad, rig.camera_roll_rad})};
  std::erase_if(samples, [&](const GroundSample& sample) {
    const double expected{calibrated.disparity(sample.u, sample.v)};
    const double slack{per_row * (pitch_px + roll * std::abs(sample.u - rig.cx_px)) +
                       std::abs(expected) * config.height_gate_m / rig.camera_height_m};
    return std::abs(sample.disparity - expected) > slack;
  });
}

// Samples on the plane, less those below it: planes through kerbs and obstacles have many. Stops where the rest cannot
// bring it above `least`.
int support_of(const std::vector<GroundSample>& samples, std::size_t stride, const RoadPlane& plane,
               double inlier_px = 1, int least = std::numeric_limits<int>::min()) {
  int support{0};
  int reachable{static_cast<int>((samples.size() + stride - 1) / stride)};
  for (std::size_t i{0}; i < samples.size() && reachable > least; i += stride) {
    const double r{residual(plane, samples[i])};
    const int change{std::abs(r) < inlier_px ? 1 : (r < -1.5 * inlier_px ? -1 : 0)};
    support += change;
    reachable += change - 1;
  }
  return support;
}

// The line through two samples in v-disparity, with the roll of `plane`.
bool put_through(const GroundSample& a, const GroundSample& b, RoadPlane& plane) {
  if (std::abs(a.v - b.v) < 5) return false;
  plane.per_v = (a.disparity - b.disparity - plane.per_u * (a.u - b.u)) / (a.v - b.v);
  plane.at_centre = 0;
  plane.at_centre = residual(plane, a);
  return plane.per_v > 0;
}

bool put_through(const GroundSample& a, const GroundSample& b, const GroundSample& c, RoadPlane& plane) {
  const double determinant{(b.u - a.u) * (c.v - a.v) - (c.u - a.u) * (b.v - a.v)};
  if (std::abs(determinant) < 2000) return false;
  const double rise_b{b.disparity - a.disparity};
  const double rise_c{c.disparity - a.disparity};
  plane.per_u = (rise_b * (c.v - a.v) - rise_c * (b.v - a.v)) / determinant;
  plane.per_v = (rise_c * (b.u - a.u) - rise_b * (c.u - a.u)) / determinant;
  plane.at_centre = 0;
  plane.at_centre = residual(plane, a);
  return plane.per_v > 0;
}

}  // namespace

bool find_plane(const Rig& rig, const GroundConfig& config, const std::vector<GroundSample>& samples, RoadPlane& plane,
                const PlaneDraws& draws) {
  const std::size_t stride{std::max<std::size_t>(samples.size() / jury_size, 1)};
  const RoadPlane start{plane};
  // another plane must have clearly more samples: the fit corrects small deviations
  int most{support_of(samples, stride, plane, draws.inlier_px) * 3 / 2};
  Dice dice;
  for (int round{0}; round < draws.rounds; ++round) {
    const GroundSample& a{samples[dice.below(samples.size())]};
    const GroundSample& b{samples[dice.below(samples.size())]};
    const GroundSample& c{samples[dice.below(samples.size())]};
    RoadPlane candidate{start};
    if (!(round % 2 == 0 ? put_through(a, b, candidate) : put_through(a, b, c, candidate))) continue;
    if (!is_within_gates(rig, config, ground_of(rig, candidate))) continue;
    const int support{support_of(samples, stride, candidate, draws.inlier_px, most)};
    if (support > most) {
      most = support;
      plane = candidate;
    }
  }
  return most > 0 && most * static_cast<int>(stride) >= ground_samples_min;
}

bool has_better_plane(const Rig& rig, const std::vector<GroundSample>& samples, int least, const RoadPlane& plane) {
  Rig any{rig};
  GroundConfig gates;
  any.camera_height_m = 2.1;
  gates.height_gate_m = 1.9;
  any.camera_pitch_rad = radians(7.5);
  gates.pitch_gate_deg = 27.5;
  any.camera_roll_rad = 0;
  gates.roll_gate_deg = 10;
  RoadPlane best{plane};
  return find_plane(any, gates, samples, best) && best != plane && support_of(samples, 1, best) >= least;
}

bool is_lost(const Rig& rig, const GroundConfig& config, View<const float> obstacle_disparity,
             View<const float> road_disparity, const Ground& ground, GroundSpace& space) {
  if (!config.estimate) return false;
  const RoadPlane plane{road_plane(rig, ground)};
  const double horizon{horizon_row(rig, ground)};
  space.samples.clear();
  add_samples(road_disparity, horizon, space.samples);
  add_samples(obstacle_disparity, horizon, space.samples);
  std::array<int, distance_bins> counts{};
  for (const GroundSample& sample : space.samples) {
    const double bin{distance_bin(residual(plane, sample))};
    if (bin >= 0 && bin < distance_bins) ++counts[static_cast<std::size_t>(bin)];
  }
  int here{0};
  int elsewhere{0};
  for (int k{2}; k < distance_bins - 1; ++k) {
    const int share{share_around([&](int bin) { return counts[static_cast<std::size_t>(bin)]; }, k)};
    int& most{is_near_the_plane(k) ? here : elsewhere};
    most = std::max(most, share);
  }
  return lies_elsewhere(here, elsewhere);
}

Ground search_ground(const Rig& rig, const GroundConfig& config, View<const float> obstacle_disparity,
                     View<const float> road_disparity, const Ground& previous, GroundSpace& space) {
  Ground fallback{previous};
  fallback.estimated = false;
  if (!config.estimate) return fallback;
  std::vector<GroundSample>& samples{space.samples};
  samples.clear();
  add_samples(road_disparity, 0, samples);
  add_samples(obstacle_disparity, 0, samples);
  keep_plausible(rig, config, samples);
  if (static_cast<int>(samples.size()) < ground_samples_min) return fallback;

  RoadPlane plane{road_plane(rig, previous)};
  const bool enough{find_plane(rig, config, samples, plane)};
  const Ground widest{calibrated_ground(rig, config)};
  const Matrix3 covariance{carried(numbers_by_ground(rig, ground_of(rig, plane)), covariance_of(widest))};
  if (!enough || refine(samples, covariance, plane) == 0) return fallback;
  const Ground found{ground_of(rig, plane)};
  return is_within_gates(rig, config, found) ? with_covariance(found, covariance_of(widest)) : fallback;
}

}  // namespace stereogrid
