// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string_view>
#include <vector>

#include "compression.hpp"
#include "format.hpp"
#include "stereogrid/mcap/records.hpp"

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

/// The messages of a chunk until it is written. Its buffers grow to what chunks need, and stay.
class OpenChunk {
 public:
  explicit OpenChunk(Compression compression) : compression_{compression}, compressor_{compression} {}

  void add_channel() { indexes_.emplace_back(); }
  /// `message.channel` is one of the channels, from 1.
  void add(const Message& message);

  [[nodiscard]] bool empty() const { return records_.empty(); }
  [[nodiscard]] std::size_t size() const { return records_.size(); }
  /// Log time of its first message; there has to be one.
  [[nodiscard]] std::uint64_t begin_ns() const { return begin_ns_; }

  /// Parts of a written chunk: bytes before the packed messages, the messages, and bytes after them.
  struct Packed {
    View head, body, message_indexes;
    std::uint32_t body_crc{0};
  };
  /// The chunk as it is at byte `offset` of the file, entered in the summary. Valid until the next message.
  Packed pack(std::uint64_t offset, Summary& summary);
  void clear();

 private:
  struct IndexEntry {
    std::uint64_t log_time_ns, offset;
  };

  void put_head(std::uint64_t packed_size, std::uint32_t crc);
  void put_indexes(std::uint64_t offset, std::uint64_t packed_size, Summary& summary);

  Compression compression_;
  Compressor compressor_;
  Bytes records_, head_, message_indexes_;
  std::vector<std::vector<IndexEntry>> indexes_;  // by channel id - 1
  std::uint64_t begin_ns_{0};
  Times times_;
};

}  // namespace stereogrid::mcap
