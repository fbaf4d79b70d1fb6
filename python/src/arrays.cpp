// SPDX-License-Identifier: Apache-2.0
#include "arrays.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include "stereogrid/io/image_file.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/pixel_view.hpp"

namespace stereogrid::python {
namespace {

template <class T>
T sample(const std::byte* at) {
  T value;
  std::memcpy(&value, at, sizeof value);  // arrays need not be aligned
  return value;
}

const std::byte* at(const Py_buffer& buffer, Py_ssize_t v, Py_ssize_t u) {
  return static_cast<const std::byte*>(buffer.buf) + v * buffer.strides[0] + u * buffer.strides[1];
}

int length(const Array& array, int axis) {
  const Py_ssize_t length{array.buffer().shape[axis]};
  if (length > 0 && length <= std::numeric_limits<int>::max()) return static_cast<int>(length);
  throw nb::value_error((std::string{array.name()} + ": shape " + array.shape() + " has no pixels.").c_str());
}

[[noreturn]] void report_type(const Array& array, const std::string& expected) {
  throw nb::type_error(
      (std::string{array.name()} + ": dtype " + array.dtype() + " (expected " + expected + ").").c_str());
}

[[noreturn]] void report_shape(const Array& array, const std::string& expected) {
  throw nb::value_error(
      (std::string{array.name()} + ": shape " + array.shape() + " (expected " + expected + ").").c_str());
}

/// Copies pixels of any strides into rows without gaps.
std::vector<std::byte> pack(const Array& array, std::size_t channels) {
  const Py_buffer& buffer{array.buffer()};
  const auto item{static_cast<std::size_t>(buffer.itemsize)};
  std::vector<std::byte> packed(static_cast<std::size_t>(buffer.shape[0] * buffer.shape[1]) * item * channels);
  std::byte* to{packed.data()};
  for (Py_ssize_t v{0}; v < buffer.shape[0]; ++v) {
    for (Py_ssize_t u{0}; u < buffer.shape[1]; ++u) {
      for (std::size_t c{0}; c < channels; ++c, to += item) {
        const Py_ssize_t step{channels > 1 ? buffer.strides[2] * static_cast<Py_ssize_t>(c) : 0};
        std::memcpy(to, at(buffer, v, u) + step, item);
      }
    }
  }
  return packed;
}

bool has_whole_rows(const Py_buffer& buffer, Py_ssize_t channels) {
  const Py_ssize_t pixel{buffer.itemsize * channels};
  if (channels > 1 && buffer.strides[2] != buffer.itemsize) return false;
  return buffer.strides[1] == pixel && std::abs(buffer.strides[0]) >= pixel * buffer.shape[1];
}

PixelFormat format_of(const Array& pixels, const PixelOptions& options) {
  const Py_buffer& buffer{pixels.buffer()};
  const std::string& dtype{pixels.dtype()};
  if (buffer.ndim == 2) {
    if (!options.color.empty()) report_shape(pixels, "(height, width, 3 or 4) with color");
    if (dtype == "uint8") return PixelFormat::grey8;
    if (dtype == "uint16") return PixelFormat::grey16;
    report_type(pixels, "uint8, uint16, float32 or float64");
  }
  const bool has_color{buffer.ndim == 3 && (buffer.shape[2] == 3 || buffer.shape[2] == 4)};
  if (!has_color) report_shape(pixels, "(height, width), or (height, width, 3 or 4) with color");
  if (dtype != "uint8") report_type(pixels, "uint8 for three or four channels");
  const bool has_alpha{buffer.shape[2] == 4};
  if (options.color == "rgb") return has_alpha ? PixelFormat::rgba8 : PixelFormat::rgb8;
  if (options.color == "bgr") return has_alpha ? PixelFormat::bgra8 : PixelFormat::bgr8;
  throw nb::value_error((std::string{pixels.name()} + ": color '" + options.color +
                         "' of an image with channels (allowed: 'rgb', 'bgr').")
                            .c_str());
}

/// Warns of 16-bit samples whose upper bits no pixel uses, as of a sensor of 12 bits.
void warn_of_unused_bits(const Image<std::uint8_t>& grey, const Array& pixels, int bits) {
  constexpr int unused{4};
  const unsigned brightest{*std::max_element(grey.begin(), grey.end())};
  const int used{bits - 8 + static_cast<int>(std::bit_width(brightest))};
  if (brightest == 0 || used > bits - unused) return;
  const std::string text{std::string{pixels.name()} + ": the brightest sample uses " + std::to_string(used) + " of " +
                         std::to_string(bits) + " bits. Give bits=" + std::to_string(used) +
                         " if the sensor has no more."};
  const nb::gil_scoped_acquire acquired;
  if (PyErr_WarnEx(PyExc_RuntimeWarning, text.c_str(), 1) != 0) throw nb::python_error();
}

void assign_pixels(Image<std::uint8_t>& grey, const Array& pixels, const PixelOptions& options) {
  const PixelFormat format{format_of(pixels, options)};
  const Py_buffer& buffer{pixels.buffer()};
  const Py_ssize_t channels{buffer.ndim == 3 ? buffer.shape[2] : 1};
  PixelView view{buffer.buf, length(pixels, 1), length(pixels, 0), buffer.strides[0], format, options.bits};
  std::vector<std::byte> packed;
  if (!has_whole_rows(buffer, channels)) {
    packed = pack(pixels, static_cast<std::size_t>(channels));
    view.data = packed.data();
    view.stride_bytes = 0;
  }
  stereogrid::assign(grey, view);
  if (format == PixelFormat::grey16) warn_of_unused_bits(grey, pixels, options.bits);
}

template <class T, class To, class Convert>
void transform(const Array& from, Image<To>& to, const Convert& convert) {
  const int width{length(from, 1)};
  const int height{length(from, 0)};
  if (to.width() != width || to.height() != height) to = Image<To>{width, height};
  for (int v{0}; v < height; ++v) {
    To* const row{to.row(v)};
    for (int u{0}; u < width; ++u) row[u] = convert(sample<T>(at(from.buffer(), v, u)));
  }
}

/// Grey levels from 0 to 255 of floats, rounded.
template <class T>
void assign_floats(Image<std::uint8_t>& grey, const Array& pixels) {
  constexpr T white{255};
  T largest{0};
  transform<T>(pixels, grey, [&](T value) {
    if (!(value >= 0 && value <= white)) {
      throw nb::value_error(
          (std::string{pixels.name()} + ": grey level " + std::to_string(value) + " (allowed 0 to 255).").c_str());
    }
    largest = std::max(largest, value);
    return static_cast<std::uint8_t>(std::lround(value));
  });
  if (largest > 0 && largest <= 1) {
    throw nb::value_error((std::string{pixels.name()} + ": the largest grey level is " + std::to_string(largest) +
                           " (expected 0 to 255). Multiply by 255.")
                              .c_str());
  }
}

template <class T>
float measured_value(T value, double units) {
  return static_cast<float>(units > 0 ? static_cast<double>(value) / units : static_cast<double>(value));
}

/// NumPy's name of a sample's type, without NumPy: its own name costs more than the copy of a small image. "": a type
/// that images do not have.
std::string_view dtype_of(const char* buffer_format) {
  const std::string_view format{buffer_format != nullptr ? buffer_format : ""};
  return format == "B"   ? "uint8"
         : format == "H" ? "uint16"
         : format == "f" ? "float32"
         : format == "d" ? "float64"
                         : "";
}

}  // namespace

Array::Array(nb::handle object, const char* name) : name_{name} {
  if (takes_buffer(object)) return;
  nb::object array;
  std::string dtype;
  try {
    array = nb::module_::import_("numpy").attr("asarray")(object);
    const nb::object type{array.attr("dtype")};
    dtype = nb::str(type).c_str();
  } catch (nb::python_error& error) {
    if (!error.matches(PyExc_TypeError) && !error.matches(PyExc_ValueError)) throw;
  }
  if (dtype.empty() || !(takes_buffer(array) || buffer_.obj != nullptr)) {
    throw nb::type_error(
        (std::string{name} + ": no array of numbers" + (dtype.empty() ? "" : ", dtype " + dtype) + ".").c_str());
  }
  dtype_ = std::move(dtype);
}

bool Array::takes_buffer(nb::handle object) {
  PyBuffer_Release(&buffer_);
  if (PyObject_GetBuffer(object.ptr(), &buffer_, PyBUF_STRIDED_RO | PyBUF_FORMAT) != 0) {
    PyErr_Clear();
    return false;
  }
  dtype_ = dtype_of(buffer_.format);
  return !dtype_.empty();
}

std::string Array::shape() const {
  std::string text{"("};
  for (int axis{0}; axis < buffer_.ndim; ++axis) text += (axis > 0 ? ", " : "") + std::to_string(buffer_.shape[axis]);
  return text + (buffer_.ndim == 1 ? ",)" : ")");
}

void assign(Image<std::uint8_t>& grey, const Array& pixels, const PixelOptions& options) {
  if (pixels.buffer().ndim == 2 && pixels.dtype() == "float32") return assign_floats<float>(grey, pixels);
  if (pixels.buffer().ndim == 2 && pixels.dtype() == "float64") return assign_floats<double>(grey, pixels);
  assign_pixels(grey, pixels, options);
}

View<const std::uint8_t> grey_of(const Array& pixels, const PixelOptions& options, Image<std::uint8_t>& copy) {
  const Py_buffer& buffer{pixels.buffer()};
  const bool is_grey{buffer.ndim == 2 && pixels.dtype() == "uint8" && options.color.empty()};
  if (is_grey && buffer.strides[1] == 1 && buffer.strides[0] >= buffer.shape[1]) {
    return {static_cast<const std::uint8_t*>(buffer.buf), length(pixels, 1), length(pixels, 0), buffer.strides[0]};
  }
  assign(copy, pixels, options);
  return copy.view();
}

void assign(Image<float>& measured, const Array& values, double units) {
  if (values.buffer().ndim != 2) report_shape(values, "(height, width)");
  if (values.dtype() == "float32") {
    transform<float>(values, measured, [](float value) { return measured_value(value, 0); });
  } else if (values.dtype() == "float64") {
    transform<double>(values, measured, [](double value) { return measured_value(value, 0); });
  } else if (values.dtype() == "uint16" && units > 0) {
    transform<std::uint16_t>(values, measured, [units](std::uint16_t value) { return measured_value(value, units); });
  } else {
    report_type(values, units > 0 ? "float32 or float64 in m, or uint16"
                                  : "float32 or float64 in px; divide fixed-point disparities by their scale");
  }
}

ImageArrays::ImageArrays(const ImageArguments& arguments)
    : pixels_{arguments.pixels},
      depth_units_per_m_{arguments.depth_scale.value_or(1000)},
      is_depth_{!arguments.depth.is_none()},
      left_{arguments.left, "left"} {
  const bool is_disparity{!arguments.disparity.is_none()};
  if ((is_disparity && is_depth_) || (!is_disparity && !is_depth_ && arguments.right.is_none())) {
    throw nb::type_error("images: give right, disparity or depth beside left; disparity and depth exclude each other.");
  }
  if (!(depth_units_per_m_ > 0)) {
    throw nb::value_error(fmt::format("depth_scale: {} (allowed above 0).", depth_units_per_m_).c_str());
  }
  if (!arguments.right.is_none()) right_.emplace(arguments.right, "right");
  if (is_disparity) external_.emplace(arguments.disparity, "disparity");
  if (is_depth_) external_.emplace(arguments.depth, "depth");
}

void ImageArrays::assign_external(Image<float>& disparity, const Rig& rig) const {
  if (!is_depth_) {
    assign(disparity, *external_, 0);
    return io::settle_disparities(external_->name(), disparity);
  }
  Image<float> depth_m;
  assign(depth_m, *external_, depth_units_per_m_);
  disparity = io::disparity_from_depth(depth_m, rig);
}

FrameImages ImageArrays::view(StereoFrame& copies, const Rig& rig) const {
  FrameImages images;
  images.left = grey_of(left_, pixels_, copies.left);
  if (right_) images.right = grey_of(*right_, pixels_, copies.right);
  if (!external_) return images;
  assign_external(copies.disparity, rig);
  images.disparity = copies.disparity.view();
  return images;
}

void ImageArrays::copy_to(StereoFrame& frame, const Rig& rig) const {
  assign(frame.left, left_, pixels_);
  if (right_) assign(frame.right, *right_, pixels_);
  if (external_) assign_external(frame.disparity, rig);
}

}  // namespace stereogrid::python
