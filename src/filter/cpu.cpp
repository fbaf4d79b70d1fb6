// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "filter/filter.hpp"

namespace stereogrid {
namespace {

constexpr int rows_grain{4};

// One row of cells through the filter. All loops run along x; the sums are formed in the order of the reference.
class RowFilter {
 public:
  RowFilter(const FilterInput& input, View<const float> observed, const FilterState& before, FilterState& after,
            GridLayers& layers)
      : input_{input},
        step_{step_of(input)},
        observed_{observed},
        before_{before},
        after_{after},
        layers_{layers},
        cells_{observed.width},
        moved_x_{moved(input.geometry.x_min_m, before.geometry.x_min_m)},
        moved_y_{moved(input.geometry.y_min_m, before.geometry.y_min_m)},
        near_(columns() + 1),
        far_(columns() + 1),
        near_occupied_(columns() + 1),
        far_occupied_(columns() + 1),
        scratch_(columns()),
        sum_(columns()),
        total_(columns()),
        lacking_(columns()),
        evidence_(columns()),
        occupied_(columns()),
        empty_(columns()) {
    const double cells_per_mps{input.dt_s / input.geometry.cell_size_m};
    for (const Point2 v : input.lattice) {
      antecedents_.push_back(antecedents(v.x * cells_per_mps, v.y * cells_per_mps, moved_x_, moved_y_));
    }
  }

  void run(int y) {
    for (int x{0}; x < cells_; ++x) {
      const Likelihood likelihood{likelihood_of(input_.config, observed_(x, y))};
      occupied_[index(x)] = likelihood.occupied;
      empty_[index(x)] = likelihood.empty;
      layers_.velocity_x(x, y) = layers_.velocity_y(x, y) = 0;
      const float age_before{is_known(x, y) ? before_.age_s(x + moved_x_, y + moved_y_)
                                            : std::numeric_limits<float>::infinity()};
      after_.age_s(x, y) = age_before;
    }
    input_.config.model == FilterModel::joint ? joint_row(y) : tay_row(y);
    for (int x{0}; x < cells_; ++x) {
      const bool seen{std::abs(observed_(x, y) - 0.5f) > observed_difference};
      layers_.occupancy(x, y) = after_.occupancy(x, y);
      after_.age_s(x, y) = seen ? 0.0f : after_.age_s(x, y) + static_cast<float>(input_.dt_s);
      layers_.age_s(x, y) = after_.age_s(x, y);
      layers_.velocity_x(x, y) /= after_.occupancy(x, y);
      layers_.velocity_y(x, y) /= after_.occupancy(x, y);
    }
  }

 private:
  [[nodiscard]] std::size_t columns() const { return static_cast<std::size_t>(cells_); }
  static std::size_t index(int x) { return static_cast<std::size_t>(x); }

  [[nodiscard]] int moved(double now_m, double before_m) const {
    return static_cast<int>(std::lround((now_m - before_m) / input_.geometry.cell_size_m));
  }
  [[nodiscard]] bool is_known(int x, int y) const {
    return x + moved_x_ >= 0 && x + moved_x_ < cells_ && y + moved_y_ >= 0 && y + moved_y_ < cells_;
  }

  // One row of the state before; null outside the window.
  struct Rows {
    const float* mass{nullptr};
    const float* standing{nullptr};
    const float* occupancy{nullptr};
  };
  [[nodiscard]] Rows rows_of(std::size_t k, int row) const {
    if (row < 0 || row >= cells_) return {};
    return {before_.velocity[k].row(row), before_.velocity[before_.velocity.size() / 2].row(row),
            before_.occupancy.row(row)};
  }
  [[nodiscard]] bool is_standstill(std::size_t k) const { return k == before_.velocity.size() / 2; }

  // out[x] = value of column x + first in that row, for x = 0 … cells; `border` outside the window
  template <class Value>
  void fetch(int row, int first, float border, float* out, const Value& value) const {
    const int begin{row < 0 || row >= cells_ ? cells_ + 1 : std::clamp(-first, 0, cells_ + 1)};
    const int end{std::clamp(cells_ - first, begin, cells_ + 1)};
    std::fill(out, out + begin, border);
    for (int x{begin}; x < end; ++x) out[x] = value(x + first);
    std::fill(out + end, out + cells_ + 1, border);
  }

