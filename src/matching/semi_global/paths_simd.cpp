// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. All vectors run along the labels of one pixel.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/semi_global/paths_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                                   // IWYU pragma: keep
// after foreach_target
#include "hwy/highway.h"
#include "matching/semi_global/choose_simd.hpp"
#include "matching/semi_global/labels_simd.hpp"
#include "matching/semi_global/paths_simd.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <type_traits>

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR  // never called, see correlate_target
void StartRow(const SemiGlobalTask&, const SemiGlobalRoom&, int) {}
void Forward(const SemiGlobalTask&, const SemiGlobalRoom&, int, int, int) {}
void Backward(const SemiGlobalTask&, const SemiGlobalRoom&, int) {}
#else

// Bytes of a row's descriptors, each kind on its own, from `lead` pixels before the row on; the border is repeated.
void split(const std::uint32_t* row, int width, int lead, int length, std::uint8_t* const* planes) {
  const auto* const bytes{reinterpret_cast<const std::uint8_t*>(row)};
  for (int i{0}; i < SemiGlobalRoom::planes; ++i) {
    std::uint8_t* plane{planes[i]};
    const auto inner = [&](int j) { return std::clamp(j, 0, length); };
    std::fill(plane, plane + inner(lead), bytes[i]);
    for (int j{inner(lead)}; j < inner(lead + width); ++j) plane[j] = bytes[4 * (j - lead) + i];
    std::fill(plane + inner(lead + width), plane + length, bytes[4 * (width - 1) + i]);
  }
}

void StartRow(const SemiGlobalTask& task, const SemiGlobalRoom& room, int v) {
  const int width{task.census.left.width};
  const LabelLayout& layout{task.layout};
  split(task.census.right.row(v), width, layout.upright_at + task.upright.count - 1, width + layout.uprights,
        room.right);
  split(task.census.sheared.row(v), width, layout.road_at - layout.uprights + task.road.first + task.road.count - 1,
        width + layout.stride - layout.uprights, room.sheared);
  for (int u{0}; u < width; ++u) {
    const int meeting{meeting_label(task.plane, task.upright, task.road, u, v)};
    room.meeting[u] = meeting < 0 ? -1 : layout.uprights - task.road.count - meeting;
  }
  std::memset(room.carry, 0, static_cast<std::size_t>(layout.stride));
}

// A row at work; `uprights` and `tail` are the vectors of the labels, the tail none where the row has no road.
template <int uprights, int tail>
class Row {
 public:
  static constexpr int all{uprights + tail};

  Row(const SemiGlobalTask& task, const SemiGlobalRoom& room, int v) : task_{task}, room_{room}, v_{v} {
    closes_road_ = tail == 0 && v > 0 && row_has_road(task.plane, task.census.left.width, v - 1);
  }

  HWY_INLINE void forward(int begin, int end) {
    Labels<all> before{load<all>(room_.carry)};
    for (int u{begin}; u < end; ++u) {
      const Labels<all> costs{costs_at(u)};
      store(costs, at(room_.costs, u));
      const Labels<all> path{sum(costs, step_.template way<uprights>(before))};
      before = step_.passed_on(path);
      store(sum(path, from_below(u, costs)), at(room_.sums, u));
    }
    store(before, room_.carry);
  }

  HWY_INLINE void backward() {
    Labels<all> before;
    for (V8& part : before.part) part = hn::Zero(D8{});
    for (int u{task_.census.left.width - 1}; u >= 0; --u) {
      const Labels<all> path{sum(load<all>(at(room_.costs, u)), step_.template way<uprights>(before))};
      before = step_.passed_on(path);
      store(sum(path, load<all>(at(room_.sums, u))), at(room_.sums, u));
      choose_at(u);
    }
    const int width{task_.census.left.width};
    finish(width, task_.upright, task_.uniqueness_1024, room_.upright, room_.candidates->upright);
    if (tail > 0) {
      finish(width, task_.road, task_.uniqueness_1024, room_.road, room_.candidates->level);
    } else {
      const Candidate none{cost_max, 1, cost_max, cost_max, static_cast<std::int16_t>(task_.road.first)};
      for (int u{0}; u < width; ++u) room_.candidates->level.set(u, none);
    }
    task_.sink->take(v_, *room_.candidates);
  }

