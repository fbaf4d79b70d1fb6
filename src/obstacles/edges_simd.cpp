// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along the pixels of a row.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "obstacles/edges_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                        // IWYU pragma: keep
// after foreach_target
#include "hwy/highway.h"
#include "obstacles/edges_simd.hpp"

#include <algorithm>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace stereogrid {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr float nothing{std::numeric_limits<float>::max()};

float kept_at(const float* row, int width, int u) {
  float most{0};
  float least{nothing};
  for (int i{std::max(u - edge_reach_px, 0)}; i <= std::min(u + edge_reach_px, width - 1); ++i) {
    most = std::max(most, row[i]);
    if (row[i] > 0) least = std::min(least, row[i]);
  }
  return most > row[u] + edge_step_px && least < row[u] - edge_step_px ? 0.0f : row[u];
}

void LeaveEdgesOut(const float* row, int width, float* kept) {
  const hn::CappedTag<float, 16> d;
  const int lanes{static_cast<int>(hn::Lanes(d))};
  const auto step = hn::Set(d, edge_step_px);
  int u{0};
  for (; u < std::min(edge_reach_px, width); ++u) kept[u] = kept_at(row, width, u);
  for (; u + lanes + edge_reach_px <= width; u += lanes) {
    auto most = hn::Zero(d);
    auto least = hn::Set(d, nothing);
    for (int i{-edge_reach_px}; i <= edge_reach_px; ++i) {
      const auto disparity = hn::LoadU(d, row + u + i);
      most = hn::Max(most, disparity);
      least = hn::Min(least, hn::IfThenElse(hn::Gt(disparity, hn::Zero(d)), disparity, hn::Set(d, nothing)));
    }
    const auto here = hn::LoadU(d, row + u);
    const auto between = hn::And(hn::Gt(most, hn::Add(here, step)), hn::Lt(least, hn::Sub(here, step)));
    hn::StoreU(hn::IfThenZeroElse(between, here), d, kept + u);
  }
  for (; u < width; ++u) kept[u] = kept_at(row, width, u);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stereogrid
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(LeaveEdgesOut);

void leave_edges_out(const float* row, int width, float* kept) {
  HWY_DYNAMIC_DISPATCH(LeaveEdgesOut)(row, width, kept);
}

}  // namespace stereogrid
#endif
