// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "stereogrid/mcap/records.hpp"

namespace stereogrid::mcap {

/// Messages of several sources in the order of their log times, of equal ones in the order of the sources. Each source
/// gives its own in that order, and is opened no earlier than its first message is due.
class MergeByTime : public MessageCursor {
 public:
  using Open = std::function<std::unique_ptr<MessageCursor>(std::size_t source)>;

  /// `first_ns`: of each source, a time no later than its first message.
  MergeByTime(const std::vector<std::uint64_t>& first_ns, Open open);

  const Message* next() override;

 private:
  struct Source {
    std::uint64_t first_ns;
    std::size_t index;
  };
  struct Waiting {
    const Message* message;
    std::size_t index;
    std::unique_ptr<MessageCursor> cursor;
  };

  static bool is_later(const Waiting& a, const Waiting& b);
  void enter(std::size_t index, std::unique_ptr<MessageCursor> cursor);

  Open open_;
  std::vector<Source> unopened_;  // the next one last
  std::vector<Waiting> heap_;     // the earliest first
  Waiting given_{};               // whose message was given last
};

}  // namespace stereogrid::mcap
