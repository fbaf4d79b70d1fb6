// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "compression.hpp"
#include "format.hpp"
#include "stereogrid/mcap/records.hpp"
#include "write/summary.hpp"

namespace stereogrid::mcap {

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
