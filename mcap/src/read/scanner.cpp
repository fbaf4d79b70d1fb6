// SPDX-License-Identifier: Apache-2.0
#include "read/scanner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "compression.hpp"

namespace stereogrid::mcap {
namespace {

constexpr std::uint64_t pass_over_bytes{std::uint64_t{1} << 20};

std::uint64_t messages_of(const Contents& contents) {
  std::uint64_t messages{0};
  for (const auto& [channel, count] : contents.message_counts) messages += count;
  return messages;
}

}  // namespace

Scanner::Scanner(const FileInput& file) : file_{file}, at_{magic.size()}, crc_{crc_of(view_of(magic))} {
  require_mcap(file);
  try {
    read_header(file, contents_);
  } catch (const Malformed& wrong) {
    note(damage_, fmt::format("At byte {}: {}.", at_, wrong.what()));
  }
}

bool Scanner::next() {
  has_messages_ = false;
  while (!is_done_ && !has_messages_) {
    RecordHead head{};
    if (read_head(head)) take(head);
  }
  return has_messages_;
}

bool Scanner::read_head(RecordHead& head) {
  const std::uint64_t left{file_.size() - at_};
  if (left < record_head_bytes) {
    stop(at_, left == 0 ? "the recording was cut off there" : "the recording was cut off in the middle of a record");
    return false;
  }
  Bytes bytes(record_head_bytes);
  file_.read(at_, bytes);
  head = head_at(bytes);
  if (head.op == Op{0}) {
    stop(at_, "what follows is not a record");
    return false;
  }
  if (head.length > left - record_head_bytes) {
    stop(at_, "the recording was cut off in the middle of a record, or the record has a wrong length");
    return false;
  }
  record_at_ = at_;
  at_ += record_head_bytes;
  if (head.op != Op::data_end) crc_ = crc_of(bytes, crc_);  // it has the checksum of all before it
  return true;
}

bool Scanner::read_content(const RecordHead& head) {
  if (head.length > largest_chunk_bytes) {
    note(damage_, fmt::format("At byte {} a record of {} bytes is skipped: no more than 512 MiB are read.", record_at_,
                              head.length));
    pass_over(head.length);
    return false;
  }
  file_.read(at_, head.length, batch_.raw);
  at_ += head.length;
  crc_ = crc_of(batch_.raw, crc_);
  return true;
}

void Scanner::pass_over(std::uint64_t length) {
  while (length > 0) {
    file_.read(at_, std::min(length, pass_over_bytes), batch_.raw);
    crc_ = crc_of(batch_.raw, crc_);
    at_ += batch_.raw.size();
    length -= batch_.raw.size();
  }
}

void Scanner::take(const RecordHead& head) {
  switch (head.op) {
    case Op::chunk:
    case Op::message:
      return take_messages(head);
    case Op::schema:
    case Op::channel:
      if (!read_content(head)) return;
      try {
        declare(head.op, batch_.raw, contents_);
      } catch (const Malformed& wrong) {
        note(damage_, fmt::format("At byte {} a declaration is skipped: {}.", record_at_, wrong.what()));
      }
      return;
    case Op::data_end:
      check_data_crc(head);
      at_ += head.length;
      return check_end();
    case Op::footer:
      at_ = record_at_;
      return check_end();
    case Op::chunk_index:
    case Op::attachment_index:
    case Op::statistics:
    case Op::metadata_index:
    case Op::summary_offset:
      return stop(record_at_, "a record follows that belongs behind the end of all messages");
    default:  // attachments, metadata, indexes, and what later versions may have
      return pass_over(head.length);
  }
}

void Scanner::take_messages(const RecordHead& head) {
  place_ = {record_at_, record_head_bytes + head.length, head.op == Op::chunk, 0, 0, {}};
  has_chunks_ = has_chunks_ || place_.is_chunk;
  if (!read_content(head)) {
    damage_.chunks_skipped += place_.is_chunk ? 1 : 0;
    return;
  }
  try {
    unpack(head);
    find_messages(batch_, contents_);
    keep_declared();
  } catch (const Malformed& wrong) {
    damage_.chunks_skipped += place_.is_chunk ? 1 : 0;
    note(damage_, fmt::format("At byte {} a {} of {} bytes is skipped: {}.", record_at_,
                              place_.is_chunk ? "chunk" : "message", head.length, wrong.what()));
  }
}

void Scanner::unpack(const RecordHead& head) {
  if (head.op == Op::chunk) return unpack_chunk(batch_.raw, batch_);
  // writers never mix both, and no checksum protects the head of such a record
  if (has_chunks_) throw Malformed{"the file has its messages in chunks"};
  file_.read(record_at_, place_.length, batch_.raw);  // with its head
  batch_.records = batch_.raw;
}

void Scanner::keep_declared() {
  const std::size_t all{batch_.messages.size()};
  std::erase_if(batch_.messages,
                [&](const MessagePlace& message) { return !contents_.channels.contains(message.channel); });
  if (const std::size_t skipped{all - batch_.messages.size()}; skipped > 0) {
    damage_.messages_skipped += skipped;
    note(damage_, fmt::format("At byte {}: {} messages are skipped, whose channel is declared nowhere before.",
                              record_at_, skipped));
  }
  has_messages_ = !batch_.messages.empty();
  if (has_messages_) count();
}

void Scanner::count() {
  const auto [first, last]{std::ranges::minmax(batch_.messages, {}, &MessagePlace::log_time_ns)};
  place_.first_ns = first.log_time_ns;
  place_.last_ns = last.log_time_ns;
  contents_.first_ns =
      contents_.message_counts.empty() ? place_.first_ns : std::min(contents_.first_ns, place_.first_ns);
  contents_.last_ns = std::max(contents_.last_ns, place_.last_ns);
  std::set<std::uint16_t> channels;
  for (const MessagePlace& message : batch_.messages) {
    channels.insert(message.channel);
    ++contents_.message_counts[message.channel];
  }
  place_.channels.assign(channels.begin(), channels.end());
}

void Scanner::check_data_crc(const RecordHead& data_end) {
  std::uint32_t crc{~crc_};
  if (data_end.length >= sizeof(crc)) file_.read(at_, std::as_writable_bytes(std::span{&crc, 1}));
  if (crc == 0 || crc == crc_) return;
  note(damage_,
       fmt::format("The checksum of bytes 0 to {} is wrong: some bytes differ from the written ones, within the part "
                   "skipped or beside it.",
                   record_at_));
}

void Scanner::check_end() {
  is_done_ = true;
  try {
    if (read_summary(file_).data_end != at_) throw Malformed{"it begins at another byte than it says"};
  } catch (const Malformed& wrong) {
    note(damage_, fmt::format("The summary at byte {} cannot be used: {}. All before it was read.", at_, wrong.what()));
  }
}

void Scanner::stop(std::uint64_t at, const char* why) {
  is_done_ = true;
  note(damage_,
       fmt::format("The file can be read up to byte {} of {} only: {}. {} messages were read; whatever the last "
                   "{} bytes had is lost.",
                   at, file_.size(), why, messages_of(contents_), file_.size() - at));
}

}  // namespace stereogrid::mcap
