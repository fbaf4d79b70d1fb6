// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "files/rvl.hpp"

#include <algorithm>
#include <cstring>

#include "stereogrid/error.hpp"
#include "stereogrid/io/image_file.hpp"

namespace stereogrid::io {
namespace {

class Nibbles {
 public:
  Nibbles(std::span<const std::byte> bytes, const std::string& name) : bytes_{bytes}, name_{name} {}

  [[noreturn]] void fail() const { throw InputError{name_, "the RVL depth is damaged.", "Record it again."}; }

  /// Three bits per nibble, the lowest first; the fourth says that more follow.
  std::uint32_t number() {
    std::uint32_t value{0};
    for (int shift{0}; shift < 32; shift += 3) {
      const std::uint32_t nibble{next()};
      value |= (nibble & 7U) << shift;
      if ((nibble & 8U) == 0) return value;
    }
    fail();
  }

  std::uint32_t word() {
    std::uint32_t value{0};
    if (bytes_.size() < sizeof value) fail();
    std::memcpy(&value, bytes_.data(), sizeof value);
    bytes_ = bytes_.subspan(sizeof value);
    return value;
  }

 private:
  std::uint32_t next() {
    if (left_ == 0) {
      word_ = word();
      left_ = 8;
    }
    --left_;
    return (word_ >> (4 * left_)) & 15U;
  }

  std::span<const std::byte> bytes_;
  const std::string& name_;
  std::uint32_t word_{0};
  unsigned left_{0};
};

}  // namespace

Image<std::uint16_t> decode_rvl(std::span<const std::byte> bytes, const std::string& name) {
  Nibbles code{bytes, name};
  const std::uint32_t width{code.word()};
  const std::uint32_t height{code.word()};
  if (width == 0 || height == 0 || std::max(width, height) > io::largest_side_px ||
      std::uint64_t{width} * height > io::most_pixels) {
    code.fail();
  }
  Image<std::uint16_t> image{static_cast<int>(width), static_cast<int>(height)};
  std::uint16_t value{0};
  for (auto at{image.begin()}; at != image.end();) {
    const auto run = [&] {
      const std::uint32_t count{code.number()};
      if (count > static_cast<std::uint64_t>(image.end() - at)) code.fail();
      return static_cast<std::ptrdiff_t>(count);
    };
    at = std::fill_n(at, run(), std::uint16_t{0});
    if (at == image.end()) break;
    at = std::generate_n(at, run(), [&] {
      const std::uint32_t difference{code.number()};
      value = static_cast<std::uint16_t>(value + ((difference >> 1U) ^ (0U - (difference & 1U))));
      return value;
    });
  }
  return image;
}

}  // namespace stereogrid::io
