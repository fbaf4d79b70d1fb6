// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <numeric>

#include "backend/reference.hpp"
#include "filter/filter.hpp"

namespace stereogrid {
namespace {

// Predicted particles that are still in the window, in the order of their cells, each cell's in the order of before.
std::vector<Particle> predicted_particles(const ParticleStep& step, const Particles& before, Scroll scroll, int cells) {
  std::vector<Particle> all;
  for (int i{0}; i < before.count; ++i) {
    const auto index{static_cast<std::size_t>(i)};
    const Particle now{predicted(step, before.particle[index], index, scroll.x, scroll.y)};
    if (cell_of(now, cells) >= 0) all.push_back(now);
  }
  std::stable_sort(all.begin(), all.end(),
                   [&](const Particle& a, const Particle& b) { return cell_of(a, cells) < cell_of(b, cells); });
  return all;
}

std::vector<ParticleSums> sums_of(const std::vector<Particle>& particles, int cells) {
  std::vector<ParticleSums> sums(static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells));
  for (const Particle& particle : particles) sums[static_cast<std::size_t>(cell_of(particle, cells))].add(particle);
  return sums;
}

// Lays the cells' moving and born masses end to end and takes a sample at equal distances.
void resample_particles(const ParticleStep& step, const std::vector<Particle>& arrived,
                        const std::vector<ParticleSums>& sums, Particles& after) {
  const int available{static_cast<int>(after.particle.size())};
  const double offset{uniform_of(random_bits(step.number, 0, Draw::offset), 0)};
  double total{0};
  for (const CellMass& mass : after.mass) total += static_cast<double>(mass.moving) + mass.born;
  const double weight{weight_for(total, available)};
  double begin{0};
  std::size_t first{0};
  after.count = 0;
  after.weight = static_cast<float>(weight);
  for (std::size_t c{0}; c < sums.size(); ++c) {
    const CellMass& mass{after.mass.data()[c]};
    const double end{begin + (static_cast<double>(mass.moving) + mass.born)};
    for (; after.count < first_sample(end, weight, offset, available); ++after.count) {
      const int parent{parent_of((after.count + offset) * weight - begin, mass, sums[c].count)};
      const auto index{static_cast<std::size_t>(after.count)};
      const int x{static_cast<int>(c) % after.mass.width()};
      const int y{static_cast<int>(c) / after.mass.width()};
      after.particle[index] = parent < 0 ? born(step, x, y, index) : arrived[first + static_cast<std::size_t>(parent)];
    }
    first += static_cast<std::size_t>(sums[c].count);
    begin = end;
  }
}

}  // namespace

void filter_particles(Reference&, const FilterInput& input, View<const float> observed, const FilterState& before,
                      FilterState& after, GridLayers& layers) {
  const int cells{observed.width};
  const ParticleStep step{particle_step_of(input, before.particles.steps)};
  const Scroll scroll{scroll_between(before.geometry, input.geometry)};
  const std::vector<Particle> arrived{predicted_particles(step, before.particles, scroll, cells)};
  const std::vector<ParticleSums> sums{sums_of(arrived, cells)};
  after.geometry = layers.geometry = input.geometry;
  after.particles.steps = before.particles.steps + 1;
  const CellUpdate update{input, step, scroll, before, after, layers};
  for (int y{0}; y < cells; ++y) {
    for (int x{0}; x < cells; ++x) {
      update.run(x, y, observed(x, y), sums[static_cast<std::size_t>(y * cells + x)]);
    }
  }
  resample_particles(step, arrived, sums, after.particles);
}

}  // namespace stereogrid
