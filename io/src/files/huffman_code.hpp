// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <string>
#include <string_view>
#include <utility>

namespace stereogrid::io {

/// Longest code: the four of a word fit BitWriter::put.
constexpr int code_bits_max{14};

/// Bits of a deflate stream, the first one lowest.
class BitWriter {
 public:
  /// At most 56 bits.
  void put(std::uint64_t bits, int count) {
    if (used_ + count > 63) flush();
    buffer_ |= bits << used_;
    used_ += count;
  }
  /// Bytes as they are, after zeros up to a whole byte.
  void put_bytes(std::string_view bytes) {
    used_ = (used_ + 7) / 8 * 8;
    flush();
    out_.resize(size_);
    out_.append(bytes);
    size_ = out_.size();
  }
  std::string finish() { return std::move(out_); }

 private:
  void flush() {
    if (out_.size() < size_ + sizeof buffer_) out_.resize(2 * out_.size() + 4096);
    std::memcpy(out_.data() + size_, &buffer_, sizeof buffer_);
    size_ += static_cast<std::size_t>(used_ / 8);
    buffer_ = used_ < 64 ? buffer_ >> (used_ / 8 * 8) : 0;
    used_ %= 8;
  }

  std::string out_;
  std::size_t size_{0};  ///< bytes written; `out_` has room for more
  std::uint64_t buffer_{0};
  int used_{0};  ///< bits of it
};

/// Huffman code of the symbols 0 … Size − 1.
template <std::size_t Size>
class HuffmanCode {
 public:
  void count(int symbol, std::uint32_t times = 1) { counts_[static_cast<std::size_t>(symbol)] += times; }

  void build() {
    for (std::size_t i{0}; std::ranges::count(counts_, 0U) > static_cast<std::ptrdiff_t>(Size - 2); ++i) {
      counts_[i] = std::max(counts_[i], 1U);  // two symbols at least, for a complete code
    }
    while (!set_lengths()) {
      for (std::uint32_t& count : counts_) count = (count + 1) / 2;
    }
    set_bits();
  }
  void put(int symbol, BitWriter& out) const {
    const auto i = static_cast<std::size_t>(symbol);
    out.put(bits_[i], lengths_[i]);
  }
  [[nodiscard]] std::uint64_t bits(std::size_t symbol) const { return bits_[symbol]; }
  [[nodiscard]] const std::array<std::uint8_t, Size>& lengths() const { return lengths_; }

 private:
  // False: a code would be too long.
  bool set_lengths() {
    std::array<std::uint16_t, Size> order{};
    std::iota(order.begin(), order.end(), std::uint16_t{0});
    std::ranges::stable_sort(order, {}, [&](std::uint16_t i) { return counts_[i]; });
    const auto first = static_cast<std::size_t>(std::ranges::count(counts_, 0U));
    // leaves and inner nodes, each in ascending order: the two least are always in front
    std::array<std::uint32_t, 2 * Size> weight{};
    std::array<std::uint16_t, 2 * Size> parent{};
    for (std::size_t i{first}; i < Size; ++i) weight[i] = counts_[order[i]];
    std::size_t leaf{first};
    std::size_t inner{Size};
    const auto last = 2 * Size - 1 - first;
    for (std::size_t node{Size}; node < last; ++node) {
      for (int side{0}; side < 2; ++side) {
        const bool is_leaf{inner == node || (leaf < Size && weight[leaf] <= weight[inner])};
        const std::size_t least{is_leaf ? leaf++ : inner++};
        weight[node] += weight[least];
        parent[least] = static_cast<std::uint16_t>(node);
      }
    }
    std::array<std::uint8_t, 2 * Size> depth{};
    lengths_ = {};
    for (std::size_t node{last - 1}; node-- > first;) {
      depth[node] = static_cast<std::uint8_t>(depth[parent[node]] + 1);
      if (depth[node] > code_bits_max) return false;
      if (node < Size) lengths_[order[node]] = depth[node];
    }
    return true;
  }

  // Canonical codes, their first bit lowest.
  void set_bits() {
    std::uint32_t next{0};
    for (int length{1}; length <= code_bits_max; ++length, next <<= 1) {
      for (std::size_t i{0}; i < Size; ++i) {
        if (lengths_[i] != length) continue;
        std::uint32_t reversed{0};
        for (int bit{0}; bit < length; ++bit) reversed |= (next >> bit & 1U) << (length - 1 - bit);
        bits_[i] = static_cast<std::uint16_t>(reversed);
        ++next;
      }
    }
  }

  std::array<std::uint32_t, Size> counts_{};
  std::array<std::uint8_t, Size> lengths_{};
  std::array<std::uint16_t, Size> bits_{};
};

}  // namespace stereogrid::io
