// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "file.hpp"
#include "format.hpp"
#include "stereogrid/mcap/reader.hpp"

namespace stereogrid::mcap {

/// Position of messages in a file: a chunk record, or a range of records outside of chunks.
struct Place {
  std::uint64_t offset{0}, length{0};
  bool is_chunk{true};
  std::uint64_t first_ns{0}, last_ns{0};  // range of log times
  std::vector<std::uint16_t> channels;    // channels of the messages; empty: unknown
};

struct MessagePlace {
  std::uint64_t log_time_ns{0}, offset{0}, size{0};  // position of the record's content in Batch::records
  std::uint16_t channel{0};
};

/// The records of one place, unpacked.
struct Batch {
  Bytes raw, unpacked;  // as in the file; and if that is compressed
  View records;         // in one of them
  std::vector<MessagePlace> messages;

  [[nodiscard]] Message message(const MessagePlace& place) const;
  [[nodiscard]] std::uint64_t memory_bytes() const;
};

/// A record's first bytes.
struct RecordHead {
  Op op;
  std::uint64_t length;  // length of the rest
};
[[nodiscard]] RecordHead head_at(View bytes);

/// The schema or channel of a record's content; other records declare nothing.
void declare(Op op, View content, Contents& contents);

/// Unpacks the content of a chunk record, which stands in `batch.raw`, into `batch.records`. Throws Malformed.
void unpack_chunk(View content, Batch& batch);

/// Finds the messages of `batch.records`, and declares in `contents` what they do. Throws Malformed.
void find_messages(Batch& batch, Contents& contents);

/// Reads and unpacks. Throws Malformed; InputError where the disk cannot be read.
void load(const FileInput& file, const Place& place, Batch& batch);

/// Adds a message, if there is room.
void note(Damage& damage, std::string sentence);

/// Summary section at the end of a file.
struct SummarySection {
  std::uint64_t data_end{0};  // end of the data section: start of the summary or the footer
  bool is_complete{false};    // all messages are indexed
  Contents contents;          // without header
  std::vector<Place> chunks;  // in the order of the file
};

/// Throws InputError: no MCAP file.
void require_mcap(const FileInput& file);

/// Profile and library. Throws Malformed.
void read_header(const FileInput& file, Contents& contents);

/// Throws Malformed where there is no whole end of a file, or what it says contradicts itself.
[[nodiscard]] SummarySection read_summary(const FileInput& file);

/// Goes through a file from its beginning, place by place, checks all that can be checked, and finds out what it holds.
class Scanner {
 public:
  /// Throws InputError: no MCAP.
  explicit Scanner(const FileInput& file);

  /// To the next place that has messages; false: there is none.
  bool next();
  /// Messages of that place, all of declared channels.
  [[nodiscard]] const Batch& batch() const { return batch_; }
  [[nodiscard]] const Place& place() const { return place_; }

  /// So far.
  [[nodiscard]] const Contents& contents() const { return contents_; }
  [[nodiscard]] const Damage& damage() const { return damage_; }

 private:
  /// The head of the record at at_; false: the file ends here, or earlier than it should.
  bool read_head(RecordHead& head);
  /// Reads the record's content into memory; false: too much, passed over.
  bool read_content(const RecordHead& head);
  void pass_over(std::uint64_t length);
  void take(const RecordHead& head);
  void take_messages(const RecordHead& head);
  void unpack(const RecordHead& head);
  void keep_declared();
  void count();
  void check_data_crc(const RecordHead& data_end);
  void check_end();
  void stop(std::uint64_t at, const char* why);

  const FileInput& file_;
  std::uint64_t at_;            // the next record
  std::uint64_t record_at_{0};  // the one that is read
  std::uint32_t crc_;           // checksum of all bytes before at_
  bool is_done_{false};
  Batch batch_;
  Place place_;
  Contents contents_;
  Damage damage_;
  bool has_messages_{false};
  bool has_chunks_{false};
};

}  // namespace stereogrid::mcap
