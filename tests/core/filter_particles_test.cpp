// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "backend/cpu.hpp"
#include "filter_run.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

constexpr double cell_m{0.2};
constexpr int cells{40};

GridGeometry still_window() {
  return {0, 0, cell_m, cells, cells};
}

FilterConfig particle_config() {
  FilterConfig config{method_config(FilterModel::particles)};
  config.velocity_max_mps = 8;
  config.static_prior = 0;  // a prior of standstill makes the filter slower to believe in motion
  config.velocity_walk_mps = 1;
  return config;
}

// A free world with an object of 4 × 4 cells whose left edge lies at x (in cells, fractions allowed).
Image<float> scene_at(double x) {
  Image<float> observed{cells, cells, 0.02f};
  for (int ix{0}; ix < cells; ++ix) {
    const double covered{std::clamp(std::min(x + 4, ix + 1.0) - std::max(x, ix * 1.0), 0.0, 1.0)};
    for (int iy{14}; iy < 18; ++iy) observed(ix, iy) = static_cast<float>(0.02 + 0.96 * covered);
  }
  return observed;
}

// Mean velocity over the object's inner cells.
double velocity_at(const GridLayers& layers, double x) {
  return mean_over(layers.velocity_x, static_cast<int>(std::ceil(x)), 14, 3, 4);
}

ParticleStep quiet_step() {
  ParticleStep step{};
  step.kept = 1;
  step.static_prior = 0.5f;
  step.velocity_max_mps = 8;
  return step;
}

// P(occupied) = occupied + unknown/2 follows Bayes' rule, whatever the masses are; nothing is lost.
TEST(ParticleCell, FollowsBayesRule) {
  std::mt19937 generator{5};
  for (int i{0}; i < 1000; ++i) {
    const float standing{static_cast<float>(uniform(generator, 0, 0.4))};
    const float arrived{static_cast<float>(uniform(generator, 0, 0.3))};
    const float free{static_cast<float>(uniform(generator, 0, 0.3))};
    const double p{uniform(generator, 0.001, 0.999)};
    const CellMass mass{updated(quiet_step(), {standing, arrived, 0, free}, arrived,
                                {static_cast<float>(p), static_cast<float>(1 - p)})};
    const double prior{0.5 + 0.5 * (static_cast<double>(standing) + arrived - free)};
    const double occupied{mass.occupied()};
    EXPECT_NEAR(occupied + (1 - occupied - mass.free) / 2, prior * p / (prior * p + (1 - prior) * (1 - p)), 1e-5);
    EXPECT_GE(std::min({mass.standing, mass.moving, mass.born, mass.free}), 0);
    EXPECT_LE(occupied + mass.free, 1 + 1e-6);
  }
}

TEST(ParticleCell, AnUnknownObservationChangesNothing) {
  const CellMass mass{updated(quiet_step(), {0.3f, 0.2f, 0, 0.1f}, 0.2f, {0.5f, 0.5f})};
  EXPECT_FLOAT_EQ(mass.standing, 0.3f);
  EXPECT_FLOAT_EQ(mass.moving, 0.2f);
  EXPECT_FLOAT_EQ(mass.free, 0.1f);
  EXPECT_NEAR(mass.born, 0, 1e-7);
}

// The particles have left: their place is free, what was unknown stays so.
TEST(ParticleCell, IsFreeWhereParticlesHaveLeft) {
  const CellMass mass{updated(quiet_step(), {0.1f, 0.7f, 0, 0}, 0, {0.5f, 0.5f})};
  EXPECT_FLOAT_EQ(mass.standing, 0.1f);
  EXPECT_NEAR(mass.free, 0.7, 1e-6);
  EXPECT_NEAR(mass.unknown(), 0.2, 1e-6);
}

// More than a whole cell's mass arrives; free mass gives way.
TEST(ParticleCell, IsNeverMoreThanFull) {
  const CellMass mass{updated(quiet_step(), {0.9f, 0, 0, 0.1f}, 1.8f, {0.5f, 0.5f})};
  EXPECT_NEAR(mass.standing, 1.0 / 3, 1e-6);
  EXPECT_NEAR(mass.moving, 2.0 / 3, 1e-6);
  EXPECT_NEAR(mass.free, 0, 1e-6);
}

