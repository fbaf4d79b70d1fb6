// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

#include "stereogrid/camera.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

// State of a pipeline between two frames, as bytes. A class names its state once, for saving and loading alike:
//
//   template <class State> void exchange(State& state) { state(ground_, points_, …); }
//
// Members are numbers and structs of numbers without padding, images (whose size must not change), vectors and
// optionals of these, and classes with an `exchange` of their own.

template <class T, class State>
concept Exchanges = requires(T value, State state) {
  value.exchange(state);
};

/// A camera's road; the struct has padding.
template <class State>
void exchange_members(Ground& ground, State& state) {
  state(ground.height_m, ground.pitch_rad, ground.roll_rad, ground.estimated, ground.height_sigma_m,
        ground.pitch_sigma_rad, ground.roll_sigma_rad, ground.height_pitch_correlation, ground.height_roll_correlation,
        ground.pitch_roll_correlation);
}

/// True if every byte has a value: padding would differ between equal states. nvcc does not support the test.
#ifdef __CUDACC__
template <class T>
concept HasNoPadding = true;
#else
template <class T>
constexpr int sum_of_bytes() {
  int sum{0};
  for (const std::byte byte : std::bit_cast<std::array<std::byte, sizeof(T)> >(T{})) sum += static_cast<int>(byte);
  return sum;
}
template <class T>
concept HasNoPadding = std::is_arithmetic_v<T> || std::is_enum_v<T> || requires {
  typename std::integral_constant<int, sum_of_bytes<T>()>;
};
#endif

/// Puts members behind each other.
class StateWriter {
 public:
  template <class... Values>
  void operator()(Values&... values) {
    (put(values), ...);
  }

  [[nodiscard]] const std::vector<std::byte>& bytes() const { return bytes_; }

 private:
  template <class T>
  void put(T& value) {
    if constexpr (Exchanges<T, StateWriter>) {
      value.exchange(*this);
    } else {
      static_assert(std::is_trivially_copyable_v<T>);
      put_elements(&value, 1);
    }
  }

  void put(Ground& ground) { exchange_members(ground, *this); }

  template <class T>
  void put(Image<T>& image) {
    const std::array<int, 2> size{image.width(), image.height()};
    put_elements(size.data(), size.size());
    put_elements(image.data(), image.size());
  }

  template <class T>
  void put(std::vector<T>& values) {
    const std::size_t size{values.size()};
    put_elements(&size, 1);
    if constexpr (std::is_trivially_copyable_v<T> && !Exchanges<T, StateWriter>) {
      put_elements(values.data(), size);
    } else {
      for (T& value : values) put(value);
    }
  }

  template <class T>
  void put(std::optional<T>& value) {
    const bool has_value{value.has_value()};
    put_elements(&has_value, 1);
    if (has_value) put(*value);
  }

  template <class T>
  void put_elements(const T* elements, std::size_t count) {
    static_assert(HasNoPadding<T>);
    if (count == 0) return;
    const std::size_t at{bytes_.size()};
    bytes_.resize(at + count * sizeof(T));
    std::memcpy(bytes_.data() + at, elements, count * sizeof(T));
  }

  std::vector<std::byte> bytes_;
};

/// Reads the state. `fits()` reports whether it matches; nothing is read beyond the end.
class StateReader {
 public:
  explicit StateReader(std::span<const std::byte> bytes) : rest_{bytes} {}

  template <class... Values>
  void operator()(Values&... values) {
    (take(values), ...);
  }

  /// For classes that find a value they cannot work with.
  void require(bool condition) { fits_ = fits_ && condition; }
  /// All members were there, of the right size, and nothing is left.
  [[nodiscard]] bool fits() const { return fits_ && rest_.empty(); }

 private:
  template <class T>
  void take(T& value) {
    if constexpr (Exchanges<T, StateReader>) {
      value.exchange(*this);
    } else {
      static_assert(std::is_trivially_copyable_v<T>);
      take_elements(&value, 1);
    }
  }

  void take(Ground& ground) { exchange_members(ground, *this); }

  template <class T>
  void take(Image<T>& image) {
    std::array<int, 2> size{};
    take_elements(size.data(), size.size());
    require(size[0] == image.width() && size[1] == image.height());
    take_elements(image.data(), image.size());
  }

  template <class T>
  void take(std::vector<T>& values) {
    std::size_t size{0};
    take_elements(&size, 1);
    require(size <= rest_.size());  // no element is smaller than a byte
    if (!fits_) return;
    values.resize(size);
    if constexpr (std::is_trivially_copyable_v<T> && !Exchanges<T, StateReader>) {
      take_elements(values.data(), size);
    } else {
      for (T& value : values) take(value);
    }
  }

  template <class T>
  void take(std::optional<T>& value) {
    bool has_value{false};
    take_elements(&has_value, 1);
    value.reset();
    if (!has_value) return;
    T read{};
    take(read);
    value = read;
  }

  template <class T>
  void take_elements(T* elements, std::size_t count) {
    require(count * sizeof(T) <= rest_.size());
    if (!fits_ || count == 0) return;
    std::memcpy(elements, rest_.data(), count * sizeof(T));
    rest_ = rest_.subspan(count * sizeof(T));
  }

  std::span<const std::byte> rest_;
  bool fits_{true};
};

/// FNV-1a over words of eight bytes: detects damage, not forgery.
std::uint64_t checksum_of(std::span<const std::byte> bytes);

/// State with a head: type, size and checksums. `settings`: checksum of all settings that must be equal when it is
/// loaded.
std::vector<std::byte> sealed(std::span<const std::byte> state, std::uint64_t settings);
/// The state behind the head. Throws InputError: there is none, or it is damaged or of other settings.
std::span<const std::byte> unsealed(std::span<const std::byte> saved, std::uint64_t settings);

}  // namespace stereogrid
