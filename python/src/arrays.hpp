// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "stereogrid/frame.hpp"
#include "stereogrid/image.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::python {

namespace nb = nanobind;

/// Read-only NumPy arrays. Their memory is that of an Image, which the array's owner keeps alive.
template <class T>
using Plane = nb::ndarray<nb::numpy, const T, nb::ndim<2>>;
template <class T>
using Planes = nb::ndarray<nb::numpy, const T, nb::ndim<3>>;

template <class T>
Plane<T> view_of(const Image<T>& image, nb::handle owner) {
  return {image.data(), {static_cast<std::size_t>(image.height()), static_cast<std::size_t>(image.width())}, owner};
}

/// None: the image is empty.
template <class T>
std::optional<Plane<T>> view_unless_empty(const Image<T>& image, nb::handle owner) {
  if (image.empty()) return std::nullopt;
  return view_of(image, owner);
}

/// Binds views of an image in the data that `of` finds in the bound object.
template <class Bound, class Data, class T, class Of = std::identity>
void bind_image(nb::class_<Bound>& bound, const char* name, Image<T> Data::*image, const char* text, Of of = {}) {
  bound.def_prop_ro(
      name, [=](nb::handle self) { return view_of(of(nb::cast<const Bound&>(self)).*image, self); }, text);
}

/// As bind_image(); None: the image is empty.
template <class Bound, class Data, class T, class Of = std::identity>
void bind_image_or_none(nb::class_<Bound>& bound, const char* name, Image<T> Data::*image, const char* text,
                        Of of = {}) {
  bound.def_prop_ro(
      name, [=](nb::handle self) { return view_unless_empty(of(nb::cast<const Bound&>(self)).*image, self); }, text);
}

/// Array of a type that NumPy can convert, as given by the caller. Construction and destruction require the GIL; the
/// conversions below do not.
class Array {
 public:
  /// `name`: of the argument, for messages. Throws TypeError: no array.
  Array(nb::handle object, const char* name);
  Array(const Array&) = delete;
  Array& operator=(const Array&) = delete;
  ~Array() = default;

  [[nodiscard]] const Py_buffer& buffer() const { return buffer_; }
  [[nodiscard]] const char* name() const { return name_; }
  /// "uint8" and so on.
  [[nodiscard]] const std::string& dtype() const { return dtype_; }
  [[nodiscard]] std::string shape() const;

 private:
  struct Buffer : Py_buffer {
    ~Buffer() { PyBuffer_Release(this); }
  };

  /// False: the object has no buffer, or its type has no name yet.
  bool takes_buffer(nb::handle object);

  const char* name_;
  std::string dtype_;
  Buffer buffer_{};
};

/// Samples of grey and colour images.
struct PixelOptions {
  std::string color;  ///< "rgb" or "bgr" of three or four channels; "": grey
  int bits{16};       ///< uint16 samples: number of lower bits in use
};

/// Writes grey levels of (height, width) uint8, uint16 or float, or (height, width, 3 or 4) uint8. Throws TypeError,
/// ValueError, InputError.
void assign(Image<std::uint8_t>& grey, const Array& pixels, const PixelOptions& options);

/// Grey levels in place if they are rows of uint8, else written to `copy` as by assign().
[[nodiscard]] View<const std::uint8_t> grey_of(const Array& pixels, const PixelOptions& options,
                                               Image<std::uint8_t>& copy);

/// Writes disparities or depths of (height, width) float, or uint16 divided by `units` (0: uint16 is rejected). Values
/// that are not finite or not positive become 0 = none. Throws TypeError, ValueError.
void assign(Image<float>& measured, const Array& values, double units);

/// Arguments that describe the images of a frame.
struct ImageArguments {
  nb::handle left, right, disparity, depth;  // the caller keeps them alive
  std::optional<double> depth_scale;
  PixelOptions pixels;
};

/// Images of a frame as given by the caller. Construction and destruction require the GIL; the other functions do not.
class ImageArrays {
 public:
  /// Throws TypeError: images are missing, or exclude each other; ValueError: depth_scale.
  explicit ImageArrays(const ImageArguments& arguments);

  /// Grey levels in place where possible; other images are written to `copies`. `rig`: for depths.
  [[nodiscard]] FrameImages view(StereoFrame& copies, const Rig& rig) const;
  /// Writes all images to `frame`.
  void copy_to(StereoFrame& frame, const Rig& rig) const;

 private:
  void assign_external(Image<float>& disparity, const Rig& rig) const;

  PixelOptions pixels_;
  double depth_units_per_m_;
  bool is_depth_;
  Array left_;
  std::optional<Array> right_;
  std::optional<Array> external_;  ///< disparity or depth
};

/// Images of a frame in a GPU's memory, by DLPack or else __cuda_array_interface__. Construction and destruction
/// require the GIL.
class DeviceArrays {
 public:
  /// Whether one of the images is in a GPU's memory.
  [[nodiscard]] static bool has_any(const ImageArguments& arguments);
  /// Throws TypeError, ValueError: only one of them is, or a type or shape that images do not have.
  explicit DeviceArrays(const ImageArguments& arguments);

  [[nodiscard]] const DeviceImages& images() const { return images_; }

 private:
  template <class T>
  View<const T, Device> view_of(nb::handle object, const char* name);

  DeviceImages images_;
  std::vector<nb::ndarray<nb::ro>> owners_;  ///< owners of the images from DLPack
};

}  // namespace stereogrid::python
