// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "../io/support.hpp"
#include "stereogrid/mcap/reader.hpp"
#include "stereogrid/mcap/writer.hpp"

namespace stereogrid::mcap::testing {

namespace fs = std::filesystem;
using io::testing::expect_error;
using io::testing::TemporaryFolder;

/// A new file, where one of this name was, too: rewriting that one would wait for the disk.
void put(const fs::path& path, std::string_view bytes);

/// The specification's forms, written once more.
[[nodiscard]] std::string number(std::uint64_t value, int bytes);
[[nodiscard]] std::string text(std::string_view text);  ///< a string, an array or a map: its length before it
[[nodiscard]] std::string record(int op, std::string_view content);
[[nodiscard]] std::string message_record(int channel, int sequence, std::uint64_t log_ns, std::uint64_t publish_ns,
                                         std::string_view data);
[[nodiscard]] std::uint32_t crc(std::string_view bytes);
inline const std::string magic{"\x89MCAP0\r\n"};

/// A message as it is compared.
struct Said {
  std::string topic;
  std::uint32_t sequence{0};
  std::uint64_t log_ns{0}, publish_ns{0};
  std::string data;

  bool operator==(const Said&) const = default;
};

[[nodiscard]] std::string string_of(std::span<const std::byte> bytes);
inline std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span{text});
}
std::ostream& operator<<(std::ostream& out, const Said& said);

/// Three channels of two types, `count` messages of random times within a second around i · `step_ns`, of random sizes.
[[nodiscard]] std::vector<Said> random_messages(unsigned seed, int count, std::uint64_t step_ns = 10'000'000);

/// Writes them, and closes the file if `closes`.
void write_messages(const fs::path& path, const std::vector<Said>& messages, const WriterOptions& options = {});

[[nodiscard]] std::vector<Said> read_all(const Reader& reader, const Selection& selection = {});
/// All that a stream gives, and its damage.
[[nodiscard]] std::pair<std::vector<Said>, Damage> stream_all(const fs::path& path);
/// Stably sorted by log time.
[[nodiscard]] std::vector<Said> in_time(std::vector<Said> messages);

}  // namespace stereogrid::mcap::testing
