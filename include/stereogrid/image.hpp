// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <vector>

#include "stereogrid/export.hpp"

namespace stereogrid {

/// Location of the memory of a View.
struct Host {};
struct Device {};

/// Rows of pixels or cells in foreign memory. `pitch` is the distance between rows in elements (≥ width). Images are
/// addressed (u, v), grids (ix, iy): the fast axis first.
template <class T, class Space = Host>
struct View {
  T* data{nullptr};
  int width{0};
  int height{0};
  std::ptrdiff_t pitch{0};

  // constexpr: also callable where the memory lies
  [[nodiscard]] constexpr T* row(int v) const { return data + v * pitch; }
  [[nodiscard]] constexpr T& operator()(int u, int v) const { return data[v * pitch + u]; }
  [[nodiscard]] constexpr bool empty() const { return width == 0 || height == 0; }

  // NOLINTNEXTLINE(google-explicit-constructor): a writable view is a readable one
  template <class Readable>
  requires(!std::is_const_v<T> && std::is_same_v<Readable, const T>) constexpr operator View<Readable, Space>() const {
    return {data, width, height, pitch};
  }
};

/// Owned image or grid: `height` rows of `width` elements, contiguous, row-major. Empty (0 × 0) after a move.
template <class T>
class Image {
 public:
  Image() = default;
  /// Throws std::invalid_argument: a size below 0; std::bad_alloc or std::length_error: too large for the memory.
  Image(int width, int height, T value = T{})
      : width_{width}, height_{height}, elements_(size_of(width, height), value) {}
  Image(const Image&) = default;
  Image& operator=(const Image&) = default;
  Image(Image&& other) noexcept
      : width_{std::exchange(other.width_, 0)},
        height_{std::exchange(other.height_, 0)},
        elements_{std::exchange(other.elements_, {})} {}
  Image& operator=(Image&& other) noexcept {
    width_ = std::exchange(other.width_, 0);
    height_ = std::exchange(other.height_, 0);
    elements_ = std::exchange(other.elements_, {});
    return *this;
  }
  ~Image() = default;

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] bool empty() const { return elements_.empty(); }
  [[nodiscard]] std::size_t size() const { return elements_.size(); }
  [[nodiscard]] T* data() { return elements_.data(); }
  [[nodiscard]] const T* data() const { return elements_.data(); }
  [[nodiscard]] T* row(int v) { return data() + index(0, v); }
  [[nodiscard]] const T* row(int v) const { return data() + index(0, v); }
  [[nodiscard]] T& operator()(int u, int v) { return elements_[index(u, v)]; }
  [[nodiscard]] const T& operator()(int u, int v) const { return elements_[index(u, v)]; }
  [[nodiscard]] auto begin() { return elements_.begin(); }
  [[nodiscard]] auto end() { return elements_.end(); }
  [[nodiscard]] auto begin() const { return elements_.begin(); }
  [[nodiscard]] auto end() const { return elements_.end(); }
  void fill(T value) { std::fill(elements_.begin(), elements_.end(), value); }

  [[nodiscard]] View<T> view() { return {data(), width_, height_, width_}; }
  [[nodiscard]] View<const T> view() const { return {data(), width_, height_, width_}; }

  friend bool operator==(const Image&, const Image&) = default;

 private:
  static std::size_t size_of(int width, int height) {
    if (width < 0 || height < 0) throw std::invalid_argument{"An image cannot have a width or height below 0."};
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
  [[nodiscard]] std::size_t index(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(u);
  }

  int width_{0};
  int height_{0};
  std::vector<T> elements_;
};

}  // namespace stereogrid