TEST(ParticleSamples, StandAtEqualDistances) {
  // 10 particles of 0.25 from 0.5 · 0.25 on: at 0.125, 0.375, 0.625 …
  EXPECT_EQ(first_sample(0, 0.25, 0.5, 10), 0);
  EXPECT_EQ(first_sample(0.125, 0.25, 0.5, 10), 0);
  EXPECT_EQ(first_sample(0.13, 0.25, 0.5, 10), 1);
  EXPECT_EQ(first_sample(1.125, 0.25, 0.5, 10), 4);
  EXPECT_EQ(first_sample(100, 0.25, 0.5, 10), 10);
  EXPECT_EQ(parent_of(0.1, {0, 0.5f, 0.2f, 0}, 5), 1);
  EXPECT_EQ(parent_of(0.4999999, {0, 0.5f, 0.2f, 0}, 5), 4);
  EXPECT_EQ(parent_of(0.5, {0, 0.5f, 0.2f, 0}, 5), -1);
  // rounding: a little before the cell
  EXPECT_EQ(parent_of(-1e-10, {0, 1e-11f, 0.2f, 0}, 5), 0);
  EXPECT_EQ(parent_of(-1e-10, {0, 1e-40f, 0.2f, 0}, 5), 0);
}

TEST(ParticleNoise, HasMeanZeroAndUnitVariance) {
  double sum{0};
  double square{0};
  double product{0};
  constexpr int count{100000};
  for (int i{0}; i < count; ++i) {
    const std::uint64_t bits{random_bits(3, static_cast<std::uint64_t>(i), Draw::velocity)};
    const double a{disturbance_of(bits, 0)};
    sum += a;
    square += a * a;
    product += a * disturbance_of(bits, 1);
  }
  EXPECT_NEAR(sum / count, 0, 0.015);
  EXPECT_NEAR(square / count, 1, 0.02);
  EXPECT_NEAR(product / count, 0, 0.015);
}

// Resampling keeps the moving mass, to a particle; particles lie in order of their cells and within the limits.
TEST(FilterParticles, ResamplingKeepsTheMass) {
  std::mt19937 generator{29};
  Cpu cpu{2};
  FilterConfig config{particle_config()};
  config.particles = 1000;
  FilterRun run{cpu, config, still_window()};
  for (int step{0}; step < 20; ++step) {
    Image<float> observed{cells, cells};
    for (float& p : observed) p = static_cast<float>(uniform(generator, 0, 1));
    run.step(observed);
    const Particles& particles{run.now.particles};
    double mass{0};
    for (const CellMass& cell : particles.mass) mass += static_cast<double>(cell.moving) + cell.born;
    ASSERT_LE(particles.count, config.particles);
    ASSERT_GT(particles.count, 900);
    EXPECT_NEAR(particles.count * static_cast<double>(particles.weight), mass, 1.01 * particles.weight);
    int last{0};
    for (int i{0}; i < particles.count; ++i) {
      const Particle& particle{particles.particle[static_cast<std::size_t>(i)]};
      const int cell{cell_of(particle, cells)};
      ASSERT_GE(cell, last);
      last = cell;
      ASSERT_LE(std::max(std::abs(particle.vx_mps), std::abs(particle.vy_mps)), 8);
    }
  }
}

TEST(FilterParticles, AnEmptyWorldStaysEmpty) {
  Cpu cpu{1};
  FilterRun run{cpu, particle_config(), still_window()};
  for (int step{0}; step < 30; ++step) run.step(Image<float>(cells, cells, 0.02f));
  EXPECT_LT(*std::max_element(run.layers.occupancy.begin(), run.layers.occupancy.end()), 0.02f);
  EXPECT_LT(run.now.particles.count * static_cast<double>(run.now.particles.weight), 0.01 * cells * cells);
}

// Speeds between those of a lattice, and that of somebody walking.
TEST(FilterParticles, FindsAnySpeed) {
  for (const double speed_mps : {1.4, 2.7, 5.3}) {
    Cpu cpu{2};
    FilterRun run{cpu, particle_config(), still_window()};
    const int steps{speed_mps > 5 ? 11 : 18};
    double x{4};
    for (int step{0}; step < steps; ++step) {
      if (step > 0) x += speed_mps * 0.1 / cell_m;
      run.step(scene_at(x));
    }
    EXPECT_NEAR(velocity_at(run.layers, x), speed_mps, 0.15 * speed_mps) << speed_mps;
    EXPECT_NEAR(mean_over(run.layers.velocity_y, static_cast<int>(std::ceil(x)), 14, 3, 4), 0, 0.4) << speed_mps;
  }
}

