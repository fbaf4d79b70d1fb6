// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"

#include <algorithm>
#include <cstdint>
#include <span>
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

// The masses of the row of a block in which a cell lies; null: the block has none.
float* masses_of_row(FilterState& state, const VelocityEvidence& one) {
  const int width{state.occupancy.width()};
  return state.blocks.masses_at(one.cell % width / block_columns * block_columns, one.cell / width);
}

// Ranges that fill a vector together: evidence in a row of a block with masses, or anywhere in blocks without.
void find_ranges(std::span<const VelocityEvidence> evidence, FilterState& state, std::vector<EvidenceRange>& ranges) {
  const float* before{nullptr};
  ranges.clear();
  for (int i{0}; i < static_cast<int>(evidence.size()); ++i) {
    const float* const masses{masses_of_row(state, evidence[static_cast<std::size_t>(i)])};
    const bool is_full{masses == nullptr && !ranges.empty() && i - ranges.back().begin == block_columns};
    if (ranges.empty() || masses != before || is_full) ranges.push_back({i, i});
    ranges.back().end = i + 1;
    before = masses;
  }
}

// The evidence of a range.
class RangeWeigher {
 public:
  /// `starts`: of each evidence; see WeighingWorkspace.
  RangeWeigher(std::span<const VelocityEvidence> evidence, std::span<std::uint8_t> starts, const FilterTables& tables,
               FilterState& state, GridLayers& layers)
      : evidence_{evidence}, starts_{starts}, tables_{tables}, state_{state}, layers_{layers} {}

  /// Applies the evidence but for that which starts a moving cell.
  void run(float* space) const {
    std::ranges::fill(starts_, std::uint8_t{1});
    const WeighedCells cells{weighed(space)};
    for (std::size_t i{0}; i < evidence_.size(); ++i) {
      const auto [x, y] = place(i);
      const int lane{lane_of(i, cells)};
      const bool moves{is_moving(tables_.moving_from, state_.occupancy(x, y), cells.standing[lane])};
      starts_[i] = cells.is_weighed[lane] && cells.masses == nullptr && moves ? 1 : 0;
      if (cells.is_weighed[lane] && starts_[i] == 0) write(i, cells);
    }
  }

  /// Applies that which does.
  void run_starting(float* space) const {
    if (std::ranges::count(starts_, std::uint8_t{1}) == 0) return;
    const WeighedCells cells{weighed(space)};
    for (std::size_t i{0}; i < evidence_.size(); ++i) {
      if (starts_[i] != 0) write(i, cells);
    }
  }

 private:
  struct Place {
    int x;
    int y;
  };
  [[nodiscard]] Place place(std::size_t i) const {
    const int width{state_.occupancy.width()};
    return {evidence_[i].cell % width, evidence_[i].cell / width};
  }
  // Masses lie side by side, as their cells do.
  [[nodiscard]] int lane_of(std::size_t i, const WeighedCells& cells) const {
    return cells.masses != nullptr ? place(i).x % block_columns : static_cast<int>(i);
  }

  [[nodiscard]] WeighedCells weighed(float* space) const {
    WeighedCells cells{taken()};
    weigh_cells(tables_.axis_mps, space, cells);
    return cells;
  }

  // Takes the evidence that may start a moving cell.
  [[nodiscard]] WeighedCells taken() const {
    WeighedCells cells{};
    cells.masses = masses_of_row(state_, evidence_.front());
    for (std::size_t i{0}; i < evidence_.size(); ++i) {
      const VelocityEvidence& one{evidence_[i]};
      const auto [x, y] = place(i);
      const int lane{lane_of(i, cells)};
      cells.is_weighed[lane] = starts_[i] != 0 && !is_ignored(one, state_.age_s(x, y));
      if (cells.is_weighed[lane]) start_motion(tables_, one, state_);
      cells.x[lane] = one.x;
      cells.y_mps[lane] = one.y;
      cells.xx[lane] = one.xx;
      cells.xy[lane] = one.xy;
      cells.yy[lane] = one.yy;
      cells.standing[lane] = state_.standing(x, y);
      cells.each[lane] = even_mass(tables_.each_moving, state_.occupancy(x, y), cells.standing[lane]);
    }
    return cells;
  }

  void write(std::size_t i, const WeighedCells& cells) const {
    const auto [x, y] = place(i);
    const int lane{lane_of(i, cells)};
    state_.standing(x, y) = cells.standing[lane];
    layers_.moving(x, y) = moving_share(layers_.occupancy(x, y), cells.standing[lane]);
    const WeighedCell cell{{cells.sum_mass[lane], cells.sum_x[lane], cells.sum_y[lane], cells.sum_xx[lane],
                            cells.sum_xy[lane], cells.sum_yy[lane]},
                           cells.standing[lane]};
    const std::vector<float>& axis_mps{tables_.axis_mps};
    write_velocity(refined(evidence_[i], axis_mps.data(), static_cast<int>(axis_mps.size()), cell), x, y, layers_);
  }

  std::span<const VelocityEvidence> evidence_;
  std::span<std::uint8_t> starts_;
  const FilterTables& tables_;
  FilterState& state_;
  GridLayers& layers_;
};

}  // namespace

void weigh_velocities(Cpu& cpu, std::span<const VelocityEvidence> evidence, const FilterTables& tables,
                      WeighingWorkspace& space, FilterState& state, GridLayers& layers) {
  const auto weigh = [&](auto run) {
    find_ranges(evidence, state, space.ranges);
    const std::span<const EvidenceRange> ranges{space.ranges};
    cpu.for_parts(
        static_cast<int>(ranges.size()), static_cast<int>(space.masses.size()), [&](int part, int begin, int end) {
          for (const auto [first, last] : ranges.subspan(begin, end - begin)) {
            const RangeWeigher range{evidence.subspan(first, last - first),
                                     std::span{space.starts}.subspan(first, last - first), tables, state, layers};
            (range.*run)(space.masses[static_cast<std::size_t>(part)].data());
          }
        });
  };
  weigh(&RangeWeigher::run);
  const int width{state.occupancy.width()};
  const BlockLayout& layout{state.blocks.layout()};
  for (std::size_t i{0}; i < evidence.size(); ++i) {
    const int x{evidence[i].cell % width};
    const int y{evidence[i].cell / width};
    state.invalidate_kind(x, y);
    if (space.starts[i] != 0) state.blocks.want(layout.block_of(x, y));
  }
  allocate_marked_blocks(tables, state);
  weigh(&RangeWeigher::run_starting);
}

}  // namespace stereogrid
