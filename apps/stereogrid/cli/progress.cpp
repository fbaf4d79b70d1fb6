// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "cli/progress.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>

#include "cli/console.hpp"

namespace stereogrid::app {
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
