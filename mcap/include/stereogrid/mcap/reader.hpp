// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "stereogrid/export.hpp"
#include "stereogrid/mcap/records.hpp"

namespace stereogrid::mcap {

/// Size limit of a chunk, unpacked or not, and of other records; larger ones are skipped.
inline constexpr std::uint64_t largest_chunk_bytes{std::uint64_t{512} << 20};
/// Chunks whose times overlap are unpacked at the same time; more throws InputError.
inline constexpr std::uint64_t most_unpacked_bytes{std::uint64_t{1} << 30};

/// Maximum size of a file's schemas and channels; a reader skips the chunk with the rest.
inline constexpr std::uint64_t most_declared_bytes{std::uint64_t{64} << 20};

/// Declarations and message counts of a file.
struct Contents {
  std::string profile, library;
  std::map<std::uint16_t, Schema> schemas;
  std::map<std::uint16_t, Channel> channels;
  std::map<std::uint16_t, std::uint64_t> message_counts;  ///< by channel; one without messages may be missing
  std::uint64_t declared_bytes{0};                        ///< bytes of schemas and channels
  std::uint64_t first_ns{0}, last_ns{0};                  ///< log times of the first and last message; 0: there is none
};

/// Opens an MCAP file and gives its messages in the order of their log times. Where the file has no summary or not one
/// that fits, as after a crash, it is read once from its beginning to find out what it holds.
class STEREOGRID_EXPORT Reader {
 public:
  /// Throws InputError: no such file, not readable, no MCAP.
  explicit Reader(const std::filesystem::path& path);
  Reader(Reader&&) noexcept;
  Reader& operator=(Reader&&) noexcept;
  ~Reader();

  [[nodiscard]] const Contents& contents() const;
  /// By the file's own summary; false: what it holds had to be found out.
  [[nodiscard]] bool is_indexed() const;
  /// So far: opening finds some, messages() the rest.
  [[nodiscard]] const Damage& damage() const;

  /// Messages of equal time come as they stand in the file. The cursor may outlive the reader; several may be used at
  /// a time, in one thread. What it cannot unpack it skips (damage()).
  [[nodiscard]] std::unique_ptr<MessageCursor> messages(const Selection& selection = {}) const;

 private:
  struct STEREOGRID_HIDDEN State;
  std::shared_ptr<State> state_;
};

/// Reads an MCAP file from its beginning to its end, and gives the messages as they stand there. It needs no summary:
/// of a file that was cut off it gives every message of every whole chunk. Checks every checksum.
class STEREOGRID_EXPORT StreamReader : public MessageCursor {
 public:
  /// Throws InputError: no such file, not readable, no MCAP.
  explicit StreamReader(const std::filesystem::path& path);
  ~StreamReader() override;

  const Message* next() override;
  /// Declarations and counts so far.
  [[nodiscard]] const Contents& contents() const;
  /// Damage so far; complete after the last message.
  [[nodiscard]] const Damage& damage() const;

 private:
  class STEREOGRID_HIDDEN Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace stereogrid::mcap
