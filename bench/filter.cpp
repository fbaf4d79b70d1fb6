// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Times one step of the filters on a world of standing and moving blocks, processor time on one thread and wall-clock
// time on two. All sizes and models take turns in one run. Intervals between frames: 0.1 s is a whole number of cells
// for every velocity of a uniform lattice, 0.104 s is not. 146 cells are the window of 100 × 100.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <string_view>
#include <vector>

#include "backend/cpu.hpp"
#include "filter/filter.hpp"
#include "machine.hpp"

namespace {

using namespace stereogrid;

constexpr int rounds{41};
constexpr int warm_up_steps{10};
constexpr double cell_m{0.2};

struct Case {
  FilterModel model;
  int cells;
  double velocity_max_mps;  // lattice in steps of 2 m/s; 0: the default lattice
  double dt_s;
  double aim_ms;  // on two threads; 0: none
};

constexpr Case cases[]{
    {FilterModel::joint, 200, 10, 0.1, 4.0},   {FilterModel::joint, 200, 10, 0.104, 4.0},
    {FilterModel::joint, 100, 6, 0.1, 0.5},    {FilterModel::joint, 100, 6, 0.104, 0.5},
    {FilterModel::joint, 146, 0, 0.104, 0},    {FilterModel::tay2008, 200, 10, 0.1, 0},
    {FilterModel::tay2008, 200, 10, 0.104, 0},
};

// Blocks of 1 × 1 m on free ground, every second one moves; a third of the cells is hidden.
Image<float> world_at(int cells, double time_s) {
  Image<float> observed{cells, cells, 0.1f};
  for (int block{0}; block < cells / 8; ++block) {
    const double shift{block % 2 == 0 ? 0.0 : time_s * (block % 5 - 2.0) / cell_m};
    const int x{(block * 37 + static_cast<int>(shift) + cells) % (cells - 5)};
    const int y{block * 53 % (cells - 5)};
    for (int iy{y}; iy < y + 5; ++iy) std::fill_n(observed.row(iy) + x, 5, 0.9f);
  }
  for (int y{0}; y < cells; ++y) std::fill_n(observed.row(y), cells / 3, 0.5f);
  return observed;
}

class Steps {
 public:
  Steps(const Case& one, int threads)
      : case_{one},
        cpu_{threads},
        config_{config_of(one)},
        tables_{config_},
        geometry_{0, 0, cell_m, one.cells, one.cells},
        layers_{grid_layers(geometry_)},
        now_{one.cells, config_},
        before_{now_} {
    reset(now_, config_, geometry_);
    for (int i{0}; i < warm_up_steps; ++i) step();
  }

  void step() {
    time_s_ += case_.dt_s;
    const Image<float> observed{world_at(case_.cells, time_s_)};
    std::swap(now_, before_);
    const auto wall = std::chrono::steady_clock::now();
    const std::clock_t processor{std::clock()};
    filter(cpu_, {config_, tables_, geometry_, case_.dt_s}, observed.view(), before_, now_, layers_);
    processor_ms_.push_back(1e3 * static_cast<double>(std::clock() - processor) / CLOCKS_PER_SEC);
    wall_ms_.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - wall).count());
  }

  [[nodiscard]] double least_processor_ms() const {
    return *std::min_element(processor_ms_.begin(), processor_ms_.end());
  }
  [[nodiscard]] double least_wall_ms() const { return *std::min_element(wall_ms_.begin(), wall_ms_.end()); }
  [[nodiscard]] double median_wall_ms() const {
    std::vector<double> sorted{wall_ms_};
    std::sort(sorted.begin(), sorted.end());
    return sorted[sorted.size() / 2];
  }
  [[nodiscard]] std::size_t velocities() const { return tables_.lattice.size(); }

 private:
  static FilterConfig config_of(const Case& one) {
    FilterConfig config;
    config.model = one.model;
    if (one.velocity_max_mps == 0) return config;
    config.speeds_mps.clear();
    for (double speed_mps{2}; speed_mps <= one.velocity_max_mps; speed_mps += 2) config.speeds_mps.push_back(speed_mps);
    return config;
  }

  Case case_;
  Cpu cpu_;
  FilterConfig config_;
  FilterTables tables_;
  GridGeometry geometry_;
  GridLayers layers_;
  FilterState now_;
  FilterState before_;
  double time_s_{0};
  std::vector<double> processor_ms_;
  std::vector<double> wall_ms_;
};

void print(const Case& one, const Steps& alone, const Steps& pair) {
  const std::string_view model{names_of(one.model)[static_cast<std::size_t>(one.model)]};
  std::printf("| %.*s | %d × %d | %zu | %.3f | %.2f | %.2f | %.2f |", static_cast<int>(model.size()), model.data(),
              one.cells, one.cells, alone.velocities(), one.dt_s, alone.least_processor_ms(), pair.least_wall_ms(),
              pair.median_wall_ms());
  if (one.aim_ms > 0) {
    std::printf(" %.1f | %.2f |\n", one.aim_ms, pair.least_wall_ms() / one.aim_ms);
  } else {
    std::printf(" | |\n");
  }
}

// One case alone, for counting instructions: bench_filter CASE STEPS.
void run_one(int number, int steps) {
  Steps alone{cases[number], 1};
  for (int i{0}; i < steps; ++i) alone.step();
}

void compare() {
  std::vector<std::unique_ptr<Steps>> alone;
  std::vector<std::unique_ptr<Steps>> pairs;
  for (const Case& one : cases) {
    alone.push_back(std::make_unique<Steps>(one, 1));
    pairs.push_back(std::make_unique<Steps>(one, 2));
  }
  for (int round{0}; round < rounds; ++round) {
    for (std::size_t i{0}; i < alone.size(); ++i) {
      alone[i]->step();
      pairs[i]->step();
    }
  }
  std::printf("| model | cells | velocities | interval s | 1 thread: processor ms | 2 threads: least ms | median ms ");
  std::printf("| aim ms | ratio |\n|---|---|---|---|---|---|---|---|---|\n");
  for (std::size_t i{0}; i < alone.size(); ++i) print(cases[i], *alone[i], *pairs[i]);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 3) {
    run_one(std::atoi(argv[1]) % static_cast<int>(std::size(cases)), std::atoi(argv[2]));
  } else {
    stereogrid::print_machine();
    compare();
  }
  return 0;
}