  void gather(const Antecedents& from, const float* near, const float* far, float* out) const {
    if (from.w00 == 1.0f) {
      std::copy(near, near + cells_, out);
      return;
    }
    for (int x{0}; x < cells_; ++x) {
      float sum{from.w00 * near[x]};
      sum += from.w10 * near[x + 1];
      sum += from.w01 * far[x];
      sum += from.w11 * far[x + 1];
      out[x] = sum;
    }
  }

  // out[x] = mass of velocity k that arrives in row y
  void predict_mass(std::size_t k, int y, float* out) {
    const Antecedents& from{antecedents_[k]};
    const float prior{prior_of(step_, static_cast<int>(k))};
    const auto fetch_mass = [&](int row, float* target) {
      const Rows rows{rows_of(k, row)};
      const float border{step_.border_occupancy * prior};
      if (is_standstill(k)) {
        fetch(row, from.ix, border, target,
              [&](int x) { return disturbed_standing(step_, rows.mass[x], rows.occupancy[x]); });
      } else {
        fetch(row, from.ix, border, target,
              [&](int x) { return disturbed(step_, rows.mass[x], rows.occupancy[x], rows.standing[x]); });
      }
    };
    fetch_mass(y + from.iy, near_.data());
    if (from.w00 != 1.0f) fetch_mass(y + from.iy + 1, far_.data());
    gather(from, near_.data(), far_.data(), out);
    const bool row_known{y + moved_y_ >= 0 && y + moved_y_ < cells_};
    const int begin{row_known ? std::clamp(-moved_x_, 0, cells_) : cells_};
    const int end{row_known ? std::clamp(cells_ - moved_x_, begin, cells_) : cells_};
    std::fill(out, out + begin, 0.5f * prior);
    std::fill(out + end, out + cells_, 0.5f * prior);
  }

  void joint_row(int y) {
    std::fill(sum_.begin(), sum_.end(), 0.0f);
    for (std::size_t k{0}; k < antecedents_.size(); ++k) {
      float* mass{after_.velocity[k].row(y)};
      predict_mass(k, y, mass);
      for (int x{0}; x < cells_; ++x) sum_[index(x)] += mass[x];
    }
    for (int x{0}; x < cells_; ++x) {
      const float sum{sum_[index(x)]};
      const float total{sum > 1 ? 1.0f : sum};
      scratch_[index(x)] = sum > 1 ? 1 / sum : 1.0f;
      lacking_[index(x)] = std::isinf(after_.age_s(x, y)) && total < 0.5f ? 0.5f - total : 0.0f;
      total_[index(x)] = step_.forgetting * (1 - total - lacking_[index(x)]);
    }
    std::fill(sum_.begin(), sum_.end(), 0.0f);
    for (std::size_t k{0}; k < antecedents_.size(); ++k) {
      float* mass{after_.velocity[k].row(y)};
      const float prior{prior_of(step_, static_cast<int>(k))};
      const float kept{1 - step_.forgetting};
      for (int x{0}; x < cells_; ++x) {
        mass[x] = kept * (mass[x] * scratch_[index(x)] + lacking_[index(x)] * prior) + total_[index(x)] * prior;
        sum_[index(x)] += mass[x];
      }
    }
    for (int x{0}; x < cells_; ++x) {
      const float predicted{sum_[index(x)]};
      evidence_[index(x)] = occupied_[index(x)] * predicted + empty_[index(x)] * (1 - predicted);
      after_.occupancy(x, y) = occupied_[index(x)] * predicted / evidence_[index(x)];
    }
    for (std::size_t k{0}; k < antecedents_.size(); ++k) {
      float* mass{after_.velocity[k].row(y)};
      for (int x{0}; x < cells_; ++x) mass[x] = occupied_[index(x)] * mass[x] / evidence_[index(x)];
      add_velocity(k, y, mass);
    }
  }

