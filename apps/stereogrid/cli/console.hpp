// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/core.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

namespace stereogrid::app {

// Standard streams. Writing to them neither throws nor waits, so that a run continues without a reader, or with one
// that stalls: a thread writes the text. Errors on stdout are reported once, at the end.

/// Opens /dev/null for closed standard streams, so that no other file gets their numbers. Call it before anything else
/// is opened. False: not possible.
[[nodiscard]] bool open_standard_streams();

/// To stdout. Nothing of it is dropped.
void write_output(std::string_view text);
/// To stderr. Lines that wait for a stalled reader are dropped, the oldest first, and counted.
void write_error(std::string_view text);

/// True if all text for stderr is written.
[[nodiscard]] bool is_error_stream_ready();

/// From now on nothing waits for a reader that stalls for longer than a second: for programs that catch signals.
/// Without it, stdout waits for its reader, such as a pager.
void limit_waits();

/// Waits until all output is written.
void flush_output();
/// Waits until all text for stderr is written; a reader that stalls is not waited for.
void flush_errors();

/// To stdout.
template <class... Values>
void print(fmt::format_string<Values...> format, Values&&... values) {
  write_output(fmt::format(format, std::forward<Values>(values)...));
}

/// To stderr.
template <class... Values>
void log_on_stderr(fmt::format_string<Values...> format, Values&&... values) {
  write_error(fmt::format(format, std::forward<Values>(values)...));
}

/// Flushes stdout. Returns the reason if a write has failed, else "".
[[nodiscard]] std::string failed_output();
/// Flushes stdout, at the end of the program. Returns the reason if some output is lost, else "".
[[nodiscard]] std::string lost_output();

/// Width of the terminal in characters, 40 to 120: COLUMNS, that of stdout, or 80.
[[nodiscard]] std::size_t terminal_columns();

/// From now on, the log goes to stderr, in colours on a terminal.
void set_up_log();
/// Prints the reason for which the program called `name` ends to stderr.
void print_error(const char* name, const std::string& message);

/// From now on Ctrl-C (and SIGTERM) only ask to stop; a second one ends the program at once. So does SIGHUP, unless it
/// was ignored from the start; further ones change nothing.
void catch_interrupts();

/// Signal that requested a stop; 0: none.
[[nodiscard]] int interrupted();

/// Progress of a long job: a bar on a terminal, else a plain line at intervals. Writes to stderr; silent under --quiet.
class Progress {
 public:
  Progress(std::string label, std::size_t total);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  /// Wipes the bar.
  ~Progress();

  /// `done` of the total are finished.
  void update(std::size_t done);
  [[nodiscard]] double seconds() const;

 private:
  void draw_bar(std::size_t done);
  void print_line(std::size_t done);
  [[nodiscard]] std::string rate_and_rest(std::size_t done) const;

  std::string label_;
  std::size_t total_;
  bool silent_;
  bool terminal_;
  std::chrono::steady_clock::time_point start_;
  std::chrono::steady_clock::time_point last_shown_;
  std::size_t last_shown_done_{0};
};

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
