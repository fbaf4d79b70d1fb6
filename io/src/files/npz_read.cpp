// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <zip.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <opencv2/core.hpp>
#include <regex>
#include <type_traits>

#include "files/formats.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/npz.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

const DTypeEntry& entry_of(DType dtype) {
  return *std::find_if(dtypes.begin(), dtypes.end(), [dtype](const DTypeEntry& entry) { return entry.dtype == dtype; });
}

[[noreturn]] void fail(const std::string& file, const std::string& what) {
  throw InputError{file, what, "Write it again with NumPy (C order, little-endian) or by stereogrid."};
}

struct Head {
  NpyArray array;
  std::size_t size{0};  ///< bytes before the numbers
  bool is_by_columns{false};
};

/// The numbers of "3, 4, ".
std::vector<std::size_t> parse_shape(const std::string& text, const std::string& where) {
  std::vector<std::size_t> shape;
  for (const char* at{text.data()}; at < text.data() + text.size(); ++at) {
    if (*at == ',' || *at == ' ') continue;
    std::size_t extent{0};
    const auto [end, error]{std::from_chars(at, text.data() + text.size(), extent)};
    if (error != std::errc{}) fail(where, "has a shape that is not understood: " + text);
    shape.push_back(extent);
    at = end - 1;
  }
  return shape;
}

/// Number of elements. `limit`: no array can have more.
std::size_t elements_of(const std::vector<std::size_t>& shape, std::size_t limit, const std::string& where) {
  std::size_t elements{1};
  constexpr std::size_t longest{std::numeric_limits<int>::max()};  // maximum side of an image
  for (const std::size_t extent : shape) {
    if (extent > longest) fail(where, fmt::format("says that it has {} numbers along a side.", extent));
    if (extent > 0 && elements > limit / extent) fail(where, "has not as many numbers as its shape says.");
    elements *= extent;
  }
  return elements;
}

Head parse_head(const std::string& npy, const std::string& where) {
  if (npy.size() < 12 || npy.compare(0, 6, "\x93NUMPY") != 0) fail(where, "is not a NumPy array.");
  const bool wide{npy[6] > 1};  // from version 2 on the length has 4 bytes
  const auto byte{[&npy](std::size_t i) { return static_cast<std::size_t>(static_cast<unsigned char>(npy[i])); }};
  const std::size_t length{byte(8) | byte(9) << 8 | (wide ? byte(10) << 16 | byte(11) << 24 : 0)};
  Head head;
  head.size = (wide ? 12 : 10) + length;
  constexpr std::size_t longest{1024};  // maximum length of a header; the pattern uses stack for each byte
  if (head.size > npy.size() || length > longest) fail(where, "has a damaged head.");
  std::string text{npy.substr(wide ? 12 : 10, length)};
  text.resize(text.find_last_not_of(" \n") + 1);
  static const std::regex form{R"(\{'descr': '([^']+)', 'fortran_order': (True|False), 'shape': \(([\d, ]*)\),? *\})"};
  std::smatch part;
  if (!std::regex_match(text, part, form)) fail(where, "has a head that is not understood: " + text);
  const auto found{std::find_if(dtypes.begin(), dtypes.end(),
                                [&part](const DTypeEntry& entry) { return entry.spelling == part[1].str(); })};
  if (found == dtypes.end()) fail(where, "has elements of type '" + part[1].str() + "', which is not understood.");
  head.array.dtype = found->dtype;
  head.array.shape = parse_shape(part[3].str(), where);
  head.is_by_columns = part[2] == "True" && head.array.shape.size() > 1;
  if (head.is_by_columns && head.array.shape.size() > 2) fail(where, "is stored column by column.");
  return head;
}

NpyArray parse_npy(const std::string& npy, const std::string& where) {
  Head head{parse_head(npy, where)};
  const std::size_t bytes{npy.size() - head.size};
  if (elements_of(head.array.shape, bytes, where) * element_size(head.array.dtype) != bytes)
    fail(where, "has not as many numbers as its shape says.");
  head.array.bytes.resize(bytes);
  if (bytes > 0) std::memcpy(head.array.bytes.data(), npy.data() + head.size, bytes);
  if (head.is_by_columns && bytes > 0) {
    const std::size_t item{element_size(head.array.dtype)};
    const std::size_t rows{head.array.shape[0]};
    for (std::size_t i{0}; i * item < bytes; ++i) {
      const std::size_t to{(i % rows) * head.array.shape[1] + i / rows};
      std::memcpy(head.array.bytes.data() + to * item, npy.data() + head.size + i * item, item);
    }
  }
  return std::move(head.array);
}

using Archive = std::unique_ptr<zip_t, decltype(&zip_discard)>;

Archive open_archive(const std::string& bytes, const std::string& file) {
  if (bytes.empty()) fail(file, "is not a whole .npz archive (empty).");  // libzip would take it for a new one
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* const source{zip_source_buffer_create(bytes.data(), bytes.size(), 0, &error)};
  Archive archive{source == nullptr ? nullptr : zip_open_from_source(source, ZIP_RDONLY | ZIP_CHECKCONS, &error),
                  zip_discard};
  if (!archive) {
    zip_source_free(source);
    fail(file, "is not a whole .npz archive (" + std::string{zip_error_strerror(&error)} + ").");
  }
  return archive;
}

