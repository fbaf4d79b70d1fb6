// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "ground/ground.hpp"

namespace stereogrid {
namespace {

constexpr int lattice_u{4};
constexpr int lattice_v{2};
constexpr std::size_t samples_min{200};
constexpr int rounds{500};

constexpr double radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

bool within_gate(const Ground& ground, const Ground& calibrated, const GroundConfig& config) {
  return std::abs(ground.height_m - calibrated.height_m) <= config.height_gate_m &&
         std::abs(ground.pitch_rad - calibrated.pitch_rad) <= radians(config.pitch_gate_deg) &&
         std::abs(ground.roll_rad - calibrated.roll_rad) <= radians(config.roll_gate_deg);
}

void add_samples(View<const float> disparity, std::vector<GroundSample>& samples) {
  for (int v{lattice_v / 2}; v < disparity.height; v += lattice_v) {
    for (int u{lattice_u / 2}; u < disparity.width; u += lattice_u) {
      const float d{disparity(u, v)};
      if (d > 0) samples.push_back({static_cast<float>(u), static_cast<float>(v), d});
    }
  }
}

double residual(const RoadPlane& plane, const GroundSample& sample) {
  return sample.disparity - plane.disparity(sample.u, sample.v);
}

// Solves the symmetric 3 × 3 system by elimination; false where it is singular.
bool solve(std::array<std::array<double, 4>, 3>& system, std::array<double, 3>& solution) {
  for (std::size_t pivot{0}; pivot < 3; ++pivot) {
    if (system[pivot][pivot] < 1e-9) return false;
    for (std::size_t row{pivot + 1}; row < 3; ++row) {
      const double factor{system[row][pivot] / system[pivot][pivot]};
      for (std::size_t column{pivot}; column < 4; ++column) system[row][column] -= factor * system[pivot][column];
    }
  }
  for (std::size_t row{3}; row-- > 0;) {
    solution[row] = system[row][3];
    for (std::size_t column{row + 1}; column < 3; ++column) solution[row] -= system[row][column] * solution[column];
    solution[row] /= system[row][row];
  }
  return true;
}

// One least-squares step on the samples within `inlier_px` of the plane; false where they do not determine one.
bool refit(const std::vector<GroundSample>& samples, double inlier_px, RoadPlane& plane) {
  std::array<std::array<double, 4>, 3> system{};
  std::size_t inliers{0};
  for (const GroundSample& sample : samples) {
    const double r{residual(plane, sample)};
    if (std::abs(r) > inlier_px) continue;
    ++inliers;
    // scaled so that the three unknowns are of like size
    const std::array<double, 4> row{1, (sample.u - plane.centre_u_px) / 100, (sample.v - plane.centre_v_px) / 100, r};
    for (std::size_t i{0}; i < 3; ++i) {
      for (std::size_t j{0}; j < 4; ++j) system[i][j] += row[i] * row[j];
    }
  }
  if (inliers < samples_min) return false;
  // keeps the tilt of a narrow or short strip of road from running away
  for (std::size_t i{0}; i < 3; ++i) system[i][i] += 1e-3 * static_cast<double>(inliers);
  std::array<double, 3> step{};
  if (!solve(system, step)) return false;
  plane.at_centre += step[0];
  plane.per_u += step[1] / 100;
  plane.per_v += step[2] / 100;
  return plane.per_v > 0;
}

bool refine(const std::vector<GroundSample>& samples, RoadPlane& plane) {
  for (const double inlier_px : {2.5, 1.5, 1.0, 0.75, 0.75}) {
    if (!refit(samples, inlier_px, plane)) return false;
  }
  return true;
}

double blended(double previous, double measured, double weight) {
  return measured + weight * (previous - measured);
}

// A small generator, so that the search takes the same pairs everywhere.
class Dice {
 public:
  std::size_t below(std::size_t count) {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return static_cast<std::size_t>((state_ >> 33) % count);
  }

