// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. All vectors run along the labels of one pixel.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/semi_global_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                             // IWYU pragma: keep
// after foreach_target
#include "hwy/highway.h"
#include "matching/curve_simd.hpp"
#include "matching/semi_global_path_simd.hpp"
#include "matching/semi_global_simd.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>

HWY_BEFORE_NAMESPACE();
namespace stereogrid {
namespace HWY_NAMESPACE {
namespace {

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
        upright_order_{task.census.left.width, task.upright},
        road_order_{task.census.left.width, task.road},
        right_{reinterpret_cast<std::uint32_t*>(memory)},
        sheared_{right_ + layout_.reach},
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

  void choose(int begin, int end, RowCandidates& candidates) {
    for (int v{begin}; v < end; ++v) {
      choose_row(Upright16{}, sums(0, v), layout_.uprights, task_.upright, candidates.upright);
      choose_row(Road16{}, sums(0, v) + layout_.uprights, layout_.roads, task_.road, candidates.level);
      task_.sink->take(v, candidates);
    }
  }

 private:
  void start_row(int v) {
    upright_order_.reverse(task_.census.right.row(v), layout_.uprights, right_);
    road_order_.reverse(task_.census.sheared.row(v), layout_.roads, sheared_);
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
    hamming(left, right_ + upright_order_.start(u), layout_.uprights, costs.upright);
    hamming(left, sheared_ + road_order_.start(u), layout_.roads, costs.road);
    std::fill(costs.upright + task_.upright.count, costs.upright + layout_.uprights, unreachable);
    std::fill(costs.road + task_.road.count, costs.road + layout_.roads, unreachable);
    const int meeting{meeting_disparity(task_.plane, u, v) + task_.road.first - task_.upright.first};
    const Costs to{path(now)};
    smallest = begins ? step_.begin(costs, to) : step_.advance(costs, path(before), smallest, meeting, to);
    add_to_sums(Upright16{}, to.upright, layout_.uprights, overwrite, sums(u, v));
    add_to_sums(Road16{}, to.road, layout_.roads, overwrite, sums(u, v) + layout_.uprights);
    return smallest;
  }

  // `costs`: summed costs of the row's first pixel; those of the next follow behind all its labels.
  template <class D16>
  void choose_row(D16 d16, std::uint16_t* costs, int n, Shifts shifts, CandidateRow& candidates) const {
    for (int u{0}; u < task_.census.left.width; ++u, costs += layout_.uprights + layout_.roads) {
      candidates.set(u, candidate_of(d16, costs, shifts, task_.uniqueness_1024, n));
    }
  }

  const SemiGlobalTask& task_;
  Layout layout_;
  PathStep step_;
  RightToLeft upright_order_;
  RightToLeft road_order_;
  std::uint32_t* right_;  // descriptors of the row at work, in these orders
  std::uint32_t* sheared_;
  std::uint8_t* costs_;
  std::uint8_t* paths_;
};

void Rows(const SemiGlobalTask& task, int begin, int end, std::uint8_t* memory) {
  Worker{task, memory}.rows(begin, end);
}
void Columns(const SemiGlobalTask& task, int begin, int end, std::uint8_t* memory) {
  Worker{task, memory}.columns(begin, end);
}
void Choose(const SemiGlobalTask& task, int begin, int end, std::uint8_t* memory, RowCandidates& candidates) {
  Worker{task, memory}.choose(begin, end, candidates);
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
void semi_global_choose(const SemiGlobalTask& task, int begin, int end, std::uint8_t* memory,
                        RowCandidates& candidates) {
  HWY_DYNAMIC_DISPATCH(Choose)(task, begin, end, memory, candidates);
}

}  // namespace stereogrid
#endif
