// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "filter/forms.hpp"
#include "filter/joint/evidence_simd.hpp"

namespace stereogrid {

void set_antecedents(const FilterInput& input, Scroll scroll, std::vector<Antecedents>& from) {
  const double cells_per_mps{input.dt_s / input.geometry.cell_size_m};
  for (std::size_t k{0}; k < from.size(); ++k) {
    const Point2 v{input.tables.lattice[k]};
    from[k] = antecedents(v.x * cells_per_mps, v.y * cells_per_mps, scroll.x, scroll.y);
  }
}

void filter(Cpu& cpu, const FilterInput& input, View<const float> observed, const FilterState& before,
            FilterState& after, GridLayers& layers) {
  after.geometry = layers.geometry = input.geometry;
  const bool is_joint{input.config.model == FilterModel::joint};
  (is_joint ? filter_joint : filter_tay)(cpu, input, observed, before, after, layers);
}

namespace {

// Ranges of evidence in the same row of the same block.
void find_ranges(std::span<const VelocityEvidence> evidence, int cells, std::vector<EvidenceRange>& ranges) {
  const auto place = [&](int i) {
    const int cell{evidence[static_cast<std::size_t>(i)].cell};
    return std::pair{cell / cells, cell % cells / block_columns};
  };
  ranges.clear();
  for (int i{0}; i < static_cast<int>(evidence.size()); ++i) {
    if (ranges.empty() || place(i) != place(ranges.back().begin)) ranges.push_back({i, i});
    ranges.back().end = i + 1;
  }
}

// The evidence of a row of a block.
class RowWeigher {
 public:
  RowWeigher(std::span<const VelocityEvidence> evidence, const FilterTables& tables, FilterState& state,
             GridLayers& layers)
      : evidence_{evidence}, tables_{tables}, state_{state}, layers_{layers} {}

  /// `starts`: of each evidence.
  void run(float* space, std::span<std::uint8_t> starts) const {
    WeighedCells cells{taken()};
    weigh_cells(tables_.axis_mps, space, cells);
    for (std::size_t i{0}; i < evidence_.size(); ++i) {
      const int at{column(evidence_[i]) - cells.x_first};
      starts[i] = 0;
      if (!cells.is_weighed[at]) continue;
      const bool moves{
          is_moving(tables_.moving_from, state_.occupancy(cells.x_first + at, cells.y), cells.standing[at])};
      starts[i] = cells.masses == nullptr && moves ? 1 : 0;
      if (starts[i] == 0) write(cells, at);
    }
  }

 private:
  [[nodiscard]] int width() const { return state_.occupancy.width(); }
  [[nodiscard]] int column(const VelocityEvidence& one) const { return one.cell % width(); }

  [[nodiscard]] WeighedCells taken() const {
    WeighedCells cells{};
    cells.x_first = column(evidence_.front()) / block_columns * block_columns;
    cells.y = evidence_.front().cell / width();
    cells.masses = state_.blocks.masses_at(cells.x_first, cells.y);
    for (const VelocityEvidence& one : evidence_) {
      const int x{column(one)};
      const int i{x - cells.x_first};
      cells.is_weighed[i] = !is_ignored(one, state_.age_s(x, cells.y));
      cells.x[i] = one.x;
      cells.y_mps[i] = one.y;
      cells.xx[i] = one.xx;
      cells.xy[i] = one.xy;
      cells.yy[i] = one.yy;
      cells.standing[i] = state_.standing(x, cells.y);
      cells.each[i] = even_mass(tables_.each_moving, state_.occupancy(x, cells.y), cells.standing[i]);
    }
    return cells;
  }

  void write(const WeighedCells& cells, int i) const {
    const int x{cells.x_first + i};
    state_.standing(x, cells.y) = cells.standing[i];
    layers_.moving(x, cells.y) = moving_share(layers_.occupancy(x, cells.y), cells.standing[i]);
    const VelocitySums sums{cells.sum_mass[i], cells.sum_x[i],  cells.sum_y[i],
                            cells.sum_xx[i],   cells.sum_xy[i], cells.sum_yy[i]};
    write_velocity(estimate_of(sums), x, cells.y, layers_);
  }

  std::span<const VelocityEvidence> evidence_;
  const FilterTables& tables_;
  FilterState& state_;
  GridLayers& layers_;
};

}  // namespace

void weigh_velocities(Cpu& cpu, std::span<const VelocityEvidence> evidence, const FilterTables& tables,
                      WeighingSpace& space, FilterState& state, GridLayers& layers) {
  find_ranges(evidence, state.occupancy.width(), space.ranges);
  const std::span<const EvidenceRange> ranges{space.ranges};
  const std::span<std::uint8_t> starts{space.starts};
  const auto weigh_part = [&](int part, int begin, int end) {
    for (const EvidenceRange range : ranges.subspan(begin, end - begin)) {
      const RowWeigher row{evidence.subspan(range.begin, range.end - range.begin), tables, state, layers};
      row.run(space.masses[static_cast<std::size_t>(part)].data(), starts.subspan(range.begin));
    }
  };
  cpu.for_parts(static_cast<int>(ranges.size()), static_cast<int>(space.masses.size()), weigh_part);
  const int width{state.occupancy.width()};
  for (const VelocityEvidence& one : evidence) state.forget_kind(one.cell % width, one.cell / width);
  CellWeigher weigher{tables, state, layers};
  const auto for_starting = [&](const auto& work) {
    for (std::size_t i{0}; i < evidence.size(); ++i) {
      if (starts[i] != 0) work(evidence[i]);
    }
  };
  const BlockLayout& layout{state.blocks.layout()};
  for_starting(
      [&](const VelocityEvidence& one) { state.blocks.want(layout.block_of(one.cell % width, one.cell / width)); });
  begin_wanted_blocks(tables, state);
  for_starting([&](const VelocityEvidence& one) { weigher.weigh(one, false); });
}

}  // namespace stereogrid
