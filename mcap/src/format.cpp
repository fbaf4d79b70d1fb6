// SPDX-License-Identifier: Apache-2.0
#include "format.hpp"

#include <limits>

namespace stereogrid::mcap {

void put(Bytes& out, View bytes) {
  out.insert(out.end(), bytes.begin(), bytes.end());
}

void put_text(Bytes& out, std::string_view text) {
  if (text.size() > std::numeric_limits<std::uint32_t>::max()) throw std::length_error{"a text of more than 4 GB"};
  put(out, static_cast<std::uint32_t>(text.size()));
  put(out, view_of(text));
}

void put_texts(Bytes& out, const std::map<std::string, std::string>& texts) {
  const Counted<std::uint32_t> length{out};
  for (const auto& [key, value] : texts) {
    put_text(out, key);
    put_text(out, value);
  }
}

View Fields::take(std::uint64_t size) {
  if (size > rest_.size()) throw Malformed{"a field is longer than its record"};
  const View taken{rest_.first(size)};
  rest_ = rest_.subspan(size);
  return taken;
}

std::string Fields::text() {
  const View bytes{counted<std::uint32_t>()};
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::map<std::string, std::string> Fields::texts() {
  Fields entries{counted<std::uint32_t>()};
  std::map<std::string, std::string> texts;
  while (!entries.empty()) {
    std::string key{entries.text()};
    texts.insert_or_assign(std::move(key), entries.text());
  }
  return texts;
}

}  // namespace stereogrid::mcap
