// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <cstdint>
#include <exception>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "arrays.hpp"

namespace stereogrid::python {
namespace {

constexpr const char* cuda_interface{"__cuda_array_interface__"};
constexpr const char* uint8{"uint8"};
constexpr const char* float32{"float32"};

bool is_on_device(nb::handle object) {
  if (object.is_none() || PyObject_CheckBuffer(object.ptr()) != 0) return false;
  if (nb::hasattr(object, cuda_interface)) return true;
  if (!nb::hasattr(object, "__dlpack_device__")) return false;
  int kind{0};
  const bool is_known{nb::try_cast(nb::object{object.attr("__dlpack_device__")()[0]}, kind)};
  return is_known && (kind == nb::device::cuda::value || kind == nb::device::cuda_managed::value);
}

/// Array in a GPU's memory; strides in elements.
struct DeviceArray {
  std::uintptr_t data;
  std::string dtype;
  std::vector<std::int64_t> shape{};
  std::vector<std::int64_t> strides{};
  std::uintptr_t stream{0};
};

/// NumPy's name of a type, such as "float64"; of several lanes "uint8x4".
std::string name_of(const nb::dlpack::dtype& type) {
  constexpr std::array names{"int", "uint", "float", "opaque", "bfloat", "complex", "bool"};  // by DLPack's codes
  const std::string lanes{type.lanes == 1 ? "" : fmt::format("x{}", type.lanes)};
  return fmt::format("{}{}{}", type.code < names.size() ? names[type.code] : "unknown", type.bits, lanes);
}

DeviceArray array_of(const nb::ndarray<nb::ro>& tensor) {
  DeviceArray array{reinterpret_cast<std::uintptr_t>(tensor.data()), name_of(tensor.dtype())};
  for (std::size_t axis{0}; axis < tensor.ndim(); ++axis) {
    array.shape.push_back(static_cast<std::int64_t>(tensor.shape(axis)));
    array.strides.push_back(tensor.stride(axis));
  }
  return array;
}

/// Reads the value of `cuda_interface`, versions 2 and 3.
DeviceArray array_of(const nb::dict& fields) {
  DeviceArray array{nb::cast<std::uintptr_t>(nb::object{fields["data"][0]}), nb::cast<std::string>(fields["typestr"])};
  if (array.dtype == "|u1") array.dtype = uint8;
  if (array.dtype == "<f4") array.dtype = float32;
  const auto has = [&fields](const char* key) { return fields.contains(key) && !fields[key].is_none(); };
  if (has("stream")) array.stream = nb::cast<std::uintptr_t>(fields["stream"]);
  if (array.stream == 1) array.stream = 0;  // both are the default stream
  array.shape = nb::cast<std::vector<std::int64_t>>(fields["shape"]);
  if (has("strides")) {
    array.strides = nb::cast<std::vector<std::int64_t>>(fields["strides"]);
    const std::int64_t bytes{array.dtype == float32 ? 4 : 1};
    for (std::int64_t& stride : array.strides) stride = stride % bytes == 0 ? stride / bytes : 0;  // 0: refused
  } else if (array.shape.size() == 2) {
    array.strides = {array.shape[1], 1};
  }
  return array;
}

}  // namespace

bool DeviceArrays::has_any(const ImageArguments& arguments) {
  return is_on_device(arguments.left) || is_on_device(arguments.right) || is_on_device(arguments.disparity) ||
         is_on_device(arguments.depth);
}

DeviceArrays::DeviceArrays(const ImageArguments& arguments) {
  if (!arguments.depth.is_none() || !arguments.pixels.color.empty()) {
    throw nb::type_error("images in a GPU's memory: depth or color (allowed: grey left and right, disparity).");
  }
  images_.left = view_of<std::uint8_t>(arguments.left, "left");
  if (!arguments.right.is_none()) images_.right = view_of<std::uint8_t>(arguments.right, "right");
  if (!arguments.disparity.is_none()) images_.disparity = view_of<float>(arguments.disparity, "disparity");
}

template <class T>
View<const T, Device> DeviceArrays::view_of(nb::handle object, const char* name) {
  if (!is_on_device(object)) {
    throw nb::type_error(
        fmt::format("{}: in the host's memory (expected: in the GPU's, as the others).", name).c_str());
  }
  DeviceArray array{};
  nb::ndarray<nb::ro> tensor;
  if (nb::hasattr(object, "__dlpack__") && nb::try_cast(object, tensor)) {
    array = array_of(tensor);
    owners_.push_back(std::move(tensor));
  } else {
    try {
      array = array_of(nb::cast<nb::dict>(object.attr(cuda_interface)));
    } catch (const std::exception&) {  // errors of Python and of casts
      throw nb::type_error(fmt::format("{}: neither DLPack nor a valid {} of version 2 or 3 (expected: data, typestr "
                                       "and shape).",
                                       name, cuda_interface)
                               .c_str());
    }
  }
  const std::string expected{std::is_same_v<T, float> ? float32 : uint8};
  if (array.dtype != expected) {
    throw nb::type_error(
        fmt::format("{}: dtype {} in a GPU's memory (expected {}).", name, array.dtype, expected).c_str());
  }
  const auto is_size = [](std::int64_t size) { return size >= 0 && size <= std::numeric_limits<int>::max(); };
  if (array.shape.size() != 2 || array.strides.size() != 2 || array.strides[1] != 1 || array.strides[0] == 0 ||
      !is_size(array.shape[0]) || !is_size(array.shape[1])) {
    throw nb::value_error(
        fmt::format("{}: not (height, width) with the pixels of a row side by side, in a GPU's memory. "
                    "Make it contiguous.",
                    name)
            .c_str());
  }
  if (images_.left.data == nullptr) images_.stream = array.stream;
  if (array.stream != images_.stream) {
    throw nb::value_error(fmt::format("{}: on another stream than left (expected: one stream).", name).c_str());
  }
  return {reinterpret_cast<const T*>(array.data), static_cast<int>(array.shape[1]), static_cast<int>(array.shape[0]),
          array.strides[0]};
}

}  // namespace stereogrid::python
