// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/image_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <opencv2/core.hpp>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "files/formats.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/npz.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

const char* const kinds{
    "Disparities are PNG of 16 bits (disparity × 256), PFM, TIFF of floats or NumPy .npy or .npz of floats."};
const char* const depth_kinds{
    "Depth is PNG or TIFF of 16 bits, PFM, TIFF of floats or NumPy .npy or .npz of floats in metres."};
const char* const again{"Copy or write it again."};

// Divides in double, as depth of bags and of Python's arrays is divided: results are equal to the bit.
Image<float> floats_of(const cv::Mat& mat, double units) {
  cv::Mat numbers;
  mat.convertTo(numbers, CV_64F);
  Image<float> image{numbers.cols, numbers.rows};
  for (int v{0}; v < numbers.rows; ++v) {
    std::transform(numbers.ptr<double>(v), numbers.ptr<double>(v) + numbers.cols, image.row(v),
                   [units](double number) { return static_cast<float>(number / units); });
  }
  return image;
}

/// Meaning of a file's numbers.
struct Coding {
  double units;  ///< whole numbers in a pixel, or a metre
  bool is_depth;
  const char* kinds;
};

Image<float> read_png(const std::string& file, const std::string& bytes, const Coding& coding) {
  const cv::Mat image{decode_image(file, bytes)};
  if (image.type() != CV_16UC1) throw InputError{file, "is not a PNG of one channel with 16 bits.", coding.kinds};
  return floats_of(image, coding.units);
}

Image<float> read_tiff(const std::string& file, const std::string& bytes, const Coding& coding) {
  const cv::Mat image{decode_image(file, bytes)};
  if (coding.is_depth && image.type() == CV_16UC1) return floats_of(image, coding.units);
  if (image.type() != CV_32FC1 && image.type() != CV_64FC1) {
    throw InputError{file, "is not a TIFF of one channel of floats.", coding.kinds};
  }
  return floats_of(image, 1);
}

// PFM without OpenCV, which uses a temporary file and prints to stderr: "Pf", width, height, a scale whose sign is the
// byte order, one white-space character, rows from the bottom up.
Image<float> read_pfm(const std::string& file, const std::string& bytes) {
  std::istringstream head{bytes.substr(0, 100)};
  std::string kind;
  int width{0};
  int height{0};
  double scale{0};
  char separator{};
  if (!(head >> kind >> width >> height >> scale) || !head.get(separator) || width <= 0 || height <= 0 ||
      width > largest_side_px || height > largest_side_px || scale == 0) {
    throw InputError{file, "has a damaged PFM header.", again};
  }
  if (kind != "Pf") throw InputError{file, "is a PFM in colour.", kinds};
  const auto start{static_cast<std::size_t>(head.tellg())};
  const std::size_t pixels{static_cast<std::size_t>(width) * static_cast<std::size_t>(height)};
  if ((bytes.size() - start) / sizeof(float) < pixels) {
    throw InputError{file, "is a truncated PFM (pixels are missing).", again};
  }
  Image<float> image{width, height};
  const bool swap{(scale < 0) != (std::endian::native == std::endian::little)};
  std::vector<char> row(static_cast<std::size_t>(width) * sizeof(float));
  for (int v{0}; v < height; ++v) {
    std::memcpy(row.data(), bytes.data() + start + static_cast<std::size_t>(v) * row.size(), row.size());
    if (swap) {
      for (std::size_t i{0}; i < row.size(); i += sizeof(float)) {
        std::reverse(row.data() + i, row.data() + i + sizeof(float));
      }
    }
    std::memcpy(image.row(height - 1 - v), row.data(), row.size());
  }
  return image;
}

/// Without dimensions of length 1, which networks add: (1, height, width), (height, width, 1).
NpyArray squeezed(NpyArray array) {
  if (array.shape.size() > 2) std::erase(array.shape, 1U);
  return array;
}

/// The array of an .npy, or the only one of two dimensions in an .npz.
NpyArray array_of(const std::filesystem::path& path, bool is_archive) {
  if (!is_archive) return squeezed(read_npy(path));
  std::vector<NpyArray> found;
  for (auto& [name, whole] : read_npz(path)) {
    NpyArray array{squeezed(std::move(whole))};
    if (array.shape.size() == 2 && array.size() > 1) found.push_back(std::move(array));
  }
  if (found.size() != 1) {
    throw InputError{printable_path(path), fmt::format("has {} arrays of two dimensions (allowed: 1).", found.size()),
                     "Save the disparities or depths alone."};
  }
  return std::move(found.front());
}

