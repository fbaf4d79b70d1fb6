// SPDX-License-Identifier: Apache-2.0
#include "observation/u_disparity/cuda.hpp"

#include <string>

#include "backend/warp.cuh"
#include "stereogrid/error.hpp"

namespace stereogrid {
namespace {

constexpr int place_threads{128};
constexpr int bins_max{256};
constexpr int infer_rows{8};
constexpr int smooth_rows{16};
constexpr int smooth_warps{8};

// --- which rows belong to which bins ---------------------------------------------------------------------------------

struct Placement {
  int width;
  int height;
  int disparities;
  double cx_px;
  double lowest_m;  // lowest point of an obstacle
  double highest_m;
  bool follow_roll;
};

__device__ BinRange bins_with_row(const RowRange* rows, int disparities, int row) {
  BinRange bins{disparities, -1};
  for (int d{0}; d < disparities; ++d) {
    if (row < rows[d].first || row > rows[d].last) continue;
    bins.first = bins.first < d ? bins.first : d;
    bins.last = d;
  }
  return bins;
}

// BinRows::place. A thread per column, and per row.
__global__ void place(Placement placement, Rig rig, const Ground* ground, BinRowsOnDevice out) {
  __shared__ RowRange rows[bins_max];
  __shared__ RowRange upright_rows[bins_max];
  __shared__ double of_ground[4];
  if (threadIdx.x == 0) {
    const RowsByHeight by_height{rig, *ground};
    of_ground[0] = by_height.horizon;
    of_ground[1] = by_height.baseline_across_m;
    of_ground[2] = by_height.camera_height_m;
    of_ground[3] = placement.follow_roll ? -tan(ground->roll_rad) : 0.0;
  }
  __syncthreads();
  const RowsByHeight by_height{of_ground[0], of_ground[1], of_ground[2]};
  for (int d{static_cast<int>(threadIdx.x)}; d < placement.disparities; d += place_threads) {
    rows[d] = rows_between(by_height, 0, placement.highest_m, d);
    upright_rows[d] = rows_between(by_height, placement.lowest_m, placement.highest_m, d);
    if (blockIdx.x > 0) continue;
    out.rows[d] = rows[d];
    out.possible[d] = possible_in_column(rows[d].first, rows[d].last, 0, placement.height);
  }
  __syncthreads();
  const int i{static_cast<int>(blockIdx.x * place_threads + threadIdx.x)};
  if (i < placement.width) out.shift[i] = row_shift(of_ground[3], i - placement.cx_px, out.margin);
  if (i < placement.height + 2 * out.margin) {
    out.bins[i] = bins_with_row(rows, placement.disparities, i - out.margin);
    out.upright_bins[i] = bins_with_row(upright_rows, placement.disparities, i - out.margin);
  }
}

// --- probabilities: a thread per bin ---------------------------------------------------------------------------------

struct Inference {
  const float* miss;
  const float* road_factor;
  BinConstants<float> constants;
  int half_window;
  bool left_border;
  int image_height;
};

struct Inferred {
  View<float, Device> visibility;
  View<float, Device> obstacle_confidence;
  View<float, Device> road_confidence;
  View<float, Device> occupancy;
};

__global__ void infer(Inference inference, BinRowsOnDevice rows, View<const std::uint16_t, Device> visible,
                      View<const std::uint16_t, Device> observed, View<const std::uint8_t, Device> has_road,
                      Inferred out) {
  const int u{static_cast<int>(blockIdx.x * warp + threadIdx.x)};
  const int d{static_cast<int>(blockIdx.y * infer_rows + threadIdx.y)};
  if (u >= visible.width || d >= visible.height) return;
  const RowRange of_bin{rows.rows[d]};
  const int possible{possible_in_column(of_bin.first, of_bin.last, rows.shift[u], inference.image_height)};
  const float seen{visibility_of(visible(u, d), possible)};
  const float miss{inference.miss[pair_index(visible(u, d), observed(u, d))]};
  const float road{inference.road_factor[road_cells_around(has_road, u, d)] * miss};
  const bool is_blind{d == 0 || (inference.left_border && u < d + inference.half_window)};
  const float obstacle{obstacle_probability(seen, 1 - miss, inference.constants)};
  out.visibility(u, d) = seen;
  out.obstacle_confidence(u, d) = 1 - miss;
  out.road_confidence(u, d) = road;
  out.occupancy(u, d) = is_blind ? 0.5f : occupancy_probability(obstacle, road, inference.constants);
}

// --- smoothing: a block has 32 columns and 16 bins, along columns into shared memory, then along disparity -----------

struct Taps {
  const float* weights;
  int reach;
};

__device__ int within(int value, int low, int high) {
  return value < low ? low : (value > high ? high : value);
}

__global__ void smooth(Taps along_column, Taps along_disparity, View<const float, Device> occupancy,
                       View<float, Device> smoothed) {
  float* const rows{dynamic_shared<float>()};  // [16 + 2·reach][32]
  const int lane{static_cast<int>(threadIdx.x)};
  const int u{static_cast<int>(blockIdx.x) * warp + lane};
  const int first{static_cast<int>(blockIdx.y) * smooth_rows};
  const int last_d{occupancy.height - 1};
  const int count{smooth_rows + 2 * along_disparity.reach};
  for (int i{static_cast<int>(threadIdx.y)}; i < count; i += smooth_warps) {
    const int d{within(first + i - along_disparity.reach, 1, last_d)};
    float sum{0};
    for (int k{-along_column.reach}; k <= along_column.reach; ++k) {
      sum += along_column.weights[k + along_column.reach] * occupancy(within(u + k, 0, occupancy.width - 1), d);
    }
    rows[i * warp + lane] = sum;
  }
  __syncthreads();
  if (u >= occupancy.width) return;
  for (int i{static_cast<int>(threadIdx.y)}; i < smooth_rows && first + i <= last_d; i += smooth_warps) {
    float sum{0};
    for (int k{0}; k <= 2 * along_disparity.reach; ++k) sum += along_disparity.weights[k] * rows[(i + k) * warp + lane];
    smoothed(u, first + i) = first + i == 0 ? 0.5f : sum;
  }
}

template <class Table>
void upload_table(Cuda& cuda, const Table& table, DeviceBuffer<float>& to) {
  upload(cuda, table.data(), table.size(), to.data());
}

Taps taps(const DeviceBuffer<float>& weights) {
  return {weights.data(), static_cast<int>(weights.size()) / 2};
}

void check_sizes(int height, int disparities) {
  if (disparities > bins_max) {
    throw ConfigError{"matching.disparities: on a GPU at most " + std::to_string(bins_max) + ", here " +
                      std::to_string(disparities) + "."};
  }
  if (height > 65535) throw ConfigError{"Images of " + std::to_string(height) + " rows: on a GPU at most 65535."};
}

}  // namespace

UDisparityOnDevice::UDisparityOnDevice(Cuda& cuda, const UDisparityTables& tables, int width, int height,
                                       int disparities)
    : config{tables.config},
      half_window{tables.half_window},
      miss{tables.miss.size()},
      road_factor{tables.road_factor.size()},
      weights_column{tables.weights_column.size()},
      weights_disparity{tables.weights_disparity.size()},
      margin{largest_shift(width)},
      shift{static_cast<std::size_t>(width)},
      rows_of_bin{static_cast<std::size_t>(disparities)},
      bins_of_row{static_cast<std::size_t>(height + 2 * margin)},
      upright_bins_of_row{bins_of_row.size()},
      has_road{width, disparities},
      possible{static_cast<std::size_t>(disparities)},
      visible{width, disparities},
      observed{width, disparities},
      visibility{width, disparities},
      obstacle_confidence{width, disparities},
      road_confidence{width, disparities},
      occupancy{width, disparities},
      occupancy_smooth{width, disparities} {
  check_sizes(height, disparities);
  upload_table(cuda, tables.miss, miss);
  upload_table(cuda, tables.road_factor, road_factor);
  upload_table(cuda, tables.weights_column, weights_column);
  upload_table(cuda, tables.weights_disparity, weights_disparity);
  cuda.synchronize();  // the tables are the caller's
}

BinRowsOnDevice UDisparityOnDevice::rows() {
  return {shift.data(), rows_of_bin.data(), bins_of_row.data(), upright_bins_of_row.data(), possible.data(), margin};
}

void count(Cuda& cuda, const MatchViews& matches, const Rig& rig, const Ground* ground, UDisparityOnDevice& space) {
  const BinConfig& config{space.config};
  const int width{matches.road.width};
  const int height{matches.road.height};
  const int disparities{space.occupancy.height()};
  const unsigned column_blocks{blocks_for(width, warp)};
  const BinRowsOnDevice rows{space.rows()};
  const int places{width > height + 2 * space.margin ? width : height + 2 * space.margin};
  launch(cuda, place, blocks_for(places, place_threads), place_threads, 0,
         Placement{width, height, disparities, rig.cx_px, config.obstacle_min_height_m, config.obstacle_height_m,
                   config.follow_roll},
         rig, ground, rows);
  count_columns(cuda, matches, rows, space);
  launch(cuda, infer, dim3{column_blocks, blocks_for(disparities, infer_rows)}, dim3{warp, infer_rows}, 0,
         Inference{space.miss.data(), space.road_factor.data(),
                   bin_constants(static_cast<float>(config.false_positive), static_cast<float>(config.false_negative)),
                   space.half_window, config.left_border, height},
         rows, space.visible.view(), space.observed.view(), space.has_road.view(),
         Inferred{space.visibility.view(), space.obstacle_confidence.view(), space.road_confidence.view(),
                  space.occupancy.view()});
  const Taps along_disparity{taps(space.weights_disparity)};
  launch(cuda, smooth, dim3{column_blocks, blocks_for(disparities, smooth_rows)}, dim3{warp, smooth_warps},
         static_cast<std::size_t>((smooth_rows + 2 * along_disparity.reach) * warp) * sizeof(float),
         taps(space.weights_column), along_disparity, space.occupancy.view(), space.occupancy_smooth.view());
}

}  // namespace stereogrid
