// SPDX-License-Identifier: Apache-2.0
#include "read/scanner.hpp"

#include <algorithm>
#include <optional>

#include "compression.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid::mcap {
namespace {

constexpr std::uint64_t end_bytes{record_head_bytes + footer_bytes + magic.size()};
constexpr std::uint64_t largest_header_bytes{std::uint64_t{1} << 20};

bool is_magic(View bytes) {
  return std::ranges::equal(bytes, view_of(magic));
}

struct Footer {
  std::uint64_t at{0}, summary_start{0}, offsets_start{0};
  std::uint32_t crc{0};
};

Footer read_footer(const FileInput& file) {
  if (file.size() < magic.size() + end_bytes) throw Malformed{"the file has no end"};
  Footer footer;
  footer.at = file.size() - end_bytes;
  Bytes bytes;
  file.read(footer.at, end_bytes, bytes);
  const RecordHead head{head_at(bytes)};
  if (!is_magic(View{bytes}.last(magic.size()))) throw Malformed{"the file has no end mark"};
  if (head.op != Op::footer || head.length != footer_bytes) throw Malformed{"the file has no footer"};
  Fields fields{View{bytes}.subspan(record_head_bytes)};
  footer.summary_start = fields.number<std::uint64_t>();
  footer.offsets_start = fields.number<std::uint64_t>();
  footer.crc = fields.number<std::uint32_t>();
  const std::uint64_t summary_end{footer.offsets_start == 0 ? footer.at : footer.offsets_start};
  if (footer.summary_start > summary_end || summary_end > footer.at) throw Malformed{"its place is wrong"};
  return footer;
}

/// Totals of the statistics record, beside the counts of messages.
struct Totals {
  std::uint64_t messages{0}, chunks{0};
};

Totals take_statistics(View content, Contents& contents) {
  Fields fields{content};
  Totals totals;
  totals.messages = fields.number<std::uint64_t>();
  fields.number<std::uint16_t>();                                               // schemas
  for (int skipped{0}; skipped < 3; ++skipped) fields.number<std::uint32_t>();  // channels, attachments, metadata
  totals.chunks = fields.number<std::uint32_t>();
  contents.first_ns = fields.number<std::uint64_t>();
  contents.last_ns = fields.number<std::uint64_t>();
  Fields counts{fields.counted<std::uint32_t>()};
  while (!counts.empty()) {
    const auto channel{counts.number<std::uint16_t>()};
    contents.message_counts[channel] = counts.number<std::uint64_t>();
  }
  return totals;
}

Place chunk_place(View content) {
  Fields fields{content};
  Place place;
  place.first_ns = fields.number<std::uint64_t>();
  place.last_ns = fields.number<std::uint64_t>();
  place.offset = fields.number<std::uint64_t>();
  place.length = fields.number<std::uint64_t>();
  Fields offsets{fields.counted<std::uint32_t>()};
  while (!offsets.empty()) {
    place.channels.push_back(offsets.number<std::uint16_t>());
    offsets.number<std::uint64_t>();
  }
  return place;
}

/// Sorts the chunks as they are in the file.
void check_chunks(SummarySection& summary) {
  std::ranges::sort(summary.chunks, {}, &Place::offset);
  std::uint64_t end{magic.size()};
  for (const Place& chunk : summary.chunks) {
    const bool fits{chunk.offset >= end && chunk.offset <= summary.data_end &&
                    chunk.length <= summary.data_end - chunk.offset && chunk.first_ns <= chunk.last_ns};
    if (!fits) throw Malformed{"it names chunks where none can be"};
    end = chunk.offset + chunk.length;
  }
}

bool all_counted(const Contents& contents, std::uint64_t messages) {
  std::uint64_t counted{0};
  for (const auto& [channel, count] : contents.message_counts) {
    if (!contents.channels.contains(channel) || count > messages - counted) return false;
    counted += count;
  }
  return counted == messages;
}

}  // namespace

void require_mcap(const FileInput& file) {
  Bytes first(magic.size());
  if (file.size() < first.size()) {
    throw InputError{file.name(), "is not an MCAP file: it has fewer than 8 bytes.", "Was it written to its end?"};
  }
  file.read(0, first);
  if (!is_magic(first)) {
    throw InputError{file.name(), "is not an MCAP file: other bytes than its mark stand at byte 0.",
                     "Name a recording."};
  }
}

void read_header(const FileInput& file, Contents& contents) {
  Bytes bytes;
  file.read(magic.size(), record_head_bytes, bytes);
  const RecordHead head{head_at(bytes)};
  if (head.op != Op::header || head.length > largest_header_bytes) throw Malformed{"the file has no header"};
  file.read(magic.size() + record_head_bytes, head.length, bytes);
  Fields fields{bytes};
  contents.profile = fields.text();
  contents.library = fields.text();
}

SummarySection read_summary(const FileInput& file) {
  const Footer footer{read_footer(file)};
  SummarySection summary;
  summary.data_end = footer.summary_start == 0 ? footer.at : footer.summary_start;
  const std::uint64_t size{footer.at - summary.data_end};
  if (size > largest_chunk_bytes) throw Malformed{"it has more than 512 MiB"};
  Bytes bytes;
  file.read(summary.data_end, size + record_head_bytes + footer_bytes, bytes);
  if (footer.crc != 0 && crc_of(View{bytes}.first(bytes.size() - sizeof(footer.crc))) != footer.crc) {
    throw Malformed{"its checksum is wrong"};
  }
  std::optional<Totals> totals;
  View rest{View{bytes}.first(size)};
  while (!rest.empty()) {
    if (rest.size() < record_head_bytes) throw Malformed{"its last record is cut off"};
    const RecordHead head{head_at(rest)};
    rest = rest.subspan(record_head_bytes);
    if (head.length > rest.size()) throw Malformed{"a record in it is longer than it"};
    const View content{rest.first(head.length)};
    declare(head.op, content, summary.contents);
    if (head.op == Op::statistics) totals = take_statistics(content, summary.contents);
    if (head.op == Op::chunk_index) summary.chunks.push_back(chunk_place(content));
    rest = rest.subspan(head.length);
  }
  check_chunks(summary);
  summary.is_complete = totals && totals->chunks == summary.chunks.size() &&
                        (totals->messages == 0 || !summary.chunks.empty()) &&
                        all_counted(summary.contents, totals->messages);
  return summary;
}

}  // namespace stereogrid::mcap
