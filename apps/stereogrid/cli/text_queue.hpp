// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string>

namespace stereogrid::app {

/// Text on its way to a file, such as a terminal or a pipe, whose reader may stall. A thread of its own writes it, so
/// that add() never waits. The thread cannot be ended while the reader stalls: a queue is never destroyed.
class TextQueue {
 public:
  /// Maximum size of the lines that wait; the oldest are dropped beyond it, and a line says how many.
  static constexpr std::size_t most_line_bytes{std::size_t{1} << 18};

  enum class Kind {
    lines,   ///< dropped where too many wait
    output,  ///< never dropped
  };

  TextQueue() = default;
  TextQueue(const TextQueue&) = delete;
  TextQueue& operator=(const TextQueue&) = delete;
  ~TextQueue() = delete;

  void add(int descriptor, std::string text, Kind kind);

  [[nodiscard]] bool is_empty() const;
  /// True if there is output that is not written.
  [[nodiscard]] bool has_output() const;

  /// Waits until everything is written. Returns false if nothing was written for `patience`.
  bool drain(std::chrono::milliseconds patience);

  /// errno of the first failed write of output; 0: none.
  [[nodiscard]] int output_error() const;

 private:
  struct Text {
    int descriptor{-1};
    std::string text;
    Kind kind{Kind::lines};
  };

  void start();
  void work();
  void drop_oldest_lines();
  [[nodiscard]] Text take();
  [[nodiscard]] int write(const Text& text);
  void note_result(const Text& text, int error_number);

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Text> waiting_;
  std::size_t waiting_line_bytes_{0};
  std::size_t outputs_{0};  ///< number of those that are not written
  std::size_t dropped_{0};
  bool has_thread_{false};
  bool is_writing_{false};
  int output_error_{0};
  std::atomic<std::uint64_t> written_pieces_{0};
};

}  // namespace stereogrid::app
