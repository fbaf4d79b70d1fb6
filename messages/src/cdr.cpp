// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/messages/cdr.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>

#include "stereogrid/error.hpp"

namespace stereogrid::messages {

static_assert(std::endian::native == std::endian::little, "arrays are copied as they lie in memory");

namespace {

constexpr std::array<std::byte, 4> encapsulation{std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}};

std::size_t padding(std::size_t position, std::size_t alignment) {
  return (alignment - position % alignment) % alignment;
}

}  // namespace

void CdrWriter::start() {
  bytes_.assign(encapsulation.begin(), encapsulation.end());
}

void CdrWriter::append(const void* data, std::size_t bytes) {
  const auto* const begin{static_cast<const std::byte*>(data)};
  bytes_.insert(bytes_.end(), begin, begin + bytes);
}

void CdrWriter::align(std::size_t alignment) {
  bytes_.resize(bytes_.size() + padding(bytes_.size() - encapsulation.size(), alignment));
}

void CdrWriter::write_count(std::size_t count) {
  if (count > std::numeric_limits<std::uint32_t>::max()) {
    throw InputError{"message", "it has an array or text of " + std::to_string(count) + " elements.",
                     "CDR counts them in 32 bits."};
  }
  write(static_cast<std::uint32_t>(count));
}

void CdrWriter::write(const std::string& text) {
  write_count(text.size() + 1);  // with the 0 at its end
  append(text.c_str(), text.size() + 1);
}

CdrReader::CdrReader(std::span<const std::byte> cdr, std::string_view type_name) : type_name_{type_name} {
  // the last two bytes are options, which a reader of this encoding ignores
  if (cdr.size() < encapsulation.size() || !std::equal(encapsulation.begin(), encapsulation.begin() + 2, cdr.begin())) {
    reject("does not begin with the bytes 00 01 of plain little-endian CDR");
  }
  body_ = cdr.subspan(encapsulation.size());
}

void CdrReader::reject(const std::string& what) const {
  const std::string where{field_.empty() ? std::string{"it"} : "the field \"" + std::string{field_} + "\""};
  throw InputError{std::string{type_name_}, where + " " + what + ".",
                   "The message is damaged, cut off, or of another type."};
}

void CdrReader::align(std::size_t alignment) {
  const std::size_t skipped{padding(position_, alignment)};
  if (skipped > left()) reject("lies behind the end");
  position_ += skipped;
}

void CdrReader::copy_to(void* data, std::size_t bytes) {
  if (bytes > left()) reject("lies behind the end");
  std::memcpy(data, body_.data() + position_, bytes);
  position_ += bytes;
}

std::size_t CdrReader::read_count(std::size_t least_bytes_each) {
  std::uint32_t count{0};
  read(count);
  if (count > left() / least_bytes_each) {
    reject("claims " + std::to_string(count) + " elements where " + std::to_string(left()) + " bytes are left");
  }
  return count;
}

void CdrReader::read(bool& flag) {
  std::uint8_t byte{0};
  read(byte);
  if (byte > 1) reject("is neither true nor false");
  flag = byte == 1;
}

void CdrReader::read(std::string& text) {
  const std::size_t count{read_count(1)};
  const auto* const begin{reinterpret_cast<const char*>(body_.data() + position_)};
  // some senders leave out the 0 of an empty text
  if (count > 0 && begin[count - 1] != '\0') reject("is a text without a 0 at its end");
  text.assign(begin, count > 0 ? count - 1 : 0);
  position_ += count;
}

void CdrReader::finish() const {
  if (left() > 3) {
    throw InputError{std::string{type_name_}, std::to_string(left()) + " bytes are left over behind it.",
                     "The message is of another type, or of another version of it."};
  }
}

}  // namespace stereogrid::messages
