// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "stereogrid/export.hpp"
#include "stereogrid/image.hpp"
#include "stereogrid/io/file.hpp"

namespace stereogrid::io {

/// Element types of NumPy arrays, little-endian.
enum class DType { float16, float32, float64, int8, int16, int32, int64, uint8, uint16, uint32, uint64, boolean };

/// "<f4" and so on, as NumPy spells it.
[[nodiscard]] STEREOGRID_EXPORT std::string_view spelling(DType dtype);
/// Bytes of an element.
[[nodiscard]] STEREOGRID_EXPORT std::size_t element_size(DType dtype);

/// Half a float's bits, for small files: three digits (IEEE 754 binary16).
struct STEREOGRID_EXPORT Half {
  Half() = default;
  explicit Half(float value);
  explicit operator float() const;

  std::uint16_t bits{0};
};

template <class T>
[[nodiscard]] constexpr DType dtype_of() {
  if constexpr (std::is_same_v<T, float>) {
    return DType::float32;
  } else if constexpr (std::is_same_v<T, Half>) {
    return DType::float16;
  } else if constexpr (std::is_same_v<T, double>) {
    return DType::float64;
  } else if constexpr (std::is_same_v<T, std::int32_t>) {
    return DType::int32;
  } else if constexpr (std::is_same_v<T, std::int64_t>) {
    return DType::int64;
  } else if constexpr (std::is_same_v<T, std::uint8_t>) {
    return DType::uint8;
  } else {
    static_assert(std::is_same_v<T, std::uint16_t>);
    return DType::uint16;
  }
}

/// View of an array for writing; the caller owns the data. Row-major: the last dimension is the fastest.
struct NpzArray {
  std::string name;
  DType dtype{DType::float32};
  std::vector<std::size_t> shape;
  std::span<const std::byte> bytes;
  std::vector<std::span<const std::byte>> further;  ///< bytes behind `bytes`

  /// `values`, `image` and `layers` have to live until the file is written.
  template <class T>
  NpzArray(std::string array_name, std::vector<std::size_t> array_shape, std::span<const T> values)
      : name{std::move(array_name)},
        dtype{dtype_of<T>()},
        shape{std::move(array_shape)},
        bytes{std::as_bytes(values)} {}
  template <class T>
  NpzArray(std::string array_name, std::vector<std::size_t> array_shape, const std::vector<T>& values)
      : NpzArray{std::move(array_name), std::move(array_shape), std::span<const T>{values}} {}
  /// Shape (height, width).
  template <class T>
  NpzArray(std::string array_name, const Image<T>& image)
      : NpzArray{std::move(array_name),
                 {static_cast<std::size_t>(image.height()), static_cast<std::size_t>(image.width())},
                 std::span<const T>{image.data(), image.size()}} {}
  /// Shape (layers, height, width); at least one layer, all of the same size.
  template <class T>
  NpzArray(std::string array_name, const std::vector<std::reference_wrapper<const Image<T>>>& layers)
      : NpzArray{std::move(array_name), layers.front().get()} {
    shape.insert(shape.begin(), layers.size());
    for (std::size_t i{1}; i < layers.size(); ++i) {
      const Image<T>& layer{layers[i].get()};
      further.push_back(std::as_bytes(std::span<const T>{layer.data(), layer.size()}));
    }
  }
};

/// Writes a compressed .npz that numpy.load opens; the same arrays give the same bytes. Leaves whole files only. Throws
/// DeviceError; std::invalid_argument where a shape does not fit its bytes.
STEREOGRID_EXPORT void write_npz(const std::filesystem::path& path, std::span<const NpzArray> arrays);

/// An array read from a file.
struct STEREOGRID_EXPORT NpyArray {
  DType dtype{DType::float32};
  std::vector<std::size_t> shape;
  std::vector<std::byte> bytes;

  /// Number of elements.
  [[nodiscard]] std::size_t size() const { return bytes.size() / element_size(dtype); }

  /// The elements, converted as by static_cast; floats that an integer cannot hold become its nearest value, NaN 0.
  /// T: float, double, std::int32_t, std::int64_t, std::uint8_t, std::uint16_t.
  template <class T>
  [[nodiscard]] std::vector<T> to() const;

  /// A two-dimensional array (rows, columns) as an image, converted as by to(). Throws InputError for other shapes.
  template <class T>
  [[nodiscard]] Image<T> to_image() const;
};

/// Every array of an .npz by name. Throws InputError: missing or damaged file, an element type or memory order that is
/// not understood, more than `most_bytes` in the file or in all arrays.
[[nodiscard]] STEREOGRID_EXPORT std::map<std::string, NpyArray> read_npz(
    const std::filesystem::path& path, std::size_t most_bytes = largest_bytes::arrays);

/// The array of an .npy file. Throws as read_npz.
[[nodiscard]] STEREOGRID_EXPORT NpyArray read_npy(const std::filesystem::path& path);

}  // namespace stereogrid::io
