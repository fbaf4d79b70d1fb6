// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "files/deflate_words.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

#include "files/huffman_code.hpp"

namespace stereogrid::io {
namespace {

constexpr int end_of_block{256};
constexpr std::size_t literals{286};
constexpr std::size_t distances{30};
constexpr std::size_t piece_max{258};
constexpr std::size_t window_words{8192};

/// Symbol of a length or distance, and the bits behind it.
struct Symbol {
  int symbol;
  int extra_bits;
  std::uint32_t extra;
};

Symbol symbol_of_length(std::size_t bytes) {
  const auto above = static_cast<std::uint32_t>(bytes - 3);
  if (bytes == piece_max) return {285, 0, 0};
  if (above < 8) return {257 + static_cast<int>(above), 0, 0};
  const int extra{static_cast<int>(std::bit_width(above)) - 3};
  return {261 + 4 * extra + static_cast<int>(above >> extra & 3), extra, above & ((1U << extra) - 1)};
}

Symbol symbol_of_distance(std::size_t bytes) {
  const auto above = static_cast<std::uint32_t>(bytes - 1);
  if (above < 4) return {static_cast<int>(above), 0, 0};
  const int extra{static_cast<int>(std::bit_width(above)) - 2};
  return {2 + 2 * extra + static_cast<int>(above >> extra & 1), extra, above & ((1U << extra) - 1)};
}

/// A word, or a repetition of bytes.
struct Token {
  std::uint32_t word;      ///< or the distance
  std::uint32_t repeated;  ///< bytes; 0: a word
};

// Calls work(piece) for the bytes of a repetition; a piece has at least three.
template <class Work>
void for_pieces(std::size_t bytes, const Work& work) {
  while (bytes > 0) {
    const std::size_t piece{bytes <= piece_max ? bytes : bytes < piece_max + 3 ? piece_max - 4 : piece_max};
    work(piece);
    bytes -= piece;
  }
}

// A block of its own codes.
class Block {
 public:
  explicit Block(BitWriter& out) : out_{out} { tokens_.reserve(tokens_max); }

  void add(Token token) {
    tokens_.push_back(token);
    if (tokens_.size() == tokens_max) write();
  }
  void write() {
    if (tokens_.empty()) return;
    make_codes();
    write_codes();
    for (const Token& token : tokens_) token.repeated == 0 ? put_word(token.word) : put_repetition(token);
    of_literals_.put(end_of_block, out_);
    tokens_.clear();
  }

 private:
  static constexpr std::size_t tokens_max{16384};
  static constexpr std::uint64_t long_zeros{15};  ///< code of a run of zeros

  void make_codes() {
    of_literals_ = {};
    of_distances_ = {};
    of_literals_.count(end_of_block);
    for (const Token& token : tokens_) {
      if (token.repeated == 0) {
        for (int i{0}; i < 4; ++i) of_literals_.count(static_cast<int>(token.word >> 8 * i & 0xff));
      } else {
        const int distance{symbol_of_distance(token.word).symbol};
        for_pieces(token.repeated, [&](std::size_t piece) {
          of_literals_.count(symbol_of_length(piece).symbol);
          of_distances_.count(distance);
        });
      }
    }
    of_literals_.build();
    of_distances_.build();
  }

  // Four bits each: the lengths 0 to 14, and runs of zeros.
  void write_codes() {
    out_.put(0b100, 3);
    out_.put(literals - 257, 5);
    out_.put(distances - 1, 5);
    constexpr std::array order{16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1};
    out_.put(order.size() - 4, 4);
    for (const int symbol : order) out_.put(symbol <= code_bits_max || symbol == 18 ? 4 : 0, 3);
    std::array<std::uint8_t, literals + distances> lengths{};
    const auto rest = std::ranges::copy(of_literals_.lengths(), lengths.begin()).out;
    std::ranges::copy(of_distances_.lengths(), rest);
    for (std::size_t i{0}; i < lengths.size();) {
      const auto end = std::find_if(lengths.begin() + static_cast<std::ptrdiff_t>(i), lengths.end(),
                                    [](std::uint8_t length) { return length != 0; });
      const std::size_t zeros{std::min(static_cast<std::size_t>(end - lengths.begin()) - i, std::size_t{138})};
      if (zeros >= 11) {
        put_length(long_zeros);
        out_.put(zeros - 11, 7);
        i += zeros;
      } else {
        put_length(lengths[i++]);
      }
    }
  }
  void put_length(std::uint64_t code) { out_.put((code & 1) << 3 | (code & 2) << 1 | (code & 4) >> 1 | code >> 3, 4); }

