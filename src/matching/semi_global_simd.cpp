// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. All vectors run along the labels of one pixel.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/semi_global_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                             // IWYU pragma: keep
// after foreach_target
#include "hwy/highway.h"
#include "matching/curve-inl.hpp"
#include "matching/semi_global_simd.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>

HWY_BEFORE_NAMESPACE();
namespace stereogrid {
namespace HWY_NAMESPACE {
namespace {

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

// Right descriptors of one row from right to left, borders repeated.
class Reversed {
 public:
  Reversed(std::uint32_t* memory, Shifts shifts)
      : memory_{memory}, first_{shifts.first}, offset_{std::max(0, -shifts.first)} {}

  void fill(const std::uint32_t* row, int width, int labels) {
    width_ = width;
    const int length{at(0) + labels};
    for (int j{0}; j < length; ++j) memory_[j] = row[std::clamp(width - 1 + offset_ - j, 0, width - 1)];
  }
  // place of the right pixel of u and the first shift
  [[nodiscard]] int at(int u) const { return width_ - 1 - u + first_ + offset_; }
  [[nodiscard]] const std::uint32_t* of(int u) const { return memory_ + at(u); }

 private:
  std::uint32_t* memory_;
  int first_;
  int offset_;
  int width_{0};
};

void hamming(std::uint32_t left, const std::uint32_t* right, int count, int n, std::uint8_t* out) {
  const hn::CappedTag<std::uint32_t, road_block> d32;
  const hn::Rebind<std::uint8_t, decltype(d32)> d8;
  const int lanes{static_cast<int>(hn::Lanes(d32))};
  const auto descriptor = hn::Set(d32, left);
  for (int k{0}; k < n; k += lanes) {
    const auto differing = hn::PopulationCount(hn::Xor(descriptor, hn::LoadU(d32, right + k)));
    hn::StoreU(hn::U8FromU32(differing), d8, out + k);
  }
  std::fill(out + count, out + n, unreachable);
}

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

template <class D16>
void add_to_sums(D16 d16, const std::uint8_t* path, int n, bool overwrite, std::uint16_t* sums) {
  const hn::Rebind<std::uint8_t, D16> d8;
  const int lanes{static_cast<int>(hn::Lanes(d16))};
  for (int k{0}; k < n; k += lanes) {
    const auto cost = hn::PromoteTo(d16, hn::LoadU(d8, path + k));
    hn::StoreU(overwrite ? cost : hn::Add(cost, hn::LoadU(d16, sums + k)), d16, sums + k);
  }
}

// Working memory of one part, and what is computed in it for single pixels.
class Worker {
 public:
  Worker(const SemiGlobalTask& task, std::uint8_t* memory)
      : task_{task},
        layout_{task},
        step_{task_, layout_},
        right_{reinterpret_cast<std::uint32_t*>(memory), task.upright},
        sheared_{reinterpret_cast<std::uint32_t*>(memory) + layout_.reach, task.road},
        costs_{memory + 8 * static_cast<std::size_t>(layout_.reach)},
        paths_{costs_ + layout_.stride} {}

  static std::size_t memory_of(const SemiGlobalTask& task) {
    const Layout layout{task};
    // reversed rows (the same room serves the right-to-left test), the costs of a pixel, two rows of paths
    return 8 * static_cast<std::size_t>(layout.reach) +
           static_cast<std::size_t>(layout.stride) * (1 + 2 * static_cast<std::size_t>(task.census.left.width)) + 128;
  }

  void rows(int begin, int end) {
    std::memset(costs_, unreachable, static_cast<std::size_t>(3 * layout_.stride));
    for (int v{begin}; v < end; ++v) {
      start_row(v);
      const int width{task_.census.left.width};
      std::uint8_t smallest{0};
      for (int u{0}; u < width; ++u) smallest = go(u, v, u % 2, 1 - u % 2, u == 0, smallest, true);
      for (int u{width - 1}; u >= 0; --u) smallest = go(u, v, u % 2, 1 - u % 2, u == width - 1, smallest, false);
    }
  }

  void columns(int begin, int end) {
    const int count{end - begin};
    std::memset(costs_, unreachable,
                static_cast<std::size_t>(layout_.stride) * static_cast<std::size_t>(1 + 2 * count));
    const int last{task_.census.left.height - 1};
    for (int i{0}; i <= 2 * last + 1; ++i) {
      const int v{i <= last ? i : 2 * last + 1 - i};
      const bool begins{i == 0 || i == last + 1};
      start_row(v);
      for (int u{begin}; u < end; ++u) {
        const int now{(i % 2) * count + u - begin};
        const int before{(1 - i % 2) * count + u - begin};
        // each column's smallest cost waits in the guard behind its labels
        const std::uint8_t smallest{begins ? std::uint8_t{0} : last_byte(before)};
        last_byte(now) = go(u, v, now, before, begins, smallest, false);
      }
    }
  }

  void choose(int begin, int end) {
    for (int v{begin}; v < end; ++v) {
      choose_row(Upright16{}, v, 0, layout_.uprights, task_.upright, task_.upright_candidates.row(v));
      choose_row(Road16{}, v, layout_.uprights, layout_.roads, task_.road, task_.level_candidates.row(v));
    }
  }