/// Reads to the very end, so that libzip compares the checksum. `most`: a kilobyte can unfold into a gigabyte.
std::string read_entry(zip_t* archive, zip_uint64_t index, const std::string& where, std::size_t most) {
  const std::unique_ptr<zip_file_t, decltype(&zip_fclose)> entry{zip_fopen_index(archive, index, 0), zip_fclose};
  if (!entry) fail(where, "cannot be opened (" + std::string{zip_strerror(archive)} + ").");
  const auto check{[&where, most](std::uint64_t size) {
    if (size > most) fail(where, fmt::format("holds more than {} MB, the most that is read.", most >> 20));
  }};
  zip_stat_t declared;
  std::string npy;
  if (zip_stat_index(archive, index, 0, &declared) == 0 && (declared.valid & ZIP_STAT_SIZE) != 0) {
    check(declared.size);
    npy.reserve(declared.size);
  }
  std::array<char, 65536> block{};
  zip_int64_t count{0};
  while ((count = zip_fread(entry.get(), block.data(), block.size())) > 0) {
    npy.append(block.data(), static_cast<std::size_t>(count));
    check(npy.size());
  }
  if (count < 0) fail(where, "is damaged (" + std::string{zip_file_strerror(entry.get())} + ").");
  return npy;
}

/// As static_cast does it, which does not say what an integer makes of a float that it cannot hold.
template <class T, class From>
T converted(From value) {
  if constexpr (std::is_floating_point_v<From> && std::is_integral_v<T>) {
    if (std::isnan(value)) return 0;
    if (value <= static_cast<From>(std::numeric_limits<T>::lowest())) return std::numeric_limits<T>::lowest();
    if (value >= static_cast<From>(std::numeric_limits<T>::max())) return std::numeric_limits<T>::max();
  }
  return static_cast<T>(value);
}

template <class From, class T>
std::vector<T> convert(const std::vector<std::byte>& bytes) {
  std::vector<T> values(bytes.size() / sizeof(From));
  for (std::size_t i{0}; i < values.size(); ++i) {
    From value{};
    std::memcpy(&value, bytes.data() + i * sizeof(From), sizeof(From));
    if constexpr (std::is_same_v<From, Half>) {
      values[i] = converted<T>(static_cast<float>(value));
    } else {
      values[i] = converted<T>(value);
    }
  }
  return values;
}

}  // namespace

Half::Half(float value) {
  const cv::float16_t half{value};
  static_assert(sizeof half == sizeof bits);
  std::memcpy(&bits, &half, sizeof bits);
}

Half::operator float() const {
  cv::float16_t half;
  std::memcpy(static_cast<void*>(&half), &bits, sizeof bits);
  return static_cast<float>(half);
}

std::string_view spelling(DType dtype) {
  return entry_of(dtype).spelling;
}

std::size_t element_size(DType dtype) {
  return entry_of(dtype).size;
}

template <class T>
std::vector<T> NpyArray::to() const {
  switch (dtype) {
    case DType::float16:
      return convert<Half, T>(bytes);
    case DType::float32:
      return convert<float, T>(bytes);
    case DType::float64:
      return convert<double, T>(bytes);
    case DType::int8:
      return convert<std::int8_t, T>(bytes);
    case DType::int16:
      return convert<std::int16_t, T>(bytes);
    case DType::int32:
      return convert<std::int32_t, T>(bytes);
    case DType::int64:
      return convert<std::int64_t, T>(bytes);
    case DType::uint8:
    case DType::boolean:
      return convert<std::uint8_t, T>(bytes);
    case DType::uint16:
      return convert<std::uint16_t, T>(bytes);
    case DType::uint32:
      return convert<std::uint32_t, T>(bytes);
    case DType::uint64:
      return convert<std::uint64_t, T>(bytes);
  }
  return {};
}

template <class T>
Image<T> NpyArray::to_image() const {
  if (shape.size() != 2)
    throw InputError{"an array of " + std::to_string(shape.size()) + " dimensions is not an image"};
  Image<T> image{static_cast<int>(shape[1]), static_cast<int>(shape[0])};
  std::ranges::copy(to<T>(), image.begin());
  return image;
}

template std::vector<float> NpyArray::to() const;
template std::vector<double> NpyArray::to() const;
template std::vector<std::int32_t> NpyArray::to() const;
template std::vector<std::int64_t> NpyArray::to() const;
template std::vector<std::uint8_t> NpyArray::to() const;
template std::vector<std::uint16_t> NpyArray::to() const;
template Image<float> NpyArray::to_image() const;
template Image<double> NpyArray::to_image() const;
template Image<std::int32_t> NpyArray::to_image() const;
template Image<std::int64_t> NpyArray::to_image() const;
template Image<std::uint8_t> NpyArray::to_image() const;
template Image<std::uint16_t> NpyArray::to_image() const;

std::map<std::string, NpyArray> read_npz(const std::filesystem::path& path, std::size_t most_bytes) {
  const std::string file{printable_path(path)};
  const std::string bytes{read_file(path, most_bytes)};
  const Archive archive{open_archive(bytes, file)};
  std::map<std::string, NpyArray> arrays;
  std::size_t left{most_bytes};
  const auto count{static_cast<zip_uint64_t>(zip_get_num_entries(archive.get(), 0))};
  for (zip_uint64_t i{0}; i < count; ++i) {
    const char* const raw_name{zip_get_name(archive.get(), i, 0)};
    std::string name{printable(raw_name == nullptr ? "" : raw_name)};
    const std::string where{file + ", array " + name};
    if (name.ends_with(".npy")) name.resize(name.size() - 4);
    const std::string npy{read_entry(archive.get(), i, where, std::min(left, largest_bytes::array))};
    left -= npy.size();
    if (!arrays.emplace(name, parse_npy(npy, where)).second) fail(where, "is there twice.");
  }
  return arrays;
}

NpyArray read_npy(const std::filesystem::path& path) {
  return parse_npy(read_file(path, largest_bytes::array), printable_path(path));
}

}  // namespace stereogrid::io
