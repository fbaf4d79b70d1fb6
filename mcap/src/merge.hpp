// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <tuple>
#include <utility>
#include <vector>

#include "stereogrid/mcap/records.hpp"

namespace stereogrid::mcap {

/// Messages of several sources in the order of their log times, of equal ones in the order of the sources. Each source
/// gives its own in that order, and is opened no earlier than its first message is due.
class MergeByTime : public MessageCursor {
 public:
  using Open = std::function<std::unique_ptr<MessageCursor>(std::size_t source)>;

  /// `first_ns`: of each source, a time no later than its first message.
  MergeByTime(const std::vector<std::uint64_t>& first_ns, Open open) : open_{std::move(open)} {
    for (std::size_t i{0}; i < first_ns.size(); ++i) unopened_.push_back({first_ns[i], i});
    std::ranges::sort(unopened_, [](const Source& a, const Source& b) {
      return std::tie(a.first_ns, a.index) > std::tie(b.first_ns, b.index);
    });
  }

  const Message* next() override {
    if (given_.cursor) enter(given_.index, std::move(given_.cursor));
    while (!unopened_.empty() && (heap_.empty() || unopened_.back().first_ns <= heap_.front().message->log_time_ns)) {
      const std::size_t index{unopened_.back().index};
      unopened_.pop_back();
      enter(index, open_(index));
    }
    if (heap_.empty()) return nullptr;
    std::ranges::pop_heap(heap_, is_later);
    given_ = std::move(heap_.back());
    heap_.pop_back();
    return given_.message;
  }

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

  static bool is_later(const Waiting& a, const Waiting& b) {
    return std::tie(a.message->log_time_ns, a.index) > std::tie(b.message->log_time_ns, b.index);
  }

  void enter(std::size_t index, std::unique_ptr<MessageCursor> cursor) {
    const Message* const message{cursor ? cursor->next() : nullptr};
    if (message == nullptr) return;
    heap_.push_back({message, index, std::move(cursor)});
    std::ranges::push_heap(heap_, is_later);
  }

  Open open_;
  std::vector<Source> unopened_;  // the next one last
  std::vector<Waiting> heap_;     // the earliest first
  Waiting given_{};               // whose message was given last
};

}  // namespace stereogrid::mcap
