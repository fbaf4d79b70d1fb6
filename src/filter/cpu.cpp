// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "backend/reference.hpp"
#include "filter/evidence_simd.hpp"
#include "filter/filter.hpp"
#include "filter/lattice_simd.hpp"

namespace stereogrid {
namespace {

// What the prediction needs to know about each cell of the state before, and each velocity.
void prepare(const FilterInput& input, const FilterStep& step, Scroll scroll, const FilterState& before,
             FilterSpace& space) {
  const double cells_per_mps{input.dt_s / input.geometry.cell_size_m};
  for (std::size_t k{0}; k < space.from.size(); ++k) {
    const Point2 v{input.tables.lattice[k]};
    space.from[k] = antecedents(v.x * cells_per_mps, v.y * cells_per_mps, scroll.x, scroll.y);
  }
  const bool joint{input.config.model == FilterModel::joint};
  const Image<float>& standing{before.velocity[before.velocity.size() / 2]};
  for (std::size_t c{0}; c < standing.size(); ++c) {
    const float all{joint ? before.occupancy.data()[c] : 1.0f};
    space.gained.data()[c] = gained_by_moving(step, all, standing.data()[c]);
    space.standing.data()[c] = disturbed_standing(step, all, standing.data()[c]);
    space.still_occupied.data()[c] = still_occupied(step, before.occupancy.data()[c]);
  }
}

// Age before the step of what is now at the window's cell (x, y); infinite: never seen.
float age_before(const Image<float>& age_s, Scroll scroll, int x, int y) {
  const int from_x{x + scroll.x};
  const int from_y{y + scroll.y};
  const bool is_inside{from_x >= 0 && from_x < age_s.width() && from_y >= 0 && from_y < age_s.height()};
  return is_inside ? age_s(from_x, from_y) : std::numeric_limits<float>::infinity();
}

// A tile of cells through the filter.
class TileFilter {
 public:
  TileFilter(const FilterInput& input, View<const float> observed, const LatticeTile& tile, GridLayers& layers)
      : input_{input}, observed_{observed}, tile_{tile}, layers_{layers} {}

  void run() const {
    for (int y{tile_.y_begin}; y < tile_.y_end; ++y) begin_row(y);
    input_.config.model == FilterModel::joint ? run_joint() : run_tay();
    for (int y{tile_.y_begin}; y < tile_.y_end; ++y) end_row(y);
  }

 private:
  [[nodiscard]] Likelihood likelihood_at(int x, int y) const {
    return likelihood_of(input_.tables.likelihood.data(), observed_(x, y));
  }

  void begin_row(int y) const {
    for (int x{tile_.x_begin}; x < tile_.x_end; ++x) {
      tile_.after.age_s(x, y) = age_before(tile_.before.age_s, tile_.scroll, x, y);
    }
  }

  void end_row(int y) const {
    for (int x{tile_.x_begin}; x < tile_.x_end; ++x) {
      const bool seen{is_known(observed_(x, y))};
      float& age_s{tile_.after.age_s(x, y)};
      age_s = layers_.age_s(x, y) = seen ? 0.0f : age_s + static_cast<float>(input_.dt_s);
    }
  }

  void write(int x, int y, float occupancy, float standing, const VelocitySums& sums) const {
    tile_.after.occupancy(x, y) = layers_.occupancy(x, y) = occupancy;
    layers_.moving(x, y) = moving_share(occupancy, standing);
    write_velocity(estimate_of(sums), x, y, layers_);
  }

  void run_joint() const {
    predict_joint(tile_);
    const Image<float>& standing{tile_.after.velocity[tile_.after.velocity.size() / 2]};
    for (int y{tile_.y_begin}; y < tile_.y_end; ++y) {
      TileSums sums;
      sum_velocities(tile_, y, sums);
      float scale[tile_columns];
      float born[tile_columns];
      float born_standing[tile_columns];
      for (int x{tile_.x_begin}; x < tile_.x_end; ++x) {
        const int i{x - tile_.x_begin};
        const JointUpdate update{joint_update(tile_.step, sums.mass[i], tile_.after.age_s(x, y), likelihood_at(x, y),
                                              view_of(tile_.step, x, y))};
        scale[i] = update.scale;
        born[i] = update.born_moving;
        born_standing[i] = update.born_standing;
        write(x, y, update.occupancy, update.scale * standing(x, y) + update.born_standing,
              updated(tile_.step, update, sums.at(i)));
      }
      rescale(tile_, y, scale, born, born_standing);
    }
  }

