// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"

#include <algorithm>
#include <utility>

#include "filter/filter.hpp"

namespace stereogrid {
namespace {

constexpr int rows_grain{4};
constexpr int particles_grain{4096};

std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

// The predicted particles by counting sort: stable, so that sums are formed in the order of the reference.
void predict(Cpu& cpu, const ParticleStep& step, const Particles& before, Scroll scroll, Particles& after) {
  const int cells{after.mass.width()};
  std::vector<Particle>& moved{after.particle};  // overwritten when they are resampled
  cpu.for_ranges(before.count, particles_grain, [&](int begin, int end) {
    for (int i{begin}; i < end; ++i) {
      moved[index(i)] = predicted(step, before.particle[index(i)], index(i), scroll.x, scroll.y);
      after.cell[index(i)] = cell_of(moved[index(i)], cells);
    }
  });
  // first[c + 1] counts cell c, then becomes where it begins, and in the end where cell c + 1 does
  std::vector<int>& first{after.first};
  std::fill(first.begin(), first.end(), 0);
  for (int i{0}; i < before.count; ++i) {
    if (after.cell[index(i)] >= 0) ++first[index(after.cell[index(i)]) + 1];
  }
  int sum{0};
  for (std::size_t c{1}; c < first.size(); ++c) sum += std::exchange(first[c], sum);
  for (int i{0}; i < before.count; ++i) {
    if (after.cell[index(i)] < 0) continue;
    after.arrived[index(first[index(after.cell[index(i)]) + 1]++)] = moved[index(i)];
  }
}

void update_rows(const CellUpdate& update, View<const float> observed, int begin, int end) {
  const Particles& particles{update.after.particles};
  for (int y{begin}; y < end; ++y) {
    for (int x{0}; x < observed.width; ++x) {
      const std::size_t c{index(y * observed.width + x)};
      ParticleSums sums;
      for (int i{particles.first[c]}; i < particles.first[c + 1]; ++i) sums.add(particles.arrived[index(i)]);
      update.run(x, y, observed(x, y), sums);
    }
  }
}

// The samples that fall to the cells of some rows.
void resample_rows(const ParticleStep& step, double weight, double offset, Particles& after, int first_row,
                   int last_row) {
  const int cells{after.mass.width()};
  const int available{static_cast<int>(after.particle.size())};
  for (std::size_t c{index(first_row * cells)}; c < index(last_row * cells); ++c) {
    const int end{first_sample(after.begin[c + 1], weight, offset, available)};
    for (int i{first_sample(after.begin[c], weight, offset, available)}; i < end; ++i) {
      const double position{(i + offset) * weight - after.begin[c]};
      const int parent{parent_of(position, after.mass.data()[c], after.first[c + 1] - after.first[c])};
      after.particle[index(i)] = parent < 0
                                     ? born(step, static_cast<int>(c) % cells, static_cast<int>(c) / cells, index(i))
                                     : after.arrived[index(after.first[c] + parent)];
    }
  }
}

void resample_particles(Cpu& cpu, const ParticleStep& step, Particles& after) {
  const int cells{after.mass.width()};
  const int available{static_cast<int>(after.particle.size())};
  for (std::size_t c{0}; c < after.mass.size(); ++c) {
    const CellMass& mass{after.mass.data()[c]};
    after.begin[c + 1] = after.begin[c] + (static_cast<double>(mass.moving) + mass.born);
  }
  const double offset{uniform_of(random_bits(step.number, 0, Draw::offset), 0)};
  const double weight{weight_for(after.begin.back(), available)};
  after.weight = static_cast<float>(weight);
  after.count = first_sample(after.begin.back(), weight, offset, available);
  cpu.for_ranges(cells, rows_grain,
                 [&](int begin, int end) { resample_rows(step, weight, offset, after, begin, end); });
}

}  // namespace

void filter_particles(Cpu& cpu, const FilterInput& input, View<const float> observed, const FilterState& before,
                      FilterState& after, GridLayers& layers) {
  const ParticleStep step{particle_step_of(input, before.particles.steps)};
  const Scroll scroll{scroll_between(before.geometry, input.geometry)};
  after.geometry = layers.geometry = input.geometry;
  after.particles.steps = before.particles.steps + 1;
  predict(cpu, step, before.particles, scroll, after.particles);
  const CellUpdate update{input, step, scroll, before, after, layers};
  cpu.for_ranges(observed.height, rows_grain, [&](int begin, int end) { update_rows(update, observed, begin, end); });
  resample_particles(cpu, step, after.particles);
}

}  // namespace stereogrid
