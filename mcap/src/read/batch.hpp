// SPDX-FileCopyrightText: 2026 The stereogrid authors
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

}  // namespace stereogrid::mcap
