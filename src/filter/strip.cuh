// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/warp.cuh"
#include "filter/cuda.hpp"
#include "filter/model.hpp"

namespace stereogrid {

constexpr int strip_columns{warp - 1};  // a lane more reads the neighbour of the last one
constexpr int strip_rows{4};
constexpr int warps_max{6};

// A block has a strip of 31 × 4 cells, a warp of it some rows of the lattice.

enum Sum { of_mass, of_mass_x, of_mass_xx, of_all, sums };

struct Lattice {
  const float* speed;
  const Antecedents* from;
};

// Shared by the warps of a block.
struct StripSums {
  float of_row[warps_max][sums][strip_rows][warp];  // by row of the lattice in progress
  float total[6][strip_rows][warp];                 // VelocitySums
  float all[strip_rows][warp];
  float standing[strip_rows][warp];  // occupied mass of standstill
};

// The cells of a strip that a lane has: column x, rows y … y + 3.
struct Strip {
  FilterStep step;
  const float* mass;
  const float4* prepared;
  int cells;
  int x;
  int y;
  bool is_written;  // has cells of its own
  Likelihood likelihood[strip_rows];

  struct Arrived {
    float all[strip_rows];
    float occupied[strip_rows];
  };

  // Mass of a velocity after the noise: in all, and occupied.
  struct Disturbed {
    float all;
    float occupied;
  };
  __device__ Disturbed outside(float prior) const { return {prior, prior * still_occupied(step, 0.5f)}; }
  __device__ Disturbed inside(bool stands, const float4& of_cell, float arrived) const {
    const float all{stands ? of_cell.w : disturbed(step.kept_moving, of_cell.x * arrived, of_cell.z)};
    return {all, all * of_cell.y};
  }

  __device__ int nearest(int index) const { return index < 0 ? 0 : (index < cells ? index : cells - 1); }

  __device__ void gather(int k, const Antecedents& from, float prior, Arrived& arrived) const {
    const int ax{x + from.ix};
    const int ay{y + from.iy};
    const float* plane{mass + static_cast<std::size_t>(k) * (cells * cells)};
    float4 of_cell[strip_rows + 1];
    float before[strip_rows + 1];
    for (int r{0}; r <= strip_rows; ++r) {  // no branch: all loads precede the first use
      const int at{nearest(ay + r) * cells + nearest(ax)};
      of_cell[r] = prepared[at];
      before[r] = plane[at];
    }
    Disturbed across[strip_rows + 1];
    for (int r{0}; r <= strip_rows; ++r) {
      const bool is_inside{ax >= 0 && ax < cells && ay + r >= 0 && ay + r < cells};
      const Disturbed here{is_inside ? inside(k == step.standstill(), of_cell[r], before[r]) : outside(prior)};
      across[r].all = between(here.all, __shfl_down_sync(whole_warp, here.all, 1), from.fx);
      across[r].occupied = between(here.occupied, __shfl_down_sync(whole_warp, here.occupied, 1), from.fx);
    }
    for (int r{0}; r < strip_rows; ++r) {
      arrived.all[r] = between(across[r].all, across[r + 1].all, from.fy);
      arrived.occupied[r] = between(across[r].occupied, across[r + 1].occupied, from.fy);
    }
  }

  // The masses of velocity k; those that are written are what tay_update calls l(k).
  __device__ void update(int k, Arrived& arrived, float* after) const {
    for (int r{0}; r < strip_rows; ++r) {
      const TayUpdate<float> updated_mass{
          tay_update(arrived.all[r], arrived.occupied[r], likelihood[r].occupied, likelihood[r].empty)};
      arrived.all[r] = updated_mass.all;
      arrived.occupied[r] = updated_mass.occupied;
      if (is_written && y + r < cells) {
        after[static_cast<std::size_t>(k) * (cells * cells) + (y + r) * cells + x] = arrived.all[r];
      }
    }
  }

  // Row j of the lattice, and its sums.
  __device__ void run_row(const Lattice& lattice, int j, float* after, float (&of_row)[sums][strip_rows][warp],
                          StripSums& strip) const {
    const int lane{static_cast<int>(threadIdx.x)};
    LatticeRowSums<float> row[strip_rows];
    float row_all[strip_rows]{};
    for (int i{0}; i < step.side; ++i) {
      const int k{j * step.side + i};
      const float prior{prior_of(step, k)};
      const float vx{lattice.speed[i]};
      Arrived arrived;
      gather(k, lattice.from[k], prior, arrived);
      update(k, arrived, after);
      for (int r{0}; r < strip_rows; ++r) {
        row[r].add(vx, arrived.occupied[r]);
        row_all[r] += arrived.all[r];
        if (k == step.standstill()) strip.standing[r][lane] = arrived.occupied[r];
      }
    }
    for (int r{0}; r < strip_rows; ++r) {
      of_row[of_mass][r][lane] = row[r].mass;
      of_row[of_mass_x][r][lane] = row[r].x;
      of_row[of_mass_xx][r][lane] = row[r].xx;
      of_row[of_all][r][lane] = row_all[r];
    }
  }
};

__device__ inline VelocitySums total_of(const StripSums& strip, int r, int lane) {
  return {strip.total[0][r][lane], strip.total[1][r][lane], strip.total[2][r][lane],
          strip.total[3][r][lane], strip.total[4][r][lane], strip.total[5][r][lane]};
}

__device__ inline void keep_total(const VelocitySums& total, int r, int lane, StripSums& strip) {
  const float values[6]{total.mass, total.x, total.y, total.xx, total.xy, total.yy};
  for (int i{0}; i < 6; ++i) strip.total[i][r][lane] = values[i];
}

// Adds the rows first … first + count − 1 of the lattice, in this order.
__device__ inline void add_rows(const Lattice& lattice, int first, int count, StripSums& strip) {
  const int lane{static_cast<int>(threadIdx.x)};
  for (int r{static_cast<int>(threadIdx.y)}; r < strip_rows; r += static_cast<int>(blockDim.y)) {
    VelocitySums total{first > 0 ? total_of(strip, r, lane) : VelocitySums{}};
    float all{first > 0 ? strip.all[r][lane] : 0.0f};
    for (int w{0}; w < count; ++w) {
      const auto& row{strip.of_row[w]};
      total.add(lattice.speed[first + w], {row[of_mass][r][lane], row[of_mass_x][r][lane], row[of_mass_xx][r][lane]});
      all += row[of_all][r][lane];
    }
    keep_total(total, r, lane, strip);
    strip.all[r][lane] = all;
  }
}

}  // namespace stereogrid
