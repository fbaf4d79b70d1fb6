// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "clamped_to_int.hpp"
#include "filter/model.hpp"
#include "host_device.hpp"

namespace stereogrid {

/// A piece of moving mass. All particles of a state weigh the same.
struct Particle {
  float x;  ///< in cells, from the window's corner
  float y;
  float vx_mps;  ///< world axes
  float vy_mps;
};

/// Constants of one step of the particle filter.
struct ParticleStep {
  std::uint64_t number;     ///< of the step: random numbers depend on it and on the particle's index alone
  float kept;               ///< share of all evidence that is still believed after dt
  float starting;           ///< share of the standing mass that starts to move
  float renewed;            ///< share of the moving mass whose velocity is forgotten
  float static_prior;       ///< share of newly born mass that stands
  float velocity_max_mps;   ///< along each axis
  float velocity_walk_mps;  ///< standard deviation of a velocity's change within dt, along each axis
  float position_walk;      ///< standard deviation of a position's change within dt, in cells
  float cells_per_mps;      ///< dt over the cell size
};

/// What the random bits of a step and an index are for.
enum class Draw : std::uint64_t { velocity, position, birth_place, birth_velocity, offset };

/// Counter-based random bits (the finaliser of SplitMix64; Steele, Lea, Flood 2014), the same in every order.
STEREOGRID_HD inline std::uint64_t mixed(std::uint64_t bits) {
  bits = (bits ^ (bits >> 30)) * 0xbf58476d1ce4e5b9ull;
  bits = (bits ^ (bits >> 27)) * 0x94d049bb133111ebull;
  return bits ^ (bits >> 31);
}
STEREOGRID_HD inline std::uint64_t random_bits(std::uint64_t step, std::uint64_t index, Draw draw) {
  return mixed(mixed(step * 8 + static_cast<std::uint64_t>(draw) + 1) + (index + 1) * 0x9e3779b97f4a7c15ull);
}

/// Number `part` of the four in [0, 1) that 64 random bits hold.
STEREOGRID_HD inline float uniform_of(std::uint64_t bits, int part) {
  return (static_cast<float>((bits >> (16 * part)) & 0xffff) + 0.5f) / 65536;
}

/// Mean 0, standard deviation 1: the sum of parts 2·axis and 2·axis + 1, a triangle. No table, no logarithm.
STEREOGRID_HD inline float disturbance_of(std::uint64_t bits, int axis) {
  constexpr float root_of_6{2.44948974f};
  return (uniform_of(bits, 2 * axis) + uniform_of(bits, 2 * axis + 1) - 1) * root_of_6;
}

STEREOGRID_HD inline float within(float value, float limit) {
  value = value > limit ? limit : value;
  return value < -limit ? -limit : value;
}

/// Where a particle of the step before is now, in a window that has moved on by (moved_x, moved_y) cells. Constant
/// velocity with noise; the velocity is the mean of before and after.
STEREOGRID_HD inline Particle predicted(const ParticleStep& step, const Particle& before, std::uint64_t index,
                                        int moved_x, int moved_y) {
  const std::uint64_t push{random_bits(step.number, index, Draw::velocity)};
  const std::uint64_t shake{random_bits(step.number, index, Draw::position)};
  Particle now{before};
  now.vx_mps = within(before.vx_mps + step.velocity_walk_mps * disturbance_of(push, 0), step.velocity_max_mps);
  now.vy_mps = within(before.vy_mps + step.velocity_walk_mps * disturbance_of(push, 1), step.velocity_max_mps);
  now.x += 0.5f * (before.vx_mps + now.vx_mps) * step.cells_per_mps + step.position_walk * disturbance_of(shake, 0);
  now.y += 0.5f * (before.vy_mps + now.vy_mps) * step.cells_per_mps + step.position_walk * disturbance_of(shake, 1);
  now.x -= static_cast<float>(moved_x);
  now.y -= static_cast<float>(moved_y);
  return now;
}

/// A new particle somewhere in cell (x, y). Its velocity is uniform in a square whose size is uniform too: slow things
/// are more frequent, and a slow velocity needs more particles to be told from its neighbours.
STEREOGRID_HD inline Particle born(const ParticleStep& step, int x, int y, std::uint64_t index) {
  const std::uint64_t place{random_bits(step.number, index, Draw::birth_place)};
  const std::uint64_t motion{random_bits(step.number, index, Draw::birth_velocity)};
  const float size_mps{step.velocity_max_mps * uniform_of(motion, 0)};
  return {static_cast<float>(x) + uniform_of(place, 0), static_cast<float>(y) + uniform_of(place, 1),
          size_mps * (2 * uniform_of(motion, 1) - 1), size_mps * (2 * uniform_of(motion, 2) - 1)};
}

/// Masses of a cell after an update.
struct CellMass {
  float standing{0};
  float moving{0};  ///< of the particles that have arrived
  float born{0};    ///< of particles yet to be drawn
  float free{0};

