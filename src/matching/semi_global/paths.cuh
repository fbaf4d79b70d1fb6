// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "matching/lanes.cuh"
#include "matching/semi_global/semi_global.hpp"

namespace stereogrid {

/// In SemiGlobalOnDevice::meeting: no road label can be taken in this row.
constexpr std::int16_t no_road{-2};

/// Lanes that have road labels, four each.
constexpr int road_lanes{8};

/// Path costs of a pixel's labels, spread over a warp.
template <int words>
struct PathCosts {
  LaneCosts<words> upright;
  LaneCosts<1> road;  ///< cost_max beyond the road's labels
};

/// Input of a path's step at its pixel, in the layout of LabelVolume.
template <int words>
struct PixelCosts {
  std::uint32_t upright[words];
  std::uint32_t road;
  int meeting;
};

/// Penalties, twice in a word each.
struct StepPenalties {
  std::uint32_t step;
  std::uint32_t road_step;
  std::uint32_t jump;
  std::uint32_t change;
};

/// Road costs, a byte each, for steps from the road to an obstacle on it.
struct ChangeRoom {
  static constexpr int before{2};  ///< words of cost_max before the road's labels
  static constexpr int road{before + road_lanes + 1};

  std::uint32_t costs[road];
};

template <int words>
__device__ inline LaneCosts<words> unpacked(const std::uint32_t (&bytes)[words]) {
  LaneCosts<words> costs;
  for (int i{0}; i < words; ++i) {
    costs.even[i] = even_bytes(bytes[i]);
    costs.odd[i] = odd_bytes(bytes[i]);
  }
  return costs;
}

template <int words>
__device__ inline std::uint32_t packed(const LaneCosts<words>& costs, int i) {
  return costs.even[i] | costs.odd[i] << 8;
}

template <int words>
__device__ inline LaneCosts<words> filled(int cost) {
  LaneCosts<words> costs;
  for (int i{0}; i < words; ++i) costs.even[i] = costs.odd[i] = twice(cost);
  return costs;
}

template <int words>
__device__ inline PathCosts<words> first_costs(const PixelCosts<words>& pixel) {
  const std::uint32_t road[1]{pixel.road};
  return {unpacked(pixel.upright), unpacked(road)};
}

/// Words of the lanes before and after; cost_max beyond the first and last label.
template <int words>
__device__ inline std::uint32_t before_lane(const std::uint32_t (&costs)[words], int i) {
  const int lane{static_cast<int>(threadIdx.x) % 32};
  const std::uint32_t neighbour{__shfl_up_sync(all_lanes, costs[i], 1)};
  const std::uint32_t wrapped{i > 0 ? __shfl_sync(all_lanes, costs[i > 0 ? i - 1 : 0], 31) : twice(cost_max)};
  return lane > 0 ? neighbour : wrapped;
}
template <int words>
__device__ inline std::uint32_t after_lane(const std::uint32_t (&costs)[words], int i) {
  const int lane{static_cast<int>(threadIdx.x) % 32};
  const std::uint32_t neighbour{__shfl_down_sync(all_lanes, costs[i], 1)};
  const std::uint32_t wrapped{i + 1 < words ? __shfl_sync(all_lanes, costs[i + 1 < words ? i + 1 : 0], 0)
                                            : twice(cost_max)};
  return lane < 31 ? neighbour : wrapped;
}

/// The smallest cost of all labels, in all lanes.
template <int words>
__device__ inline unsigned smallest_of(const PathCosts<words>& path) {
  std::uint32_t both{__vminu2(path.road.even[0], path.road.odd[0])};
  for (int i{0}; i < words; ++i) both = __vminu2(both, __vminu2(path.upright.even[i], path.upright.odd[i]));
  return least_of_lanes<32>(min(both & 0xffffu, both >> 16));
}

/// Costs of one hypothesis' labels from those of the pixel before on the path. `smallest`: of the pixel before, twice;
/// `ways`: further ways into the labels.
template <int words>
__device__ inline LaneCosts<words> advance(const LaneCosts<words>& before, const LaneCosts<words>& pixel,
                                           std::uint32_t smallest, std::uint32_t step, std::uint32_t jump,
                                           const LaneCosts<words>& ways) {
  LaneCosts<words> path;
  for (int i{0}; i < words; ++i) {
    const std::uint32_t even{before.even[i]};
    const std::uint32_t odd{before.odd[i]};
    const std::uint32_t below_even{__byte_perm(before_lane(before.odd, i), odd, 0x5432)};
    const std::uint32_t above_odd{__byte_perm(even, after_lane(before.even, i), 0x5432)};
    const auto cheapest = [&](std::uint32_t same, std::uint32_t below, std::uint32_t above, std::uint32_t way) {
      return __vminu2(__vminu2(same, __vminu2(below, above) + step), __vminu2(smallest + jump, way));
    };
    path.even[i] = __vminu2(pixel.even[i] + cheapest(even, below_even, odd, ways.even[i]) - smallest, twice(cost_max));
    path.odd[i] = __vminu2(pixel.odd[i] + cheapest(odd, even, above_odd, ways.odd[i]) - smallest, twice(cost_max));
  }
  return path;
}

/// The cheapest of three neighbours for four labels, of bytes that begin one label before the first.
__device__ inline void cheapest_of_three(const std::uint8_t* bytes, std::uint32_t change, std::uint32_t& even,
                                         std::uint32_t& odd) {
  const auto of = [&](int k) {
    return min(static_cast<unsigned>(bytes[k]),
               min(static_cast<unsigned>(bytes[k + 1]), static_cast<unsigned>(bytes[k + 2])));
  };
  even = (of(0) | of(2) << 16) + change;
  odd = (of(1) | of(3) << 16) + change;
}

/// Ways from the road below into upright labels where both have the same disparity. cheapest_of_three beyond the road's
/// labels would be cost_max, which is never the cheapest way into an upright label.
template <int words>
__device__ inline LaneCosts<words> ways_from_road(const PathCosts<words>& before, int meeting, std::uint32_t change,
                                                  ChangeRoom& room) {
  const int lane{static_cast<int>(threadIdx.x) % 32};
  if (lane < ChangeRoom::before) room.costs[lane] = ~0u;
  if (lane < road_lanes) room.costs[ChangeRoom::before + lane] = packed(before.road, 0);
  if (lane == road_lanes) room.costs[ChangeRoom::road - 1] = ~0u;
  __syncwarp();
  LaneCosts<words> ways{filled<words>(2 * cost_max)};
  for (int i{0}; i < words; ++i) {
    const int first{4 * (lane + 32 * i) - meeting};  // the road label that meets the word's first one
    if (first < -4 || first >= 4 * road_lanes) continue;
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(room.costs + ChangeRoom::before) + first - 1;
    cheapest_of_three(bytes, change, ways.even[i], ways.odd[i]);
  }
  __syncwarp();
  return ways;
}

/// A step of a path, upwards or along a row. Equal to `advance` of the reference.
template <bool is_up, int words>
__device__ inline PathCosts<words> advance(const PathCosts<words>& before, const PixelCosts<words>& pixel,
                                           const StepPenalties& penalties, ChangeRoom& room) {
  const std::uint32_t smallest{smallest_of(before) * 0x00010001u};
  const PathCosts<words> costs{first_costs(pixel)};
  LaneCosts<words> into_upright{filled<words>(2 * cost_max)};
  if (is_up && pixel.meeting >= 0) into_upright = ways_from_road(before, pixel.meeting, penalties.change, room);
  PathCosts<words> path{advance(before.upright, costs.upright, smallest, penalties.step, penalties.jump, into_upright),
                        costs.road};
  if (pixel.meeting != no_road) {
    path.road =
        advance(before.road, costs.road, smallest, penalties.road_step, penalties.jump, filled<1>(2 * cost_max));
  }
  return path;
}

}  // namespace stereogrid