 private:
  void start_row(int v) {
    const int width{task_.census.left.width};
    right_.fill(task_.census.right.row(v), width, layout_.uprights);
    sheared_.fill(task_.census.sheared.row(v), width, layout_.roads);
  }

  [[nodiscard]] Costs path(int slot) const {
    return {paths_ + static_cast<std::size_t>(slot) * static_cast<std::size_t>(layout_.stride), layout_};
  }
  [[nodiscard]] std::uint8_t& last_byte(int slot) const {
    return paths_[static_cast<std::size_t>(slot + 1) * static_cast<std::size_t>(layout_.stride) - 1];
  }
  [[nodiscard]] std::uint16_t* sums(int u, int v) const {
    return task_.sums + (static_cast<std::size_t>(v) * static_cast<std::size_t>(task_.census.left.width) +
                         static_cast<std::size_t>(u)) *
                            static_cast<std::size_t>(layout_.uprights + layout_.roads);
  }

  // One pixel of a path, from slot `before` to slot `now`; returns its smallest cost.
  std::uint8_t go(int u, int v, int now, int before, bool begins, std::uint8_t smallest, bool overwrite) {
    const Costs costs{costs_, layout_};
    const std::uint32_t left{task_.census.left(u, v)};
    hamming(left, right_.of(u), task_.upright.count, layout_.uprights, costs.upright);
    hamming(left, sheared_.of(u), task_.road.count, layout_.roads, costs.road);
    const int meeting{meeting_disparity(task_.plane, u, v) + task_.road.first - task_.upright.first};
    const Costs to{path(now)};
    smallest = begins ? step_.begin(costs, to) : step_.advance(costs, path(before), smallest, meeting, to);
    add_to_sums(Upright16{}, to.upright, layout_.uprights, overwrite, sums(u, v));
    add_to_sums(Road16{}, to.road, layout_.roads, overwrite, sums(u, v) + layout_.uprights);
    return smallest;
  }

  template <class D16>
  void choose_row(D16 d16, int v, int from, int n, Shifts shifts, Candidate* candidates) {
    const int width{task_.census.left.width};
    const int offset{std::max(0, -shifts.first)};
    const auto start = [&](int u) { return width - 1 - u + shifts.first + offset; };
    auto* const right_cost{reinterpret_cast<std::uint16_t*>(costs_ - 8 * static_cast<std::size_t>(layout_.reach))};
    auto* const right_best{right_cost + layout_.reach};
    std::fill(right_cost, right_cost + start(0) + n, std::uint16_t{65535});
    for (int u{0}; u < width; ++u) {
      candidates[u] = candidate_of(d16, sums(u, v) + from, shifts, n);
      offer_to_right(d16, sums(u, v) + from, right_cost + start(u), right_best + start(u), n);
    }
    for (int u{0}; u < width; ++u) {
      const int right_u{u - candidates[u].shift};
      if (right_u < 0 || right_u >= width) continue;
      const int best{right_best[start(u) + candidates[u].shift - shifts.first]};
      candidates[u].consistent = std::abs(shifts.first + best - candidates[u].shift) <= task_.left_right_px;
    }
  }

  const SemiGlobalTask& task_;
  Layout layout_;
  PathStep step_;
  Reversed right_;
  Reversed sheared_;
  std::uint8_t* costs_;
  std::uint8_t* paths_;
};

void Rows(const SemiGlobalTask& task, int begin, int end, std::uint8_t* memory) {
  Worker{task, memory}.rows(begin, end);
}
void Columns(const SemiGlobalTask& task, int begin, int end, std::uint8_t* memory) {
  Worker{task, memory}.columns(begin, end);
}
void Choose(const SemiGlobalTask& task, int begin, int end, std::uint8_t* memory) {
  Worker{task, memory}.choose(begin, end);
}
std::size_t Memory(const SemiGlobalTask& task) {
  return Worker::memory_of(task);
}
std::size_t LabelCount(const SemiGlobalTask& task) {
  const Layout layout{task};
  return static_cast<std::size_t>(layout.uprights + layout.roads);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stereogrid
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(Rows);
HWY_EXPORT(Columns);
HWY_EXPORT(Choose);
HWY_EXPORT(Memory);
HWY_EXPORT(LabelCount);

std::size_t semi_global_labels(const SemiGlobalTask& task) {
  return HWY_DYNAMIC_DISPATCH(LabelCount)(task);
}
std::size_t semi_global_memory(const SemiGlobalTask& task) {
  return HWY_DYNAMIC_DISPATCH(Memory)(task);
}
void semi_global_rows(const SemiGlobalTask& task, int begin, int end, std::uint8_t* memory) {
  HWY_DYNAMIC_DISPATCH(Rows)(task, begin, end, memory);
}
void semi_global_columns(const SemiGlobalTask& task, int begin, int end, std::uint8_t* memory) {
  HWY_DYNAMIC_DISPATCH(Columns)(task, begin, end, memory);
}
void semi_global_choose(const SemiGlobalTask& task, int begin, int end, std::uint8_t* memory) {
  HWY_DYNAMIC_DISPATCH(Choose)(task, begin, end, memory);
}

}  // namespace stereogrid
#endif
