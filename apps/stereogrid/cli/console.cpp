// SPDX-License-Identifier: Apache-2.0
#include "cli/console.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spdlog/details/os.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <memory>
#include <system_error>

#include "stereogrid/printable.hpp"

namespace stereogrid::app {
namespace {

constexpr std::chrono::seconds patience{1};

// NOLINTNEXTLINE(cppcoreguidelines-avoid-non-const-global-variables)
std::atomic<bool> are_waits_limited{false};

// errno of closing stdout. NOLINTNEXTLINE(cppcoreguidelines-avoid-non-const-global-variables)
int closing_error{0};

bool are_same_file(int one, int other) {
  struct stat first {};
  struct stat second {};
  return fstat(one, &first) == 0 && fstat(other, &second) == 0 && first.st_dev == second.st_dev &&
         first.st_ino == second.st_ino;
}

TextQueue& errors() {
  static TextQueue& queue{*new TextQueue};
  return queue;
}

/// One queue for both streams where they are one terminal or pipe, so that their texts stay in order.
TextQueue& output() {
  static TextQueue& queue{are_same_file(STDOUT_FILENO, STDERR_FILENO) ? errors() : *new TextQueue};
  return queue;
}

std::string failure_text() {
  const int error_number{output().output_error() != 0 ? output().output_error() : closing_error};
  return error_number == 0 ? "" : std::generic_category().message(error_number);
}

// a signal handler has nothing else to write to
// NOLINTNEXTLINE(cppcoreguidelines-avoid-non-const-global-variables)
volatile std::sig_atomic_t received_signal{0};

extern "C" void note_signal(int signal) {
  received_signal = signal;
}

constexpr std::size_t longest_message{16'384};

constexpr const char* wipe_line{"\r\033[K"};  // removes the progress bar

constexpr std::string_view color_of(spdlog::level::level_enum level) {
  switch (level) {
    case spdlog::level::info:
      return "\033[32m";  // green
    case spdlog::level::warn:
      return "\033[33m\033[1m";  // yellow, bold
    case spdlog::level::err:
    case spdlog::level::critical:
      return "\033[31m\033[1m";  // red, bold
    default:
      return "\033[36m";  // cyan
  }
}

/// To stderr, which nothing waits for (console.hpp). Lines may quote names of files and topics.
class Log final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  explicit Log(bool has_colors) : has_colors_{has_colors} {}

 private:
  void sink_it_(const spdlog::details::log_msg& message) override {
    const std::string text{printable_lines({message.payload.data(), message.payload.size()}, longest_message)};
    spdlog::details::log_msg shown{message};
    shown.payload = text;
    spdlog::memory_buf_t buffer;
    formatter_->format(shown, buffer);
    std::string line{buffer.data(), buffer.size()};
    if (has_colors_ && shown.color_range_end > shown.color_range_start) {
      line.insert(shown.color_range_end, "\033[m");
      line.insert(shown.color_range_start, color_of(message.level));
    }
    write_error(line);
  }
  void flush_() override { flush_errors(); }

  bool has_colors_;
};

}  // namespace

bool open_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(stream, F_GETFD) >= 0 || errno != EBADF) continue;
    if (open("/dev/null", O_RDWR) != stream) return false;  // the lowest number that is free
  }
  return true;
}

void write_output(std::string_view text) {
  output().add(STDOUT_FILENO, std::string{text}, TextQueue::Kind::output);
}

void write_error(std::string_view text) {
  errors().add(STDERR_FILENO, std::string{text}, TextQueue::Kind::lines);
}

bool is_error_stream_ready() {
  return errors().is_empty();
}

void limit_waits() {
  are_waits_limited = true;
}

void flush_output() {
  while (!output().drain(patience) && output().has_output() && !are_waits_limited) {
  }
}

void flush_errors() {
  static_cast<void>(errors().drain(patience));
}

std::string failed_output() {
  flush_output();
  return failure_text();
}

std::string lost_output() {
  flush_output();
  if (output().has_output()) return "its reader has stalled";
  // network file systems report a full disk only when a file is closed; the original has to stay open for other writers
  const int copy{dup(STDOUT_FILENO)};
  if (copy >= 0 && close(copy) != 0 && errno != EINTR) closing_error = errno;
  return failure_text();
}

