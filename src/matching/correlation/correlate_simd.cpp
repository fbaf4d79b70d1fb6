// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/correlation/correlate_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                                       // IWYU pragma: keep
// after foreach_target
#include "hwy/highway.h"
#include "matching/correlation/simd.hpp"
#if HWY_TARGET != HWY_SCALAR
#include "matching/correlation/level_simd.hpp"
#include "matching/correlation/upright_simd.hpp"
#endif

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {
namespace {

#if HWY_TARGET != HWY_SCALAR

template <int shift_count, int tile>
void correlate_rows(const Band& band) {
  const ShortCensus& census{band.census};
  const int half{band.half_window};
  const int width{census.left.width()};
  using Upright = UprightRows<shift_count, tile>;
  Upright upright{width, band.upright, half, band.uniqueness_1024, band.memory};
  LevelRows level{width, half, band.uniqueness_1024, band.memory + Upright::memory(width, half)};
  const auto left = [&](int v) { return census.left.clamped_row(v); };
  const auto right_reversed = [&](int v) { return census.right_reversed.clamped_row(v); };
  // one row too many, which the first step takes away
  for (int v{band.first_row - half - 1}; v < band.first_row + half; ++v) upright.add_row(left(v), right_reversed(v));
  for (int v{band.first_row - half}; v < band.first_row + half; ++v) {
    level.add_row(left(v), census.sheared.clamped_row(v));
  }
  for (int v{band.first_row}; v < band.end_row; ++v) {
    const int in{v + half};
    const int out{v - half - 1};
    CandidateRow& of_upright{band.candidates->upright};
    CandidateRow& of_level{band.candidates->level};
    level.find_costs(left(in), census.sheared.clamped_row(in), of_level);
    upright.finish_row(left(in), right_reversed(in), left(out), right_reversed(out),
                       {of_level.cost(), columns_of_road(road_row(band.plane, v), width), band.cost_limit}, of_upright);
    level.compare_costs(of_upright.cost(), of_level);
    band.sink->take(v, *band.candidates);
  }
}

// In the largest tiles whose sums fit.
template <int shift_count>
void correlate_shifts(const Band& band) {
  const int window{2 * band.half_window + 1};
  const int cost_max{compared_bits(window) * window * window};
  if (UprightBlock<shift_count, shift_count>::holds(cost_max)) return correlate_rows<shift_count, shift_count>(band);
  if (UprightBlock<shift_count, shift_count / 2>::holds(cost_max)) {
    return correlate_rows<shift_count, shift_count / 2>(band);
  }
  correlate_rows<shift_count, 32>(band);
}

void Correlate(const Band& band) {
  switch (padded_upright(band.upright)) {
    case 64:
      return correlate_shifts<64>(band);
    case 128:
      return correlate_shifts<128>(band);
    case 192:
      return correlate_shifts<192>(band);
    default:
      return correlate_shifts<256>(band);
  }
}

#else

void Correlate(const Band&) {}

#endif

const char* Target() {
  return hwy::TargetName(HWY_TARGET);
}

}  // namespace
}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(Correlate);
HWY_EXPORT(Target);

std::size_t correlate_memory(int width, Shifts upright, int half_window) {
  const int n{padded_upright(upright)};
  const std::size_t of_upright{static_cast<std::size_t>(width + 2 * half_window + 1) * static_cast<std::size_t>(n)};
  const std::size_t of_split_rows{static_cast<std::size_t>(8 * (width + n) + 4 * width + 512)};
  const std::size_t of_row{static_cast<std::size_t>(width + 4 * half_window + 256)};
  const int rows_of_level{road_shifts.count * (2 * half_window + 6)};
  return (of_upright + of_split_rows + of_row * static_cast<std::size_t>(rows_of_level) + 63) / 64 * 64;
}

int correlate_border(Shifts upright) {
  return std::max(padded_upright(upright), road_shifts.count) + 64;
}

void correlate_band(const Band& band) {
  HWY_DYNAMIC_DISPATCH(Correlate)(band);
}

std::string_view correlate_target() {
  return HWY_DYNAMIC_DISPATCH(Target)();
}

}  // namespace stereogrid
#endif
