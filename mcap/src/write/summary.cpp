// SPDX-License-Identifier: Apache-2.0
#include "write/open_chunk.hpp"

#include <numeric>

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

void OpenChunk::add(const Message& message) {
  if (records_.empty()) begin_ns_ = message.log_time_ns;
  times_.take(message.log_time_ns);
  indexes_[message.channel - 1U].push_back({message.log_time_ns, records_.size()});
  const Record record{records_, Op::message};
  put(records_, message.channel);
  put(records_, message.sequence);
  put(records_, message.log_time_ns);
  put(records_, message.publish_time_ns);
  put(records_, message.data);
}

OpenChunk::Packed OpenChunk::pack(std::uint64_t offset, Summary& summary) {
  const std::uint32_t crc{crc_of(records_)};
  const View body{compressor_.compress(records_)};
  put_head(body.size(), crc);
  put_indexes(offset, body.size(), summary);
  return {head_, body, message_indexes_, compression_ == Compression::none ? crc : crc_of(body)};
}

void OpenChunk::clear() {
  records_.clear();
  for (std::vector<IndexEntry>& index : indexes_) index.clear();
  times_ = {};
}

void OpenChunk::put_head(std::uint64_t packed_size, std::uint32_t crc) {
  head_.clear();
  put(head_, Op::chunk);
  put(head_, std::uint64_t{0});
  times_.put_into(head_);
  put(head_, std::uint64_t{records_.size()});
  put(head_, crc);
  put_text(head_, name_of(compression_));
  put(head_, packed_size);
  const std::uint64_t length{head_.size() - record_head_bytes + packed_size};
  std::memcpy(head_.data() + 1, &length, sizeof(length));
}

void OpenChunk::put_indexes(std::uint64_t offset, std::uint64_t packed_size, Summary& summary) {
  const std::uint64_t length{head_.size() + packed_size};
  Bytes& chunk_index{summary.add_chunk(times_)};
  const Record record{chunk_index, Op::chunk_index};
  times_.put_into(chunk_index);
  put(chunk_index, offset);
  put(chunk_index, length);
  message_indexes_.clear();
  {
    const Counted<std::uint32_t> offsets{chunk_index};
    for (std::size_t i{0}; i < indexes_.size(); ++i) {
      if (indexes_[i].empty()) continue;
      const auto channel{static_cast<std::uint16_t>(i + 1)};
      put(chunk_index, channel);
      put(chunk_index, offset + length + message_indexes_.size());
      const Record message_index{message_indexes_, Op::message_index};
      put(message_indexes_, channel);
      const Counted<std::uint32_t> entries{message_indexes_};
      for (const IndexEntry& entry : indexes_[i]) {
        put(message_indexes_, entry.log_time_ns);
        put(message_indexes_, entry.offset);
      }
      summary.add_messages(channel, indexes_[i].size());
    }
  }
  put(chunk_index, std::uint64_t{message_indexes_.size()});
  put_text(chunk_index, name_of(compression_));
  put(chunk_index, packed_size);
  put(chunk_index, std::uint64_t{records_.size()});
}

}  // namespace stereogrid::mcap
