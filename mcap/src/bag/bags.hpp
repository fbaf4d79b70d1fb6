// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
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
/// The same compressed with zstd: unpacked into the folder of temporary files, where only the open file keeps it.
[[nodiscard]] std::unique_ptr<Bag> open_packed_bag(const std::filesystem::path& path);
/// Any of them.
[[nodiscard]] std::unique_ptr<Bag> open_file_bag(const std::filesystem::path& path);

/// The topic of this name, type and encoding among `topics`, where it is added if it is new: its index, which is what
/// Message::channel can have. Throws std::length_error where it cannot.
std::uint16_t index_of(const Topic& topic, std::vector<Topic>& topics);

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
