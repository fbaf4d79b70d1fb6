// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "matching/semi_global.hpp"

namespace stereogrid {

/// What the passes of semi-global matching share.
struct SemiGlobalTask {
  CensusTriple census;
  RoadPlane plane;
  Penalties penalties;
  Shifts upright;
  Shifts road;
  int uniqueness_1024{0};
  std::uint16_t* sums{nullptr};  ///< [v][u][label], semi_global_labels() a pixel, 64-byte aligned
  CandidateSink* sink{nullptr};
};

/// Labels of a pixel with their padding.
std::size_t semi_global_labels(const SemiGlobalTask& task);
/// Bytes of working memory of one call of a pass over a part of the image.
std::size_t semi_global_memory(const SemiGlobalTask& task);

/// The passes, in this order; each may be cut into parts. Rows: paths from the left and from the right, overwriting the
/// sums. Columns: paths from the top and from the bottom, adding. Choose: the candidates of rows.
void semi_global_rows(const SemiGlobalTask& task, int begin, int end, std::uint8_t* memory);
void semi_global_columns(const SemiGlobalTask& task, int begin, int end, std::uint8_t* memory);
void semi_global_choose(const SemiGlobalTask& task, int begin, int end, std::uint8_t* memory,
                        RowCandidates& candidates);

}  // namespace stereogrid