void catch_interrupts() {
  limit_waits();
  struct sigaction action {};
  action.sa_handler = note_signal;
  action.sa_flags = SA_RESTART | static_cast<int>(SA_RESETHAND);
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  // the terminal has gone: shell and system both may say so. nohup ignores it, and means it.
  struct sigaction inherited {};
  sigaction(SIGHUP, nullptr, &inherited);
  action.sa_flags = SA_RESTART;
  if (inherited.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, nullptr);
}

int interrupted() {
  return received_signal;
}

std::size_t terminal_columns() {
  constexpr long least{40};
  constexpr long most{120};
  constexpr long usual{80};
  const char* const variable{std::getenv("COLUMNS")};  // NOLINT(concurrency-mt-unsafe): nothing sets variables
  long columns{variable == nullptr ? 0 : std::atol(variable)};
  winsize window{};
  if (columns <= 0 && ioctl(STDOUT_FILENO, TIOCGWINSZ, &window) == 0) columns = window.ws_col;
  return static_cast<std::size_t>(std::clamp(columns <= 0 ? usual : columns, least, most));
}

void set_up_log() {
  const bool terminal{isatty(STDERR_FILENO) == 1};
  const bool has_colors{terminal && spdlog::details::os::is_color_terminal()};
  auto log{std::make_shared<spdlog::logger>("stereogrid", std::make_shared<Log>(has_colors))};
  log->set_pattern(fmt::format("{}%^%l%$: %v", terminal ? wipe_line : ""));
  spdlog::set_default_logger(std::move(log));
}

void print_error(const char* name, const std::string& message) {
  log_on_stderr("{}{}: {}\n", isatty(STDERR_FILENO) == 1 ? wipe_line : "", name,
                printable_lines(message, longest_message));
}

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t bar_width{30};
constexpr double bar_interval_s{0.1};
constexpr double line_interval_s{2};
constexpr double line_interval_max_s{30};

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::string duration_text(double seconds) {
  const auto whole{static_cast<long>(seconds + 0.5)};
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{}:{:02} min", whole / 60, whole % 60);
  return fmt::format("{}:{:02} h", whole / 3600, whole / 60 % 60);
}

}  // namespace

Progress::Progress(std::string label, std::size_t total)
    : label_{std::move(label)},
      total_{std::max<std::size_t>(1, total)},
      silent_{!spdlog::should_log(spdlog::level::info)},
      terminal_{isatty(STDERR_FILENO) == 1},
      start_{Clock::now()},
      last_shown_{start_} {}

Progress::~Progress() {
  if (!silent_ && terminal_) write_error("\r\033[K");
}

double Progress::seconds() const {
  return seconds_since(start_);
}

void Progress::update(std::size_t done) {
  if (silent_) return;
  const double since{seconds_since(last_shown_)};
  if (terminal_) {
    if ((since < bar_interval_s && done < total_) || !is_error_stream_ready()) return;
    draw_bar(done);
  } else {
    const bool moved{(done - last_shown_done_) * 10 >= total_};
    if (since < line_interval_s || (!moved && since < line_interval_max_s)) return;
    print_line(done);
  }
  last_shown_ = Clock::now();
  last_shown_done_ = done;
}

void Progress::draw_bar(std::size_t done) {
  const std::size_t full{std::min(bar_width, done * bar_width / total_)};
  std::string bar;
  for (std::size_t i{0}; i < bar_width; ++i) bar += i < full ? "█" : "░";
  log_on_stderr("\r\033[K{} {} {}/{}{}", label_, bar, done, total_, rate_and_rest(done));
}

void Progress::print_line(std::size_t done) {
  log_on_stderr("{} {}/{} ({} %){}\n", label_, done, total_, done * 100 / total_, rate_and_rest(done));
}

std::string Progress::rate_and_rest(std::size_t done) const {
  const double elapsed{seconds()};
  if (done == 0 || elapsed <= 0) return {};
  const double rate{static_cast<double>(done) / elapsed};
  const double rest_s{static_cast<double>(total_ - std::min(done, total_)) / rate};
  return fmt::format(", {:.1f} frames/s, {} left", rate, duration_text(rest_s));
}

}  // namespace stereogrid::app
