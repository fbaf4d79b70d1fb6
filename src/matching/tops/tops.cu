// SPDX-License-Identifier: Apache-2.0
#include "matching/cuda.hpp"
#include "matching/lanes.cuh"

namespace stereogrid {
namespace {

constexpr int threads{128};

struct TopsOnDevice {
  View<const std::uint8_t, Device> left;  ///< short census
  View<const std::uint8_t, Device> right;
  const RoadPlane* plane;
  TopRules rules;
  View<ThinTop, Device> points;
  View<float, Device> obstacle;
  View<float, Device> road;
  View<float, Device> confidence;
};

// A block has 32 neighbouring points of a row. Costs are bytes, four to a word: those of the columns around the points,
// then those of the windows.
constexpr int points_per_block{32};
constexpr int columns_per_block{points_per_block + 2 * top_half_columns};
constexpr int words{top_disparities_max / 4};

__global__ void __launch_bounds__(threads) find_tops(const TopsOnDevice task) {
  __shared__ std::uint32_t columns[columns_per_block][words];
  __shared__ std::uint32_t costs[points_per_block][words + 1];  // 32 threads read words of one bank each
  const int first{static_cast<int>(blockIdx.x) * points_per_block};
  const int v{static_cast<int>(blockIdx.y) * top_window_rows};
  const int used{(task.rules.disparities + 3) / 4};
  for (int i{static_cast<int>(threadIdx.x)}; i < columns_per_block * used; i += threads) {
    const int column{i / used};
    const int word{i % used};
    const int u{top_pixel(first + column - top_half_columns, task.points.width)};
    std::uint32_t bytes{0};
    for (int k{0}; k < 4; ++k) {
      unsigned cost{0};
      for (int row{v}; row < v + top_window_rows; ++row) {
        cost += __popc(static_cast<unsigned>(task.left(u, row) ^ task.right(max(u - (word * 4 + k), 0), row)));
      }
      bytes |= cost << 8 * k;
    }
    columns[column][word] = bytes;
  }
  __syncthreads();
  for (int i{static_cast<int>(threadIdx.x)}; i < points_per_block * used; i += threads) {
    std::uint32_t sum{0};  // at most 30 samples of 8 bits: no byte overflows
    for (int k{0}; k <= 2 * top_half_columns; ++k) sum += columns[i / used + k][i % used];
    costs[i / used][i % used] = sum;
  }
  __syncthreads();
  const int point{first + static_cast<int>(threadIdx.x)};
  if (threadIdx.x >= points_per_block || point >= task.points.width) return;
  const int u{top_pixel(point, task.points.width)};
  const auto nearest = [&](int row) {
    const int within{clamped(row, task.road.height)};
    return Max(task.obstacle(u, within), task.road(u, within));
  };
  const auto* own = reinterpret_cast<const std::uint8_t*>(costs[threadIdx.x]);
  task.points(point, static_cast<int>(blockIdx.y)) =
      top_of(own, cheapest(own, task.rules.disparities), task.rules, {*task.plane, v}, u, v, nearest);
}

__global__ void __launch_bounds__(threads) put_tops(const TopsOnDevice task) {
  const int point{static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x)};
  if (point >= task.points.width) return;
  const ThinTop* row{task.points.row(static_cast<int>(blockIdx.y))};
  if (!is_in_top(row, task.points.width, point)) return;
  for (int j{0}; j < top_window_rows; ++j) {
    const int v{static_cast<int>(blockIdx.y) * top_window_rows + j};
    for (int u{point * top_step_px}; u < (point + 1) * top_step_px; ++u) {
      put_top(row[point], task.obstacle(u, v), task.road(u, v), task.confidence(u, v));
    }
  }
}

}  // namespace

void add_tops(Cuda& cuda, const DescribedOnDevice& census, const RoadPlane* plane, const TopRules& rules,
              View<ThinTop, Device> points, DeviceMatches& matches) {
  const TopsOnDevice task{census.left.view(),  census.right.view(),      plane, rules, points, matches.obstacle.view(),
                          matches.road.view(), matches.confidence.view()};
  const auto rows = static_cast<unsigned>(points.height);
  launch(cuda, find_tops, dim3{blocks_for(points.width, points_per_block), rows}, dim3{threads}, 0, task);
  launch(cuda, put_tops, dim3{blocks_for(points.width, threads), rows}, dim3{threads}, 0, task);
}

}  // namespace stereogrid
