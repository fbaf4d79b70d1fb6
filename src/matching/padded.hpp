// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "memory_bytes.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

/// An image whose rows may be read `border` elements beyond both ends, so that windows and vectors need no special case
/// there.
template <class T>
class Padded {
 public:
  Padded() = default;
  Padded(int width, int height, int border)
      : width_{width},
        height_{height},
        border_{border},
        elements_(static_cast<std::size_t>(width + 2 * border) * static_cast<std::size_t>(height)) {}

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] T* row(int v) { return elements_.data() + start(v); }
  [[nodiscard]] const T* row(int v) const { return elements_.data() + start(v); }
  /// Rows above and below the image repeat its first and last one.
  [[nodiscard]] const T* clamped_row(int v) const { return row(std::clamp(v, 0, height_ - 1)); }
  [[nodiscard]] View<T> view() { return {row(0), width_, height_, width_ + 2 * border_}; }
  [[nodiscard]] View<const T> view() const { return {row(0), width_, height_, width_ + 2 * border_}; }

  void copy_row(int v, const T* source) {
    std::copy(source, source + width_, row(v));
    repeat_border(v);
  }

  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_of(elements_); }

  /// To be called when a row has been written.
  void repeat_border(int v) {
    T* first{row(v)};
    std::fill(first - border_, first, first[0]);
    std::fill(first + width_, first + width_ + border_, first[width_ - 1]);
  }

 private:
  [[nodiscard]] std::ptrdiff_t start(int v) const {
    return static_cast<std::ptrdiff_t>(v) * (width_ + 2 * border_) + border_;
  }

  int width_{0};
  int height_{0};
  int border_{0};
  std::vector<T> elements_;
};

}  // namespace stereogrid