struct Centre {
  double x;  // in cells
  double vx_mps;
};
Centre centre_of(const Particles& particles) {
  Centre centre{0, 0};
  for (int i{0}; i < particles.count; ++i) {
    centre.x += static_cast<double>(particles.particle[static_cast<std::size_t>(i)].x) / particles.count;
    centre.vx_mps += static_cast<double>(particles.particle[static_cast<std::size_t>(i)].vx_mps) / particles.count;
  }
  return centre;
}

// What moves on unseen keeps its speed; it spreads, but loses no mass except to time.
TEST(FilterParticles, MovesWhatIsHidden) {
  Cpu cpu{2};
  FilterRun run{cpu, particle_config(), still_window()};
  for (int step{0}; step < 15; ++step) run.step(scene_at(4 + step));
  const Centre seen{centre_of(run.now.particles)};
  const float seen_mass{static_cast<float>(run.now.particles.count) * run.now.particles.weight};
  for (int step{0}; step < 6; ++step) run.step(Image<float>(cells, cells, 0.5f));
  const Centre hidden{centre_of(run.now.particles)};
  EXPECT_GT(seen.vx_mps, 1.2);
  EXPECT_NEAR(hidden.vx_mps, seen.vx_mps, 0.2);
  EXPECT_NEAR(hidden.x, seen.x + 6 * seen.vx_mps * 0.1 / cell_m, 0.7);
  EXPECT_GT(static_cast<float>(run.now.particles.count) * run.now.particles.weight, 0.8f * seen_mass);
  EXPECT_GT(mean_over(run.layers.occupancy, 24, 15, 2, 2), mean_over(run.layers.occupancy, 18, 15, 2, 2));
}

// Every second frame is missing: the time steps are longer, the speed is the same.
TEST(FilterParticles, SpeedDoesNotDependOnDroppedFrames) {
  Cpu cpu{2};
  FilterRun run{cpu, particle_config(), still_window()};
  double x{4};
  run.step(scene_at(x));
  for (const double dt_s : {0.1, 0.2, 0.2, 0.1, 0.3, 0.2, 0.2, 0.2}) {
    x += 2.4 * dt_s / cell_m;
    run.step(scene_at(x), dt_s);
  }
  EXPECT_NEAR(velocity_at(run.layers, x), 2.4, 0.4);
}

TEST(FilterParticles, WhatHasLeftTheWindowIsGone) {
  Cpu cpu{1};
  FilterRun run{cpu, particle_config(), still_window()};
  for (int step{0}; step < 6; ++step) run.step(scene(cells, 0, 0, cells, cells));
  EXPECT_GT(run.now.particles.count, 1000);
  GridGeometry elsewhere{still_window()};
  elsewhere.x_min_m += 2 * cells * cell_m;
  run.step(Image<float>(cells, cells, 0.5f), 0.1, elsewhere);
  EXPECT_EQ(run.now.particles.count, 0);
  for (const float p : run.layers.occupancy) EXPECT_EQ(p, 0.5f);
}

// Two filters on the same frames draw the same numbers; a filter that is reset begins anew.
TEST(FilterParticles, RepeatsItself) {
  Cpu cpu{2};
  FilterRun first{cpu, particle_config(), still_window()};
  FilterRun second{cpu, particle_config(), still_window()};
  for (int step{0}; step < 3; ++step) second.step(scene_at(20 - step));
  reset(second.now, second.config, still_window());
  for (int step{0}; step < 5; ++step) {
    first.step(scene_at(4 + step));
    second.step(scene_at(4 + step));
  }
  EXPECT_EQ(first.now.particles.count, second.now.particles.count);
  EXPECT_TRUE(std::equal(first.layers.velocity_x.begin(), first.layers.velocity_x.end(),
                         second.layers.velocity_x.begin(), second.layers.velocity_x.end()));
}

}  // namespace
}  // namespace stereogrid::test
