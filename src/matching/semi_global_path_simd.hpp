// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// One step of a path of semi-global matching with vectors. Included once per instruction set; the guard works per
// target.
#if defined(STEREOGRID_SEMI_GLOBAL_PATH_SIMD) == defined(HWY_TARGET_TOGGLE)
#ifdef STEREOGRID_SEMI_GLOBAL_PATH_SIMD
#undef STEREOGRID_SEMI_GLOBAL_PATH_SIMD
#else
#define STEREOGRID_SEMI_GLOBAL_PATH_SIMD
#endif

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "hwy/highway.h"
#include "matching/semi_global_simd.hpp"

HWY_BEFORE_NAMESPACE();
namespace stereogrid {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Upright labels come in blocks that every target's vectors divide, road labels in small ones. Around both lie guards
// of unreachable labels, so that neighbours and crossings need no test.
constexpr int block{64};
constexpr int road_block{16};
constexpr int guard{64};
constexpr std::uint8_t unreachable{255};

using Upright8 = hn::ScalableTag<std::uint8_t>;
using Road8 = hn::CappedTag<std::uint8_t, road_block>;
using Upright16 = hn::ScalableTag<std::uint16_t>;
using Road16 = hn::CappedTag<std::uint16_t, road_block>;

struct Layout {
  explicit Layout(const SemiGlobalTask& task)
      : uprights{(task.upright.count + block - 1) / block * block},
        roads{(task.road.count + road_block - 1) / road_block * road_block},
        road_start{guard + uprights + guard},
        stride{(road_start + roads + guard + 63) / 64 * 64},
        reach{task.census.left.width + 2 * uprights + 2 * std::abs(task.road.first)} {}

  int uprights;    // padded
  int roads;       // padded
  int road_start;  // place of the first road label in a pixel's costs; upright labels begin at `guard`
  int stride;
  int reach;  // length of an array of right pixels
};

// Costs of one pixel with guards around them.
struct Costs {
  std::uint8_t* upright;
  std::uint8_t* road;
  Costs(std::uint8_t* start, const Layout& layout) : upright{start + guard}, road{start + layout.road_start} {}
};

template <class D8>
std::uint8_t smallest_of([[maybe_unused]] D8 d8, hn::Vec<D8> values) {
#if HWY_TARGET == HWY_SCALAR
  return hn::GetLane(values);
#else
  const hn::Half<D8> half;
  const hn::Rebind<std::uint16_t, decltype(half)> d16;
  const auto smaller = hn::Min(hn::LowerHalf(half, values), hn::UpperHalf(half, values));
  return static_cast<std::uint8_t>(hn::GetLane(hn::MinOfLanes(d16, hn::PromoteTo(d16, smaller))));
#endif
}

// Cheapest of three neighbouring labels.
template <class D8>
hn::Vec<D8> cheapest_of_three(D8 d8, const std::uint8_t* middle) {
  return hn::Min(hn::LoadU(d8, middle), hn::Min(hn::LoadU(d8, middle - 1), hn::LoadU(d8, middle + 1)));
}

// One step of a path (reference: advance). `smallest`: of all labels before; returns that of the new ones.
class PathStep {
 public:
  PathStep(const SemiGlobalTask& task, const Layout& layout) : task_{task}, layout_{layout} {}

  std::uint8_t begin(const Costs& costs, const Costs& path) const {
    std::memcpy(path.upright, costs.upright, static_cast<std::size_t>(layout_.uprights));
    std::memcpy(path.road, costs.road, static_cast<std::size_t>(layout_.roads));
    return smallest(path);
  }

  std::uint8_t advance(const Costs& costs, const Costs& before, std::uint8_t smallest_before, int meeting,
                       const Costs& path) const {
    within(Upright8{}, costs.upright, before.upright, layout_.uprights, smallest_before, path.upright);
    within(Road8{}, costs.road, before.road, layout_.roads, smallest_before, path.road);
    if (meeting >= -layout_.roads - 1 && meeting <= layout_.uprights + 1) {
      cross(costs, before, smallest_before, meeting, path);
    }
    return smallest(path);
  }

 private:
  template <class D8>
  void within(D8 d8, const std::uint8_t* costs, const std::uint8_t* before, int n, std::uint8_t smallest_before,
              std::uint8_t* path) const {
    const int lanes{static_cast<int>(hn::Lanes(d8))};
    const auto step = hn::Set(d8, static_cast<std::uint8_t>(task_.penalties.step));
    const auto least = hn::Set(d8, smallest_before);
    const auto jump = hn::SaturatedAdd(least, hn::Set(d8, static_cast<std::uint8_t>(task_.penalties.jump)));
    for (int k{0}; k < n; k += lanes) {
      const auto beside = hn::Min(hn::LoadU(d8, before + k - 1), hn::LoadU(d8, before + k + 1));
      const auto way = hn::Min(hn::Min(hn::LoadU(d8, before + k), hn::SaturatedAdd(beside, step)), jump);
      hn::StoreU(hn::SaturatedAdd(hn::LoadU(d8, costs + k), hn::Sub(way, least)), d8, path + k);
    }
  }

  // From one hypothesis to the other where their disparities differ by at most 1.
  void cross(const Costs& costs, const Costs& before, std::uint8_t smallest_before, int meeting,
             const Costs& path) const {
    const Road8 d8;
    const int lanes{static_cast<int>(hn::Lanes(d8))};
    const auto least = hn::Set(d8, smallest_before);
    const auto change = hn::Set(d8, static_cast<std::uint8_t>(task_.penalties.change));
    const auto offer = [&](const std::uint8_t* from, const std::uint8_t* cost, std::uint8_t* to) {
      const auto way = hn::Sub(hn::SaturatedAdd(cheapest_of_three(d8, from), change), least);
      hn::StoreU(hn::Min(hn::LoadU(d8, to), hn::SaturatedAdd(hn::LoadU(d8, cost), way)), d8, to);
    };
    // an upright label is reached from road labels − meeting − 1 … + 1, so one more on either side
    for (int k{-1}; k < layout_.roads + 1; k += lanes) {
      offer(before.road + k, costs.upright + meeting + k, path.upright + meeting + k);
    }
    for (int k{0}; k < layout_.roads; k += lanes) {
      offer(before.upright + meeting + k, costs.road + k, path.road + k);
    }
  }

  std::uint8_t smallest(const Costs& path) const {
    const Upright8 upright8;
    auto low = hn::LoadU(upright8, path.upright);
    for (int k{0}; k < layout_.uprights; k += static_cast<int>(hn::Lanes(upright8))) {
      low = hn::Min(low, hn::LoadU(upright8, path.upright + k));
    }
    const Road8 road8;
    auto road_low = hn::LoadU(road8, path.road);
    for (int k{0}; k < layout_.roads; k += static_cast<int>(hn::Lanes(road8))) {
      road_low = hn::Min(road_low, hn::LoadU(road8, path.road + k));
    }
    return std::min(smallest_of(upright8, low), smallest_of(road8, road_low));
  }

  const SemiGlobalTask& task_;
  const Layout& layout_;
};

}  // namespace HWY_NAMESPACE
}  // namespace stereogrid
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