  void put_word(std::uint32_t word) {
    std::uint64_t bits{0};
    int count{0};
    for (int i{0}; i < 4; ++i) {
      const std::size_t symbol{word >> 8 * i & 0xff};
      bits |= of_literals_.bits(symbol) << count;
      count += of_literals_.lengths()[symbol];
    }
    out_.put(bits, count);
  }

  void put_repetition(const Token& token) {
    const Symbol distance{symbol_of_distance(token.word)};
    for_pieces(token.repeated, [&](std::size_t piece) {
      const Symbol length{symbol_of_length(piece)};
      of_literals_.put(length.symbol, out_);
      out_.put(length.extra, length.extra_bits);
      of_distances_.put(distance.symbol, out_);
      out_.put(distance.extra, distance.extra_bits);
    });
  }

  BitWriter& out_;
  std::vector<Token> tokens_;
  HuffmanCode<literals> of_literals_;
  HuffmanCode<distances> of_distances_;
};

std::uint32_t word_at(const std::byte* bytes, std::size_t i) {
  std::uint32_t word{0};
  std::memcpy(&word, bytes + 4 * i, sizeof word);
  return word;
}

// Words from `begin` on, before `end`, that are as those from `before` on.
std::size_t equal_words(const std::byte* bytes, std::size_t before, std::size_t begin, std::size_t end) {
  constexpr std::size_t step{16};
  std::size_t i{begin};
  for (; i + step <= end; i += step) {
    std::uint32_t differs{0};
    for (std::size_t k{0}; k < step; ++k) differs |= word_at(bytes, i + k) ^ word_at(bytes, before + i - begin + k);
    if (differs != 0) break;
  }
  while (i < end && word_at(bytes, i) == word_at(bytes, before + i - begin)) ++i;
  return i - begin;
}

void add_words(const std::byte* bytes, std::size_t count, Block& block) {
  constexpr int hash_bits{13};
  constexpr std::size_t none{~std::size_t{0}};
  std::vector<std::size_t> last_at(std::size_t{1} << hash_bits, none);  // by hash
  const auto exchange = [&](std::size_t i) {
    return std::exchange(last_at[word_at(bytes, i) * 0x9e3779b1U >> (32 - hash_bits)], i);
  };
  for (std::size_t i{0}; i < count;) {
    const std::size_t before{exchange(i)};
    const bool is_near{before != none && i - before <= window_words};
    const std::size_t equal{is_near ? equal_words(bytes, before, i, count) : 0};
    if (equal == 0) {
      block.add({word_at(bytes, i++), 0});
    } else {
      block.add({static_cast<std::uint32_t>(4 * (i - before)), static_cast<std::uint32_t>(4 * equal)});
      i += equal;
      exchange(i - 1);
    }
  }
}

void put_stored(std::string_view bytes, bool is_last, BitWriter& out) {
  out.put(is_last ? 1 : 0, 3);
  out.put_bytes({});
  out.put(bytes.size() | (~bytes.size() & 0xffff) << 16, 32);
  out.put_bytes(bytes);
}

}  // namespace

std::string deflate_words(std::string_view head, std::span<const std::span<const std::byte>> words) {
  BitWriter out;
  put_stored(head, false, out);
  Block block{out};
  for (const auto part : words) add_words(part.data(), part.size() / 4, block);
  block.write();
  put_stored({}, true, out);
  return out.finish();
}

}  // namespace stereogrid::io
