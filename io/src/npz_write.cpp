// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <zip.h>

#include <algorithm>
#include <array>
#include <bit>
#include <functional>
#include <memory>
#include <numeric>
#include <stdexcept>

#include "npz_types.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/npz.hpp"

namespace stereogrid::io {
namespace {

static_assert(std::endian::native == std::endian::little, "arrays are written as they lie in memory");

/// The head of a .npy file, version 1.0, padded so that the numbers start at a multiple of 64 bytes.
std::string npy_head(const NpzArray& array) {
  std::string shape;
  for (const std::size_t extent : array.shape) shape += std::to_string(extent) + ", ";
  if (array.shape.size() > 1) shape.resize(shape.size() - 2);
  if (array.shape.size() == 1) shape.resize(shape.size() - 1);
  std::string text{"{'descr': '" + std::string{spelling(array.dtype)} + "', 'fortran_order': False, 'shape': (" +
                   shape + "), }"};
  text.append(63 - (10 + text.size()) % 64, ' ');
  text += '\n';
  std::string head{"\x93NUMPY\x01\x00", 8};
  head += static_cast<char>(text.size() & 0xff);
  head += static_cast<char>(text.size() >> 8);
  return head + text;
}

void check_shape(const NpzArray& array) {
  const std::size_t elements{
      std::accumulate(array.shape.begin(), array.shape.end(), std::size_t{1}, std::multiplies<>{})};
  if (elements * element_size(array.dtype) != array.bytes.size()) {
    throw std::invalid_argument{"array '" + array.name + "': its shape does not fit its " +
                                std::to_string(array.bytes.size()) + " bytes"};
  }
}

[[noreturn]] void fail(const std::filesystem::path& path, const char* what) {
  throw DeviceError{path.string() + ": cannot be written (" + what + "). Try again."};
}

using Archive = std::unique_ptr<zip_t, decltype(&zip_discard)>;

void add(zip_t* archive, const NpzArray& array, const std::string& npy, const std::filesystem::path& path) {
  zip_source_t* const source{zip_source_buffer(archive, npy.data(), npy.size(), 0)};
  if (source == nullptr) fail(path, zip_strerror(archive));
  const zip_int64_t place{zip_file_add(archive, (array.name + ".npy").c_str(), source, ZIP_FL_ENC_UTF_8)};
  if (place < 0) {
    zip_source_free(source);
    fail(path, zip_strerror(archive));
  }
  const auto index{static_cast<zip_uint64_t>(place)};
  zip_set_file_compression(archive, index, ZIP_CM_DEFLATE, 1);
  zip_file_set_dostime(archive, index, 0, 0x21, 0);  // 1980-01-01: the same arrays give the same bytes
}

std::string content_of(zip_source_t* source, const std::filesystem::path& path) {
  if (zip_source_open(source) != 0) fail(path, zip_error_strerror(zip_source_error(source)));
  std::string bytes;
  std::array<char, 65536> block{};
  for (zip_int64_t count{0}; (count = zip_source_read(source, block.data(), block.size())) > 0;) {
    bytes.append(block.data(), static_cast<std::size_t>(count));
  }
  zip_source_close(source);
  return bytes;
}

}  // namespace

void write_npz(const std::filesystem::path& path, std::span<const NpzArray> arrays) {
  std::vector<std::string> files;  // libzip reads them when the archive is closed
  for (const NpzArray& array : arrays) {
    check_shape(array);
    files.push_back(npy_head(array));
    files.back().append(reinterpret_cast<const char*>(array.bytes.data()), array.bytes.size());
  }
  zip_error_t error;
  zip_error_init(&error);
  const std::unique_ptr<zip_source_t, decltype(&zip_source_free)> memory{
      zip_source_buffer_create(nullptr, 0, 0, &error), zip_source_free};
  if (!memory) fail(path, zip_error_strerror(&error));
  zip_source_keep(memory.get());  // once for the archive, once for us
  Archive archive{zip_open_from_source(memory.get(), ZIP_TRUNCATE, &error), zip_discard};
  if (!archive) {
    zip_source_free(memory.get());
    fail(path, zip_error_strerror(&error));
  }
  for (std::size_t i{0}; i < arrays.size(); ++i) add(archive.get(), arrays[i], files[i], path);
  if (zip_close(archive.get()) != 0) fail(path, zip_strerror(archive.get()));
  static_cast<void>(archive.release());
  write_file(path, content_of(memory.get(), path));
}

}  // namespace stereogrid::io
