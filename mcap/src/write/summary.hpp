// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string_view>
#include <vector>

#include "format.hpp"

namespace stereogrid::mcap {

/// Log times, the first and last; 0 in a file where there is none.
struct Times {
  std::uint64_t first{std::numeric_limits<std::uint64_t>::max()}, last{0};

  void take(std::uint64_t time) {
    first = std::min(first, time);
    last = std::max(last, time);
  }
  void put_into(Bytes& out) const {
    put(out, first <= last ? first : 0);
    put(out, last);
  }
};

/// Summary section of a file, already encoded; about 100 bytes for each chunk.
class Summary {
 public:
  void add_schema(View record);
  void add_channel(View record);
  void add_metadata(std::uint64_t offset, std::uint64_t length, std::string_view name);
  /// A chunk index record is to be put there.
  Bytes& add_chunk(const Times& times);
  void add_messages(std::uint16_t channel, std::uint64_t count) { message_counts_[channel - 1U] += count; }

  [[nodiscard]] std::uint16_t schemas() const { return schema_count_; }
  [[nodiscard]] std::uint16_t channels() const { return static_cast<std::uint16_t>(message_counts_.size()); }

  /// Summary, summary offsets, footer and magic, which begin at byte `start` of the file.
  [[nodiscard]] Bytes bytes(std::uint64_t start) const;

 private:
  [[nodiscard]] Bytes statistics() const;

  Bytes schemas_, channels_, chunk_indexes_, metadata_indexes_;
  std::uint16_t schema_count_{0};
  std::uint32_t metadata_count_{0}, chunk_count_{0};
  std::vector<std::uint64_t> message_counts_;  // by channel id - 1
  Times times_;
};

}  // namespace stereogrid::mcap
