// SPDX-License-Identifier: Apache-2.0
#include <zip.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <functional>
#include <memory>
#include <numeric>
#include <stdexcept>

#include "files/formats.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/npz.hpp"
#include "stereogrid/io/text.hpp"

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

using ArrayParts = std::vector<std::span<const std::byte>>;

ArrayParts parts_of(const NpzArray& array) {
  ArrayParts parts{array.bytes};
  parts.insert(parts.end(), array.further.begin(), array.further.end());
  return parts;
}

std::size_t size_of(const ArrayParts& parts) {
  std::size_t bytes{0};
  for (const auto part : parts) bytes += part.size();
  return bytes;
}

void check_shape(const NpzArray& array, std::size_t bytes) {
  const std::size_t elements{
      std::accumulate(array.shape.begin(), array.shape.end(), std::size_t{1}, std::multiplies<>{})};
  if (elements * element_size(array.dtype) != bytes) {
    throw std::invalid_argument{"array '" + array.name + "': its shape does not fit its " + std::to_string(bytes) +
                                " bytes"};
  }
}

[[noreturn]] void fail(const std::filesystem::path& path, const char* what) {
  throw DeviceError{printable_path(path) + ": cannot be written (" + what + "). Try again."};
}

using Archive = std::unique_ptr<zip_t, decltype(&zip_discard)>;

/// A .npy file as it lies in the archive.
struct Packed {
  std::string bytes;
  std::size_t size{0};  ///< before
  std::uint32_t checksum{0};
  std::size_t at{0};  ///< read up to here
};

Packed pack(const NpzArray& array) {
  const ArrayParts parts{parts_of(array)};
  check_shape(array, size_of(parts));
  std::string npy{npy_head(array)};
  npy.reserve(npy.size() + size_of(parts));
  for (const auto part : parts) npy.append(reinterpret_cast<const char*>(part.data()), part.size());
  return {deflate(npy, DeflateForm::raw), npy.size(), crc32_of(npy)};
}

void describe(const Packed& packed, zip_stat_t& description) {
  zip_stat_init(&description);
  description.valid = ZIP_STAT_SIZE | ZIP_STAT_COMP_SIZE | ZIP_STAT_COMP_METHOD | ZIP_STAT_CRC;
  description.size = packed.size;
  description.comp_size = packed.bytes.size();
  description.comp_method = ZIP_CM_DEFLATE;
  description.crc = packed.checksum;
}

/// Data source of libzip for already packed data.
zip_int64_t serve(void* state, void* data, zip_uint64_t length, zip_source_cmd_t command) {
  Packed& packed{*static_cast<Packed*>(state)};
  switch (command) {
    case ZIP_SOURCE_SUPPORTS:
      return zip_source_make_command_bitmap(ZIP_SOURCE_OPEN, ZIP_SOURCE_READ, ZIP_SOURCE_CLOSE, ZIP_SOURCE_STAT,
                                            ZIP_SOURCE_ERROR, ZIP_SOURCE_FREE, -1);
    case ZIP_SOURCE_OPEN:
      packed.at = 0;
      return 0;
    case ZIP_SOURCE_READ: {
      const std::size_t count{packed.bytes.copy(static_cast<char*>(data), length, packed.at)};
      packed.at += count;
      return static_cast<zip_int64_t>(count);
    }
    case ZIP_SOURCE_STAT:
      describe(packed, *static_cast<zip_stat_t*>(data));
      return sizeof(zip_stat_t);
    case ZIP_SOURCE_ERROR:
      std::fill_n(static_cast<int*>(data), 2, 0);
      return 2 * sizeof(int);
    default:
      return 0;
  }
}

void add(zip_t* archive, const std::string& name, Packed& npy, const std::filesystem::path& path) {
  zip_source_t* const source{zip_source_function(archive, serve, &npy)};
  if (source == nullptr) fail(path, zip_strerror(archive));
  const zip_int64_t place{zip_file_add(archive, (name + ".npy").c_str(), source, ZIP_FL_ENC_UTF_8)};
  if (place < 0) {
    zip_source_free(source);
    fail(path, zip_strerror(archive));
  }
  zip_set_file_compression(archive, static_cast<zip_uint64_t>(place), ZIP_CM_DEFLATE, 0);
  // 1980-01-01: the same arrays give the same bytes
  zip_file_set_dostime(archive, static_cast<zip_uint64_t>(place), 0, 0x21, 0);
}

std::string content_of(zip_source_t* source, const std::filesystem::path& path) {
  if (zip_source_open(source) != 0) fail(path, zip_error_strerror(zip_source_error(source)));
  zip_stat_t about;
  zip_stat_init(&about);
  zip_source_stat(source, &about);
  std::string bytes(about.size, '\0');
  if (zip_source_read(source, bytes.data(), bytes.size()) != static_cast<zip_int64_t>(bytes.size())) {
    fail(path, zip_error_strerror(zip_source_error(source)));
  }
  zip_source_close(source);
  return bytes;
}

}  // namespace

void write_npz(const std::filesystem::path& path, std::span<const NpzArray> arrays) {
  std::vector<Packed> files;  // libzip reads them when the archive is closed
  for (const NpzArray& array : arrays) files.push_back(pack(array));
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
  for (std::size_t i{0}; i < arrays.size(); ++i) add(archive.get(), arrays[i].name, files[i], path);
  if (zip_close(archive.get()) != 0) fail(path, zip_strerror(archive.get()));
  static_cast<void>(archive.release());
  write_file(path, content_of(memory.get(), path));
}

}  // namespace stereogrid::io