 private:
  std::uint64_t state_{20120912};
};

// Samples that some plane within the gate could explain.
void keep_plausible(const Rig& rig, const GroundConfig& config, const Ground& calibrated,
                    std::vector<GroundSample>& samples) {
  const double pitch_px{rig.focal_px * std::tan(radians(config.pitch_gate_deg))};
  const double per_row{rig.baseline_m / calibrated.height_m};
  const double horizon{horizon_row(rig, calibrated)};
  std::erase_if(samples, [&](const GroundSample& sample) {
    const double expected{per_row * (sample.v - horizon)};
    const double slack{per_row * pitch_px + expected * config.height_gate_m / calibrated.height_m};
    return sample.v < horizon || std::abs(sample.disparity - expected) > slack;
  });
}

std::size_t count_inliers(const std::vector<GroundSample>& samples, const RoadPlane& plane) {
  return static_cast<std::size_t>(std::count_if(samples.begin(), samples.end(), [&](const GroundSample& sample) {
    return std::abs(residual(plane, sample)) < 1.0;
  }));
}

}  // namespace

GroundSpace::GroundSpace(int width, int height) {
  samples.reserve(2 * static_cast<std::size_t>(width / lattice_u + 1) *
                  static_cast<std::size_t>(height / lattice_v + 1));
}

Ground estimate_ground(const Rig& rig, const GroundConfig& config, View<const float> road_disparity,
                       const Ground& previous, GroundSpace& space) {
  Ground carried{previous};
  carried.estimated = false;
  if (!config.estimate) return carried;
  space.samples.clear();
  add_samples(road_disparity, space.samples);
  RoadPlane plane{road_plane(rig, previous)};
  if (!refine(space.samples, plane)) return carried;
  const Ground measured{ground_of(rig, plane)};
  const Ground calibrated{rig.camera_height_m, rig.camera_pitch_rad, rig.camera_roll_rad};
  if (!within_gate(measured, calibrated, config)) return carried;
  const double weight{previous.estimated ? config.smoothing : 0.0};
  return {blended(previous.height_m, measured.height_m, weight),
          blended(previous.pitch_rad, measured.pitch_rad, weight),
          blended(previous.roll_rad, measured.roll_rad, weight), true};
}

Ground search_ground(const Rig& rig, const GroundConfig& config, View<const float> obstacle_disparity,
                     View<const float> road_disparity, const Ground& calibrated, GroundSpace& space) {
  Ground fallback{calibrated};
  fallback.estimated = false;
  if (!config.estimate) return fallback;
  space.samples.clear();
  add_samples(road_disparity, space.samples);
  add_samples(obstacle_disparity, space.samples);
  keep_plausible(rig, config, calibrated, space.samples);
  if (space.samples.size() < samples_min) return fallback;

  Dice dice;
  RoadPlane best{road_plane(rig, calibrated)};
  std::size_t most{count_inliers(space.samples, best)};
  for (int round{0}; round < rounds; ++round) {
    const GroundSample& a{space.samples[dice.below(space.samples.size())]};
    const GroundSample& b{space.samples[dice.below(space.samples.size())]};
    if (std::abs(a.v - b.v) < 5) continue;
    RoadPlane plane{best};
    plane.per_v = (a.disparity - b.disparity) / (a.v - b.v);
    plane.at_centre = 0;
    plane.at_centre = residual(plane, a);
    if (plane.per_v <= 0 || !within_gate(ground_of(rig, plane), calibrated, config)) continue;
    const std::size_t inliers{count_inliers(space.samples, plane)};
    if (inliers > most) {
      most = inliers;
      best = plane;
    }
  }
  if (most < samples_min || !refine(space.samples, best)) return fallback;
  const Ground found{ground_of(rig, best)};
  return within_gate(found, calibrated, config) ? found : fallback;
}

}  // namespace stereogrid
