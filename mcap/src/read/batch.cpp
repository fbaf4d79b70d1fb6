// SPDX-License-Identifier: Apache-2.0
#include "read/scanner.hpp"

#include <optional>
#include <utility>

#include "compression.hpp"

namespace stereogrid::mcap {
namespace {

constexpr std::size_t most_sentences{20};

std::uint64_t size_of(const Schema& schema) {
  return sizeof schema + schema.name.size() + schema.encoding.size() + schema.data.size();
}

std::uint64_t size_of(const Channel& channel) {
  constexpr std::uint64_t entry_bytes{128};
  std::uint64_t size{sizeof channel + channel.topic.size() + channel.message_encoding.size()};
  for (const auto& [key, value] : channel.metadata) size += entry_bytes + key.size() + value.size();
  return size;
}

/// Writers may repeat a declaration, which then counts once.
template <class Declared>
void replace(std::map<std::uint16_t, Declared>& declared, std::uint16_t id, Declared made, std::uint64_t& bytes) {
  const auto old{declared.find(id)};
  const std::uint64_t size{bytes + size_of(made) - (old == declared.end() ? 0 : size_of(old->second))};
  if (size > most_declared_bytes) throw Malformed{"the file declares more than 64 MiB of schemas and channels"};
  bytes = size;
  declared.insert_or_assign(id, std::move(made));
}

}  // namespace

Message Batch::message(const MessagePlace& place) const {
  const View content{records.subspan(place.offset, place.size)};
  return {place.channel, get<std::uint32_t>(content, 2), place.log_time_ns, get<std::uint64_t>(content, 14),
          content.subspan(message_head_bytes)};
}

std::uint64_t Batch::memory_bytes() const {
  return raw.capacity() + unpacked.capacity() + messages.capacity() * sizeof(MessagePlace);
}

RecordHead head_at(View bytes) {
  return {get<Op>(bytes, 0), get<std::uint64_t>(bytes, 1)};
}

void declare(Op op, View content, Contents& contents) {
  if (op != Op::schema && op != Op::channel) return;
  if (content.size() > most_declared_bytes) throw Malformed{"it declares more than 64 MiB of schemas and channels"};
  Fields fields{content};
  if (op == Op::schema) {
    const auto id{fields.number<std::uint16_t>()};
    Schema schema;
    schema.name = fields.text();
    schema.encoding = fields.text();
    schema.data = fields.text();
    if (id != 0) replace(contents.schemas, id, std::move(schema), contents.declared_bytes);
  } else {
    const auto id{fields.number<std::uint16_t>()};
    Channel channel;
    channel.schema_id = fields.number<std::uint16_t>();
    channel.topic = fields.text();
    channel.message_encoding = fields.text();
    channel.metadata = fields.texts();
    replace(contents.channels, id, std::move(channel), contents.declared_bytes);
  }
}

void unpack_chunk(View content, Batch& batch) {
  Fields fields{content};
  fields.number<std::uint64_t>();  // its times
  fields.number<std::uint64_t>();
  const auto size{fields.number<std::uint64_t>()};
  const auto crc{fields.number<std::uint32_t>()};
  const std::optional<Compression> compression{compression_of(fields.text())};
  const View packed{fields.counted<std::uint64_t>()};
  if (!compression) throw Malformed{"it is compressed in another way than by lz4 or zstd"};
  if (size > largest_chunk_bytes) throw Malformed{"it has more than 512 MiB"};
  batch.records = packed;
  if (*compression != Compression::none && size > 0) {
    decompress(*compression, packed, size, batch.unpacked);
    batch.records = batch.unpacked;
  }
  if (batch.records.size() != size) throw Malformed{"it has another size than it says"};
  if (crc != 0 && crc_of(batch.records) != crc) throw Malformed{"its checksum is wrong"};
}

void find_messages(Batch& batch, Contents& contents) {
  batch.messages.clear();
  const View records{batch.records};
  for (std::size_t at{0}; at < records.size();) {
    if (records.size() - at < record_head_bytes) throw Malformed{"its last record is cut off"};
    const RecordHead head{head_at(records.subspan(at))};
    at += record_head_bytes;
    if (head.op == Op{0}) throw Malformed{"it has bytes that are not a record"};
    if (head.length > records.size() - at) throw Malformed{"a record in it is longer than it"};
    const View content{records.subspan(at, head.length)};
    if (head.op == Op::message) {
      if (content.size() < message_head_bytes) throw Malformed{"a message in it is cut off"};
      batch.messages.push_back({get<std::uint64_t>(content, 6), at, content.size(), get<std::uint16_t>(content, 0)});
    }
    declare(head.op, content, contents);
    at += head.length;
  }
}

void load(const FileInput& file, const Place& place, Batch& batch) {
  if (place.length < record_head_bytes) throw Malformed{"it is shorter than any record"};
  if (place.length > largest_chunk_bytes) throw Malformed{"it has more than 512 MiB"};
  file.read(place.offset, place.length, batch.raw);
  batch.records = batch.raw;
  if (place.is_chunk) {
    // its own length may be damaged where the index is not: its checksum decides
    if (head_at(batch.raw).op != Op::chunk) throw Malformed{"there is no chunk"};
    unpack_chunk(View{batch.raw}.subspan(record_head_bytes), batch);
    if (batch.records.data() == batch.unpacked.data()) Bytes{}.swap(batch.raw);
  }
  Contents declared;  // already in the reader
  find_messages(batch, declared);
}

void note(Damage& damage, std::string sentence) {
  if (damage.sentences.size() < most_sentences) damage.sentences.push_back(std::move(sentence));
}

}  // namespace stereogrid::mcap
