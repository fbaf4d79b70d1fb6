// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "matching/semi_global/semi_global.hpp"

namespace stereogrid {

/// Memory layout of a pixel's costs, a byte each: the upright labels, padded, then a tail with the road's labels
/// between guards. Both run from the largest shift down, so that their right pixels are in natural order. Padding and
/// guards cost cost_max; labels beside a border are then expensive.
struct LabelLayout {
  explicit LabelLayout(Shifts upright);

  static constexpr int block{64};  ///< every target's vectors divide it
  static constexpr int guard{16};  ///< on both sides of the road's labels

  int uprights;    ///< with padding
  int upright_at;  ///< place of the largest upright shift
  int road_at;     ///< place of the largest road shift
  int stride;      ///< bytes of a pixel
};

/// The best labels of one type, per pixel of a row. There is room for a vector behind the row.
struct RowChoice {
  std::uint16_t* key;  ///< cost · 256 + label
  std::uint8_t* runner_up;
  std::uint8_t* before;  ///< cost one label before the best
  std::uint8_t* after;   ///< … and behind it
};

/// Working memory of one row.
struct SemiGlobalRoom {
  static constexpr int planes{4};  ///< bytes of a descriptor

  std::uint8_t* right[planes];    ///< k-th bytes of the right descriptors; pixel u's labels begin at u
  std::uint8_t* sheared[planes];  ///< likewise for the tail
  std::uint8_t* closed;           ///< cost_max at padding and guards, otherwise 0
  std::uint8_t* carry;            ///< path costs of the row's last pixel so far
  std::uint8_t* costs;            ///< [u][label]
  std::uint8_t* sums;             ///< [u][label]
  std::int32_t* meeting;  ///< per pixel: place of the upright label that meets the road's largest shift, or −1
  RowChoice upright;
  RowChoice road;
  RowCandidates* candidates;  ///< one per thread: rows are completed one after another
};

/// Data shared by all rows. Rows are processed upwards; paths from the row below pass their costs here, less the
/// smallest one.
struct SemiGlobalTask {
  CensusTriple census;
  RoadPlane plane;
  Shifts upright;
  Shifts road;
  LabelLayout layout;
  int uniqueness_1024{0};
  std::uint8_t* vertical{nullptr};  ///< [u][label]
  CandidateSink* sink{nullptr};
};

/// The steps for row v, in this order. They need vectors of 16 bytes, see correlate_target. The second one for
/// consecutive parts of the columns, each after the row below has passed it and one column more.
void semi_global_start_row(const SemiGlobalTask& task, const SemiGlobalRoom& room, int v);
/// Paths from the row below and from the left.
void semi_global_forward(const SemiGlobalTask& task, const SemiGlobalRoom& room, int v, int begin, int end);
/// Paths from the right, and the row's candidates.
void semi_global_backward(const SemiGlobalTask& task, const SemiGlobalRoom& room, int v);

}  // namespace stereogrid
