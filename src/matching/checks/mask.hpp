// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "geometry/matches.hpp"
#include "memory_bytes.hpp"
#include "stereogrid/image.hpp"
#include "stereogrid/level_mapping.hpp"

namespace stereogrid {

/// Pixels of the level image that show the vehicle itself. They have no disparity.
class PixelMask {
 public:
  /// None.
  PixelMask() = default;
  /// `camera`: see PipelineOptions::mask; it may be empty. A pixel of the level image that is made of several pixels of
  /// the camera's is masked where one of them is; what the camera does not see as the camera's nearest pixel, since
  /// matching windows reach beyond the image.
  PixelMask(const Image<std::uint8_t>& camera, const LevelMapping& mapping);

  [[nodiscard]] bool empty() const { return masked_.empty(); }
  /// 1: shows the vehicle. Empty where no pixel does.
  [[nodiscard]] View<const std::uint8_t> view() const { return masked_.view(); }
  /// Rows that hold such pixels lie in [first_row(), end_row()).
  [[nodiscard]] int first_row() const { return first_row_; }
  [[nodiscard]] int end_row() const { return end_row_; }
  /// Takes the disparities away, in the rows first_row() + begin … first_row() + end − 1.
  void clear(int begin, int end, Matches& matches) const;

  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_of(masked_); }

 private:
  Image<std::uint8_t> masked_;
  int first_row_{0};
  int end_row_{0};
};

}  // namespace stereogrid