 private:
  [[nodiscard]] HWY_INLINE std::uint8_t* at(std::uint8_t* pixels, int u) const {
    return pixels + static_cast<std::ptrdiff_t>(u) * task_.layout.stride;
  }
  // Hamming distances.
  HWY_INLINE Labels<all> costs_at(int u) const {
    const D8 d8;
    const auto* const left{reinterpret_cast<const std::uint8_t*>(&task_.census.left(u, v_))};
    Labels<all> costs;
    const V8 left0{hn::Set(d8, left[0])};
    const V8 left1{hn::Set(d8, left[1])};
    const V8 left2{hn::Set(d8, left[2])};
    const V8 left3{hn::Set(d8, left[3])};
    for (int i{0}; i < all; ++i) {
      const bool upright{i < uprights};
      const int place{u + (upright ? i : i - uprights) * lanes};
      const auto bits = [&](V8 descriptor, int plane) {
        const V8 other{hn::LoadU(d8, (upright ? room_.right : room_.sheared)[plane] + place)};
        return hn::PopulationCount(hn::Xor(descriptor, other));
      };
      const V8 differing{hn::Add(hn::Add(bits(left0, 0), bits(left1, 1)), hn::Add(bits(left2, 2), bits(left3, 3)))};
      costs.part[i] = hn::Or(differing, hn::Load(d8, room_.closed + i * lanes));
    }
    return costs;
  }

  // The path from the row below.
  HWY_INLINE Labels<all> from_below(int u, const Labels<all>& costs) const {
    std::uint8_t* const vertical{at(task_.vertical, u)};
    Labels<all> ways{step_.template way<uprights, all>(vertical)};
    const int meeting{tail > 0 ? room_.meeting[u] : -1};
    if (meeting >= 0) {
      step_.template from_road<uprights>(vertical + task_.layout.road_at, task_.road.count, meeting, ways);
    }
    const Labels<all> path{sum(costs, ways)};
    pass_on(path, vertical);
    return path;
  }

  HWY_INLINE void pass_on(const Labels<all>& path, std::uint8_t* memory) const {
    store(step_.passed_on(path), memory);
    if (tail == 0 && closes_road_) {
      std::memset(memory + task_.layout.uprights, cost_max,
                  static_cast<std::size_t>(task_.layout.stride - task_.layout.uprights));
    }
  }

  HWY_INLINE void choose_at(int u) const {
    const std::uint8_t* const sums{at(room_.sums, u)};
    choose<uprights * lanes>(D8{}, sums, task_.layout.uprights - 1, u, room_.upright);
    if (tail == 0) return;
    const hn::FixedTag<std::uint8_t, 16> block;
    static_assert(road_shifts.count <= 16);
    choose<16>(block, sums + task_.layout.road_at, road_shifts.count - 1, u, room_.road);
  }

  // copies, which stores into the costs cannot change
  const SemiGlobalTask task_;
  const SemiGlobalRoom room_;
  int v_;
  PathStep step_;
  bool closes_road_;  // the row above has road, which cannot be reached from this one
};

// Calls work(Row) with the kind of row that v is.
template <class Work>
void with_row(const SemiGlobalTask& task, const SemiGlobalRoom& room, int v, const Work& work) {
  constexpr int block{LabelLayout::block / lanes};
  const bool has_road{row_has_road(task.plane, task.census.left.width, v)};
  const auto of_size = [&](auto blocks) {
    constexpr int uprights{decltype(blocks)::value * block};
    has_road ? work(Row<uprights, block>{task, room, v}) : work(Row<uprights, 0>{task, room, v});
  };
  switch (task.layout.uprights / LabelLayout::block) {
    case 1:
      return of_size(std::integral_constant<int, 1>{});
    case 2:
      return of_size(std::integral_constant<int, 2>{});
    case 3:
      return of_size(std::integral_constant<int, 3>{});
    default:
      return of_size(std::integral_constant<int, 4>{});
  }
}

void Forward(const SemiGlobalTask& task, const SemiGlobalRoom& room, int v, int begin, int end) {
  with_row(task, room, v, [&](auto&& row) { row.forward(begin, end); });
}
void Backward(const SemiGlobalTask& task, const SemiGlobalRoom& room, int v) {
  with_row(task, room, v, [&](auto&& row) { row.backward(); });
}
#endif

}  // namespace
}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(StartRow);
HWY_EXPORT(Forward);
HWY_EXPORT(Backward);

void semi_global_start_row(const SemiGlobalTask& task, const SemiGlobalRoom& room, int v) {
  HWY_DYNAMIC_DISPATCH(StartRow)(task, room, v);
}
void semi_global_forward(const SemiGlobalTask& task, const SemiGlobalRoom& room, int v, int begin, int end) {
  HWY_DYNAMIC_DISPATCH(Forward)(task, room, v, begin, end);
}
void semi_global_backward(const SemiGlobalTask& task, const SemiGlobalRoom& room, int v) {
  HWY_DYNAMIC_DISPATCH(Backward)(task, room, v);
}

}  // namespace stereogrid
#endif