  void run_tay() const {
    TayRow rows[tile_rows];
    for (int y{tile_.y_begin}; y < tile_.y_end; ++y) {
      for (int x{tile_.x_begin}; x < tile_.x_end; ++x) {
        const Likelihood likelihood{likelihood_at(x, y)};
        rows[y - tile_.y_begin].likelihood_occupied[x - tile_.x_begin] = likelihood.occupied;
        rows[y - tile_.y_begin].likelihood_empty[x - tile_.x_begin] = likelihood.empty;
      }
    }
    predict_tay(tile_, rows);
    for (int y{tile_.y_begin}; y < tile_.y_end; ++y) {
      const TayRow& row{rows[y - tile_.y_begin]};
      float scale[tile_columns];
      const float born[tile_columns]{};
      for (int x{tile_.x_begin}; x < tile_.x_end; ++x) {
        const int i{x - tile_.x_begin};
        scale[i] = 1 / row.evidence[i];
        write(x, y, scale[i] * row.sums.mass[i], scale[i] * row.standing[i], row.sums.at(i));
      }
      rescale(tile_, y, scale, born, born);
    }
  }

  const FilterInput& input_;
  View<const float> observed_;
  const LatticeTile& tile_;
  GridLayers& layers_;
};

}  // namespace

void filter(Cpu& cpu, const FilterInput& input, View<const float> observed, const FilterState& before,
            FilterState& after, GridLayers& layers) {
  after.geometry = layers.geometry = input.geometry;
  const FilterStep step{step_of(input)};
  const Scroll scroll{scroll_between(before.geometry, input.geometry)};
  prepare(input, step, scroll, before, after.space);
  const int cells{observed.width};
  const int across{(cells + tile_columns - 1) / tile_columns};
  const int along{(cells + tile_rows - 1) / tile_rows};
  cpu.for_ranges(across * along, 1, [&](int begin, int end) {
    for (int i{begin}; i < end; ++i) {
      const int x{i % across * tile_columns};
      const int y{i / across * tile_rows};
      const LatticeTile tile{step,
                             input.tables,
                             before,
                             after,
                             scroll,
                             x,
                             std::min(x + tile_columns, cells),
                             y,
                             std::min(y + tile_rows, cells)};
      TileFilter{input, observed, tile, layers}.run();
    }
  });
}

namespace {

// Side by side from the first that the range before leaves: no two ranges share cells.
void find_neighbours(std::span<const VelocityEvidence> evidence, std::vector<EvidenceRange>& ranges) {
  ranges.clear();
  for (int i{0}; i < static_cast<int>(evidence.size()); ++i) {
    const auto cell = [&](int n) { return evidence[static_cast<std::size_t>(n)].cell; };
    if (ranges.empty() || cell(i) >= cell(ranges.back().begin) + evidence_cells) ranges.push_back({i, i});
    ranges.back().end = i + 1;
  }
}

WeighedCells cells_of(std::span<const VelocityEvidence> evidence) {
  WeighedCells cells{};
  cells.first_cell = evidence.front().cell;
  for (const VelocityEvidence& one : evidence) {
    const int i{one.cell - cells.first_cell};
    cells.is_weighed[i] = true;
    cells.x[i] = one.x;
    cells.y[i] = one.y;
    cells.xx[i] = one.xx;
    cells.xy[i] = one.xy;
    cells.yy[i] = one.yy;
  }
  return cells;
}

void write(const WeighedCells& cells, GridLayers& layers) {
  for (int i{0}; i < evidence_cells; ++i) {
    if (!cells.is_weighed[i]) continue;
    const int x{(cells.first_cell + i) % layers.occupancy.width()};
    const int y{(cells.first_cell + i) / layers.occupancy.width()};
    layers.moving(x, y) = moving_share(layers.occupancy(x, y), cells.standing[i]);
    const VelocitySums sums{cells.sum_mass[i], cells.sum_x[i],  cells.sum_y[i],
                            cells.sum_xx[i],   cells.sum_xy[i], cells.sum_yy[i]};
    write_velocity(estimate_of(sums), x, y, layers);
  }
}

}  // namespace

void weigh_velocities(Cpu& cpu, std::span<const VelocityEvidence> evidence, const FilterTables& tables,
                      WeighingSpace& space, FilterState& state, GridLayers& layers) {
  const int all_cells{static_cast<int>(layers.occupancy.size())};
  find_neighbours(evidence, space.ranges);
  const std::span<const EvidenceRange> ranges{space.ranges};
  const auto weigh_part = [&](int part, int begin, int end) {
    std::vector<float>& masses{space.masses[static_cast<std::size_t>(part)]};
    for (const EvidenceRange range : ranges.subspan(begin, end - begin)) {
      const auto here = evidence.subspan(range.begin, range.end - range.begin);
      if (here.front().cell + evidence_cells > all_cells) {
        Reference reference;
        weigh_velocities(reference, here, tables, state, layers);
        continue;
      }
      WeighedCells cells{cells_of(here)};
      weigh_cells(tables.axis_mps, state, masses.data(), cells);
      write(cells, layers);
    }
  };
  cpu.for_parts(static_cast<int>(ranges.size()), static_cast<int>(space.masses.size()), weigh_part);
}

}  // namespace stereogrid
