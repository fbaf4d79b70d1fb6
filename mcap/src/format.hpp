// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace stereogrid::mcap {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they are in the file");

using Bytes = std::vector<std::byte>;
using View = std::span<const std::byte>;

inline constexpr std::string_view magic{"\x89MCAP0\r\n", 8};

enum class Op : std::uint8_t {
  header = 1,
  footer,
  schema,
  channel,
  message,
  chunk,
  message_index,
  chunk_index,
  attachment,
  attachment_index,
  statistics,
  metadata,
  metadata_index,
  summary_offset,
  data_end
};

inline constexpr std::size_t record_head_bytes{9};    // opcode and length
inline constexpr std::size_t message_head_bytes{22};  // header before a message's data
inline constexpr std::size_t footer_bytes{20};

inline View view_of(std::string_view text) {
  return std::as_bytes(std::span{text});
}

/// Not inline: g++ 12 sees writes in the standard library's insert() that are not there.
void put(Bytes& out, View bytes);

template <class T>
requires std::is_integral_v<T> || std::is_enum_v<T>
void put(Bytes& out, T value) {
  put(out, std::as_bytes(std::span{&value, 1}));
}

template <class T>
T get(View bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

/// A length before what it counts, known only at the end of its own life.
template <class Length>
class Counted {
 public:
  explicit Counted(Bytes& out) : out_{out}, at_{out.size()} { put(out, Length{0}); }
  Counted(const Counted&) = delete;
  Counted& operator=(const Counted&) = delete;
  ~Counted() {
    const auto length{static_cast<Length>(out_.size() - at_ - sizeof(Length))};
    std::memcpy(out_.data() + at_, &length, sizeof(Length));
  }

 private:
  Bytes& out_;
  std::size_t at_;
};

/// Writes a record around the content added during its lifetime.
class Record {
 public:
  Record(Bytes& out, Op op) : length_{(put(out, op), out)} {}

 private:
  Counted<std::uint64_t> length_;
};

/// Throws std::length_error where the length has no place in the file.
void put_text(Bytes& out, std::string_view text);
void put_texts(Bytes& out, const std::map<std::string, std::string>& texts);

/// Bytes that are no record as it has to be; the message says what is wrong, without file and place.
class Malformed : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A record's fields, one after the other. Throws Malformed where it ends too early.
class Fields {
 public:
  explicit Fields(View bytes) : rest_{bytes} {}

  template <class T>
  T number() {
    return get<T>(take(sizeof(T)), 0);
  }
  std::string text();
  std::map<std::string, std::string> texts();
  /// Writes a length prefix of type Length.
  template <class Length>
  View counted() {
    return take(number<Length>());
  }
  [[nodiscard]] bool empty() const { return rest_.empty(); }
  [[nodiscard]] View rest() const { return rest_; }

 private:
  View take(std::uint64_t size);

  View rest_;
};

}  // namespace stereogrid::mcap
