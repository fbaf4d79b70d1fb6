// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>

#include "backend/cpu.hpp"
#include "filter/bof2008/tay_simd.hpp"
#include "filter/forms.hpp"

namespace stereogrid {
namespace {

// Prepares the prediction of each cell of the last state.
void prepare(const FilterStep& step, const FilterState& before, FilterWorkspace& space) {
  const Image<float>& standing{before.velocity[before.velocity.size() / 2]};
  for (std::size_t c{0}; c < standing.size(); ++c) {
    space.gained.data()[c] = gained_by_moving(step, 1.0f, standing.data()[c]);
    space.standing.data()[c] = disturbed_standing(step, 1.0f, standing.data()[c]);
    space.still_occupied.data()[c] = still_occupied(step, before.occupancy.data()[c]);
  }
}

// Age before the step of the window's cell (x, y); infinite: never seen.
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
    update();
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

  void update() const {
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
      for (int x{tile_.x_begin}; x < tile_.x_end; ++x) {
        const int i{x - tile_.x_begin};
        scale[i] = 1 / row.evidence[i];
        write(x, y, scale[i] * row.sums.mass[i], scale[i] * row.standing[i], row.sums.at(i));
      }
      normalise(tile_, y, scale);
    }
  }

  const FilterInput& input_;
  View<const float> observed_;
  const LatticeTile& tile_;
  GridLayers& layers_;
};

}  // namespace

void filter_tay(Cpu& cpu, const FilterInput& input, View<const float> observed, const FilterState& before,
                FilterState& after, GridLayers& layers) {
  const FilterStep step{step_of(input)};
  const Scroll scroll{scroll_between(before.geometry, input.geometry)};
  set_antecedents(input, scroll, after.space.from);
  prepare(step, before, after.space);
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

}  // namespace stereogrid