  STEREOGRID_HD float occupied() const { return standing + moving + born; }
  STEREOGRID_HD float unknown() const { return 1 - occupied() - free; }
};

/// Prediction and update of a cell (docs/method.md §8.8), Nuss et al. 2018 with three departures: what stands needs no
/// particles; the place of mass that has moved away is free, not unknown; and the unknown mass counts as half occupied
/// and half free in Bayes' rule: as much of it as the observation is sure then becomes one of them. What becomes
/// occupied so is new born, what was occupied persists. `before`: of the step before; `arrived`: mass of the particles
/// that are in the cell now.
STEREOGRID_HD inline CellMass updated(const ParticleStep& step, const CellMass& before, float arrived,
                                      Likelihood likelihood) {
  const float believed{before.standing * step.kept};
  const float all{believed + arrived};
  const float occupied{all > 1 ? 1.0f : all};
  const float forgotten{1 - step.kept * (1 - before.unknown())};
  const float left_over{1 - occupied - before.free * step.kept};
  const float unknown{left_over < 0 ? 0.0f : (left_over < forgotten ? left_over : forgotten)};
  const float still_free{1 - occupied - unknown};
  const float half_unknown{0.5f * unknown};
  const float evidence{likelihood.occupied * (occupied + half_unknown) +
                       likelihood.empty * (still_free + half_unknown)};
  const float doubt{likelihood.occupied < likelihood.empty ? likelihood.occupied : likelihood.empty};
  const float still_unknown{2 * doubt * doubt / (likelihood.occupied + likelihood.empty) * half_unknown / evidence};
  const float persistent{likelihood.occupied / evidence * (all > 1 ? 1 / all : 1.0f)};
  const float arisen{likelihood.occupied * half_unknown / evidence - still_unknown};
  const float newly{(arisen > 0 ? arisen : 0.0f) + arrived * step.renewed * persistent};
  const float freed{likelihood.empty * (still_free + half_unknown) / evidence - still_unknown};
  CellMass mass{};
  mass.standing = believed * (1 - step.starting) * persistent + step.static_prior * newly;
  mass.moving = arrived * (1 - step.renewed) * persistent;
  mass.born = believed * step.starting * persistent + (1 - step.static_prior) * newly;
  mass.free = freed > 0 ? freed : 0.0f;
  return mass;
}

/// Systematic resampling: sample j stands at (j + offset)·weight along the cells' masses laid end to end. The first
/// sample at or after `begin`, at most `limit`.
STEREOGRID_HD inline int first_sample(double begin, double weight, double offset, int limit) {
  const double position{begin / weight - offset};
  if (position <= 0) return 0;
  if (position >= limit) return limit;
  const int whole{clamped_to_int(position)};
  return whole < position ? whole + 1 : whole;
}

/// The particle, of `count` in the cell, that a sample at `position` along the cell's mass is a copy of; −1: a new one.
STEREOGRID_HD inline int parent_of(double position, const CellMass& mass, int count) {
  if (!(position < mass.moving)) return -1;
  // rounding may put the sample a little before the cell, and next to a tiny mass that is far
  const int parent{clamped_to_int(position / mass.moving * count)};
  return parent < 0 ? 0 : (parent < count ? parent : count - 1);
}

}  // namespace stereogrid
