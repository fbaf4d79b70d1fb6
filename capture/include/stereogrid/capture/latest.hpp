// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <utility>

namespace stereogrid::capture {

/// Hands values from threads that never wait to one that does: only the newest waits.
template <class T>
class Latest {
 public:
  void put(T value) {
    const std::scoped_lock lock{mutex_};
    if (waiting_) ++replaced_;
    waiting_ = std::move(value);
    changed_.notify_one();
  }

  void end() {
    const std::scoped_lock lock{mutex_};
    has_ended_ = true;
    changed_.notify_one();
  }

  [[nodiscard]] std::optional<T> take(std::chrono::milliseconds patience) {
    std::unique_lock lock{mutex_};
    changed_.wait_for(lock, patience, [this] { return waiting_ || has_ended_; });
    return std::exchange(waiting_, std::nullopt);
  }

  [[nodiscard]] bool has_ended() const {
    const std::scoped_lock lock{mutex_};
    return has_ended_ && !waiting_;
  }

  /// Number of values replaced before they were taken.
  [[nodiscard]] std::int64_t replaced() const {
    const std::scoped_lock lock{mutex_};
    return replaced_;
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<T> waiting_;
  std::int64_t replaced_{0};
  bool has_ended_{false};
};

}  // namespace stereogrid::capture