Image<float> read_numpy(const std::filesystem::path& path, bool is_archive, const Coding& coding) {
  const NpyArray array{array_of(path, is_archive)};
  const bool is_real{array.dtype == DType::float16 || array.dtype == DType::float32 || array.dtype == DType::float64};
  if (array.shape.size() != 2 || array.dtype == DType::boolean || (!is_real && !coding.is_depth)) {
    throw InputError{
        printable_path(path),
        fmt::format("is an array of type {} with {} dimensions.", spelling(array.dtype), array.shape.size()),
        coding.is_depth ? "Depth is an array of floats (m) or integers in shape (height, width)."
                        : "Disparities are floats in px in shape (height, width). OpenCV's integers are 16 times the "
                          "disparity: divide them by 16."};
  }
  Image<float> image{array.to_image<float>()};
  if (!is_real) {
    for (float& value : image) value /= static_cast<float>(coding.units);
  }
  return image;
}

Image<float> read_any(const std::filesystem::path& path, const Coding& coding) {
  const std::string file{printable_path(path)};
  const std::string bytes{read_file(path, largest_bytes::image)};
  const std::string_view view{bytes};
  if (view.starts_with("\x93NUMPY")) return read_numpy(path, false, coding);
  if (view.starts_with("PK\x03\x04")) return read_numpy(path, true, coding);
  if (view.starts_with("Pf") || view.starts_with("PF")) return read_pfm(file, bytes);
  if (view.starts_with("II") || view.starts_with("MM")) return read_tiff(file, bytes, coding);
  if (view.starts_with("\x89PN")) return read_png(file, bytes, coding);
  throw InputError{file, bytes.empty() ? "is empty." : "is not a disparity or depth image of a kind that can be read.",
                   coding.kinds};
}

void leave_positive(Image<float>& image) {
  for (float& value : image) value = std::isfinite(value) && value > 0 ? value : 0.0F;
}

Image<float> read_filled(const std::filesystem::path& path, const Coding& coding) {
  Image<float> image{read_any(path, coding)};
  if (image.empty()) throw InputError{printable_path(path), "has no pixels.", coding.kinds};
  return image;
}

}  // namespace

void settle_disparities(const std::string& name, Image<float>& image) {
  const auto negative{std::ranges::count_if(image, [](float d) { return std::isfinite(d) && d < 0; })};
  leave_positive(image);
  std::vector<float> values;
  std::ranges::copy_if(image, std::back_inserter(values), [](float d) { return d > 0; });
  constexpr std::ptrdiff_t rest{10};  // values of the other sign: rounded to zero, or outside of the right image
  if (negative > rest * std::ssize(values)) {
    throw InputError{name,
                     fmt::format("disparities are negative ({} values; {} are positive).", negative, values.size()),
                     "Disparity is u_left − u_right: change the sign, as of RAFT-Stereo's results."};
  }
  if (values.empty()) return;
  const auto middle{values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2)};
  std::ranges::nth_element(values, middle);
  if (*middle > static_cast<float>(image.width())) {
    throw InputError{name, fmt::format("most values exceed the image's width (half are above {:.0f}).", *middle),
                     "Disparities are in px of the left image: divide by the scale they were written with."};
  }
  const float largest{std::ranges::max(values)};
  if (largest < 1) {
    throw InputError{name, fmt::format("no value reaches 1 px (the largest is {:.3g}).", largest),
                     "Disparities are in px of the left image, in a PNG times 256."};
  }
}

Image<float> read_disparity(const std::filesystem::path& path) {
  Image<float> image{read_filled(path, {256, false, kinds})};
  settle_disparities(printable_path(path), image);
  return image;
}

Image<float> read_depth(const std::filesystem::path& path, double units_per_m) {
  Image<float> image{read_filled(path, {units_per_m, true, depth_kinds})};
  leave_positive(image);
  constexpr float farthest_m{1000};
  const auto known{std::ranges::count_if(image, [](float z) { return z > 0; })};
  const auto beyond{std::ranges::count_if(image, [](float z) { return z > farthest_m; })};
  if (2 * beyond > known) {
    throw InputError{printable_path(path), "most depths exceed 1000 m.",
                     "Depth of floats is in metres; --depth-scale says how many units of whole numbers are a metre."};
  }
  return image;
}

}  // namespace stereogrid::io