  void tay_row(int y) {
    std::fill(sum_.begin(), sum_.end(), 0.0f);
    std::fill(total_.begin(), total_.end(), 0.0f);
    occupied_rows_.resize(antecedents_.size() * columns());
    for (std::size_t k{0}; k < antecedents_.size(); ++k) {
      float* velocity{after_.velocity[k].row(y)};
      float* occupied{occupied_rows_.data() + k * columns()};
      predict_tay(k, y, velocity, occupied);
      for (int x{0}; x < cells_; ++x) {
        const float alpha_occupied{occupied[x]};
        occupied[x] = occupied_[index(x)] * alpha_occupied;
        velocity[x] = occupied[x] + empty_[index(x)] * (velocity[x] - alpha_occupied);
        sum_[index(x)] += velocity[x];
        total_[index(x)] += occupied[x];
      }
    }
    for (std::size_t k{0}; k < antecedents_.size(); ++k) {
      float* velocity{after_.velocity[k].row(y)};
      float* occupied{occupied_rows_.data() + k * columns()};
      for (int x{0}; x < cells_; ++x) {
        velocity[x] = velocity[x] / sum_[index(x)];
        occupied[x] = occupied[x] / sum_[index(x)];
      }
      add_velocity(k, y, occupied);
    }
    for (int x{0}; x < cells_; ++x) after_.occupancy(x, y) = total_[index(x)] / sum_[index(x)];
  }

  void predict_tay(std::size_t k, int y, float* all, float* occupied) {
    const Antecedents& from{antecedents_[k]};
    const float prior{prior_of(step_, static_cast<int>(k))};
    const auto still_occupied = [&](float o) { return (1 - step_.forgetting) * o + step_.forgetting * (1 - o); };
    const auto fetch_both = [&](int row, float* moving, float* moving_occupied) {
      const Rows rows{rows_of(k, row)};
      if (is_standstill(k)) {
        fetch(row, from.ix, prior, moving, [&](int x) { return disturbed_standing(step_, rows.mass[x], 1.0f); });
      } else {
        fetch(row, from.ix, prior, moving,
              [&](int x) { return disturbed(step_, rows.mass[x], 1.0f, rows.standing[x]); });
      }
      fetch(row, from.ix, still_occupied(0.5f), moving_occupied,
            [&](int x) { return still_occupied(rows.occupancy[x]); });
      for (int x{0}; x <= cells_; ++x) moving_occupied[x] = moving[x] * moving_occupied[x];
    };
    fetch_both(y + from.iy, near_.data(), near_occupied_.data());
    if (from.w00 != 1.0f) fetch_both(y + from.iy + 1, far_.data(), far_occupied_.data());
    gather(from, near_.data(), far_.data(), all);
    gather(from, near_occupied_.data(), far_occupied_.data(), occupied);
  }

  void add_velocity(std::size_t k, int y, const float* weights) {
    const float x_mps{static_cast<float>(input_.lattice[k].x)};
    const float y_mps{static_cast<float>(input_.lattice[k].y)};
    float* vx{layers_.velocity_x.row(y)};
    float* vy{layers_.velocity_y.row(y)};
    for (int x{0}; x < cells_; ++x) {
      vx[x] += weights[x] * x_mps;
      vy[x] += weights[x] * y_mps;
    }
  }

  const FilterInput& input_;
  FilterStep step_;
  View<const float> observed_;
  const FilterState& before_;
  FilterState& after_;
  GridLayers& layers_;
  int cells_;
  int moved_x_;
  int moved_y_;
  std::vector<Antecedents> antecedents_;
  std::vector<float> near_, far_, near_occupied_, far_occupied_, occupied_rows_;
  std::vector<float> scratch_, sum_, total_, lacking_, evidence_;
  std::vector<float> occupied_, empty_;  // likelihoods
};

}  // namespace

void filter(Cpu& cpu, const FilterInput& input, View<const float> observed, const FilterState& before,
            FilterState& after, GridLayers& layers) {
  if (input.config.model == FilterModel::particles) {
    return filter_particles(cpu, input, observed, before, after, layers);
  }
  after.geometry = layers.geometry = input.geometry;
  cpu.for_ranges(observed.height, rows_grain, [&](int begin, int end) {
    RowFilter rows{input, observed, before, after, layers};
    for (int y{begin}; y < end; ++y) rows.run(y);
  });
}

}  // namespace stereogrid
