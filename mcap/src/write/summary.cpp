// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "write/open_chunk.hpp"

#include <numeric>

#include "compression.hpp"

namespace stereogrid::mcap {

void Summary::add_schema(View record) {
  put(schemas_, record);
  ++schema_count_;
}

void Summary::add_channel(View record) {
  put(channels_, record);
  message_counts_.push_back(0);
}

void Summary::add_metadata(std::uint64_t offset, std::uint64_t length, std::string_view name) {
  const Record record{metadata_indexes_, Op::metadata_index};
  put(metadata_indexes_, offset);
  put(metadata_indexes_, length);
  put_text(metadata_indexes_, name);
  ++metadata_count_;
}

Bytes& Summary::add_chunk(const Times& times) {
  times_.take(times.first);
  times_.take(times.last);
  ++chunk_count_;
  return chunk_indexes_;
}

Bytes Summary::statistics() const {
  Bytes bytes;
  {
    const Record record{bytes, Op::statistics};
    put(bytes, std::accumulate(message_counts_.begin(), message_counts_.end(), std::uint64_t{0}));
    put(bytes, schema_count_);
    put(bytes, std::uint32_t{channels()});
    put(bytes, std::uint32_t{0});  // attachments
    put(bytes, metadata_count_);
    put(bytes, chunk_count_);
    times_.put_into(bytes);
    const Counted<std::uint32_t> counts{bytes};
    for (std::uint16_t i{0}; i < channels(); ++i) {
      put(bytes, static_cast<std::uint16_t>(i + 1));
      put(bytes, message_counts_[i]);
    }
  }
  return bytes;
}

Bytes Summary::bytes(std::uint64_t start) const {
  const Bytes counts{statistics()};
  Bytes bytes, offsets;
  for (const View group :
       {View{schemas_}, View{channels_}, View{counts}, View{chunk_indexes_}, View{metadata_indexes_}}) {
    if (group.empty()) continue;
    const Record record{offsets, Op::summary_offset};
    put(offsets, group.front());  // every record begins with its opcode
    put(offsets, start + bytes.size());
    put(offsets, std::uint64_t{group.size()});
    put(bytes, group);
  }
  const std::uint64_t offsets_start{start + bytes.size()};
  put(bytes, View{offsets});
  put(bytes, Op::footer);
  put(bytes, std::uint64_t{footer_bytes});
  put(bytes, start);
  put(bytes, offsets_start);
  put(bytes, crc_of(bytes));
  put(bytes, view_of(magic));
  return bytes;
}

}  // namespace stereogrid::mcap
