// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "file.hpp"
#include "stereogrid/mcap/bag.hpp"

namespace stereogrid::mcap {

[[nodiscard]] std::unique_ptr<Bag> open_mcap_bag(const std::filesystem::path& path);
[[nodiscard]] std::unique_ptr<Bag> open_db3_bag(const std::filesystem::path& path);
[[nodiscard]] std::unique_ptr<Bag> open_folder_bag(const std::filesystem::path& path);

/// An .mcap or a .db3, by its first bytes.
[[nodiscard]] std::unique_ptr<Bag> open_unpacked_bag(const std::filesystem::path& path);
/// A file that unpacks to more times its size, and to more than `always_bytes`, is no recording, and would fill the
/// disk.
inline constexpr std::uint64_t most_growth{200};
/// The same compressed with zstd: unpacked into the folder of temporary files, where only the open file keeps it.
[[nodiscard]] std::unique_ptr<Bag> open_packed_bag(const std::filesystem::path& path,
                                                   std::uint64_t always_bytes = std::uint64_t{1} << 30);
/// Any of them.
[[nodiscard]] std::unique_ptr<Bag> open_file_bag(const std::filesystem::path& path);

/// Topics of a bag, distinct in name, type and encoding.
class TopicList {
 public:
  /// `file`: name in error messages.
  explicit TopicList(std::string file) : file_{std::move(file)} {}

  /// Index of the topic, which Message::channel has; a known topic gets its messages. Throws InputError: more than
  /// 65536 topics, or more than 256 MiB of text.
  std::uint16_t add(const Topic& topic);
  [[nodiscard]] const std::vector<Topic>& all() const { return topics_; }
  void count_message(std::uint16_t index) { ++topics_[index].message_count; }

 private:
  std::string file_;
  std::vector<Topic> topics_;
  std::map<std::tuple<std::string, std::string, std::string>, std::uint16_t> indices_;
  std::size_t text_bytes_{0};
};

/// Messages whose channels have other numbers outside: `numbers[channel]`.
class Renumbered : public MessageCursor {
 public:
  Renumbered(std::unique_ptr<MessageCursor> cursor, const std::vector<std::uint16_t>& numbers)
      : cursor_{std::move(cursor)}, numbers_{numbers} {}

  const Message* next() override {
    const Message* const message{cursor_->next()};
    if (message == nullptr) return nullptr;
    message_ = *message;
    message_.channel = numbers_[message->channel];
    return &message_;
  }

 private:
  std::unique_ptr<MessageCursor> cursor_;
  const std::vector<std::uint16_t>& numbers_;
  Message message_;
};

}  // namespace stereogrid::mcap
