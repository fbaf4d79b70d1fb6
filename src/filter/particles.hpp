// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "filter/particle_model.hpp"
#include "held_bytes.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

class Cpu;
struct FilterInput;
struct FilterState;
struct Reference;

/// What the particle filter remembers, and its working memory; allocated once.
struct Particles {
  Particles() = default;
  Particles(int cells, const FilterConfig& config);

  template <class State>
  void exchange(State& state) {
    const std::size_t most{particle.size()};
    state(mass, particle, count, weight, steps);
    if constexpr (requires { state.require(true); }) {
      state.require(particle.size() == most && count >= 0 && static_cast<std::size_t>(count) <= most);
    }
  }

  [[nodiscard]] std::size_t held_bytes() const { return held_bytes_of(mass, particle, arrived, cell, first, begin); }

  Image<CellMass> mass;
  std::vector<Particle> particle;  ///< moving mass, in the order of cells; `count` of them are in use
  int count{0};
  float weight{0};                ///< mass of a particle
  std::uint64_t steps{0};         ///< since the filter began
  std::vector<Particle> arrived;  ///< this step's predicted particles in the order of their cells
  std::vector<int> cell;          ///< of each predicted particle; −1: left the window
  std::vector<int> first;         ///< of each cell in `arrived`; one more at the end
  std::vector<double> begin;      ///< of each cell's moving and born mass, laid end to end; one more at the end
};

/// Whole cells by which the window has moved since the step before.
struct Scroll {
  int x;
  int y;
};
Scroll scroll_between(const GridGeometry& before, const GridGeometry& now);

/// What an image of the step before held at the place where the window's cell (x, y) is now; `outside`: not in it yet.
template <class T>
T value_before(const Image<T>& image, Scroll scroll, int x, int y, T outside) {
  const int from_x{x + scroll.x};
  const int from_y{y + scroll.y};
  if (from_x < 0 || from_x >= image.width() || from_y < 0 || from_y >= image.height()) return outside;
  return image(from_x, from_y);
}

/// Number of the cell that a particle lies in; −1: outside the window.
inline int cell_of(const Particle& particle, int cells) {
  const float limit{static_cast<float>(cells)};
  if (!(particle.x >= 0 && particle.x < limit && particle.y >= 0 && particle.y < limit)) return -1;
  return static_cast<int>(particle.y) * cells + static_cast<int>(particle.x);
}

/// Of the particles in a cell: how many, Σ v and Σ v·v.
struct ParticleSums {
  int count{0};
  float x{0};
  float y{0};
  float xx{0};
  float xy{0};
  float yy{0};

  void add(const Particle& particle) {
    ++count;
    x += particle.vx_mps;
    y += particle.vy_mps;
    xx += particle.vx_mps * particle.vx_mps;
    xy += particle.vx_mps * particle.vy_mps;
    yy += particle.vy_mps * particle.vy_mps;
  }
};

/// Age and mass of a cell, and from its mass and its particles' velocities the layers.
struct CellUpdate {
  const FilterInput& input;
  const ParticleStep& step;
  Scroll scroll;
  const FilterState& before;
  FilterState& after;
  GridLayers& layers;

  void run(int x, int y, float observed, const ParticleSums& sums) const;

 private:
  void write_motion(int x, int y, const CellMass& mass, const ParticleSums& sums) const;
};

ParticleStep particle_step_of(const FilterInput& input, std::uint64_t number);

/// Weight of the particles that stand for `total` mass: at most `available` of them, at most 256 for a full cell.
double weight_for(double total, int available);

/// One step of the particle filter (Nuss et al. 2018, in the mixed form of Nègre et al. 2014: what stands is kept in
/// the cells, what moves in particles). Arguments as for `filter`.
void filter_particles(Cpu& cpu, const FilterInput& input, View<const float> observed, const FilterState& before,
                      FilterState& after, GridLayers& layers);
void filter_particles(Reference& reference, const FilterInput& input, View<const float> observed,
                      const FilterState& before, FilterState& after, GridLayers& layers);

}  // namespace stereogrid
