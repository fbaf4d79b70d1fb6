// SPDX-License-Identifier: Apache-2.0
#include "cli/console.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>  // NOLINT(modernize-deprecated-headers): pthread_sigmask
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <iterator>
#include <system_error>
#include <thread>

namespace stereogrid::app {
namespace {

std::size_t lines_in(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count(text, '\n'));
}

/// As before there was a thread: handlers run on the threads of the program, but a reader that has gone ends it.
sigset_t blocked_signals() {
  sigset_t signals{};
  sigfillset(&signals);
  sigdelset(&signals, SIGPIPE);
  return signals;
}

}  // namespace

void TextQueue::add(int descriptor, std::string text, Kind kind) {
  const std::lock_guard lock{mutex_};
  if (kind == Kind::lines) {
    waiting_line_bytes_ += text.size();
  } else {
    ++outputs_;
  }
  waiting_.push_back({descriptor, std::move(text), kind});
  drop_oldest_lines();
  if (!has_thread_) start();
  changed_.notify_all();
}

void TextQueue::start() {
  const sigset_t blocked{blocked_signals()};
  sigset_t before{};
  pthread_sigmask(SIG_BLOCK, &blocked, &before);
  try {
    std::thread{[this] { work(); }}.detach();
    has_thread_ = true;
  } catch (const std::system_error&) {  // too many threads: written here, and tried again with the next text
    while (!waiting_.empty()) {
      const Text text{take()};
      note_result(text, write(text));
    }
  }
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

void TextQueue::drop_oldest_lines() {
  for (auto oldest{waiting_.begin()}; waiting_line_bytes_ > most_line_bytes && oldest != std::prev(waiting_.end());) {
    if (oldest->kind == Kind::output) {
      ++oldest;
      continue;
    }
    dropped_ += lines_in(oldest->text);
    waiting_line_bytes_ -= oldest->text.size();
    oldest = waiting_.erase(oldest);
  }
}

TextQueue::Text TextQueue::take() {
  Text text{std::move(waiting_.front())};
  waiting_.pop_front();
  if (text.kind == Kind::output) return text;
  waiting_line_bytes_ -= text.text.size();
  if (dropped_ > 0) {
    text.text.insert(
        0, fmt::format("warning: {} lines were dropped: the reader of this log stalled\n", std::exchange(dropped_, 0)));
  }
  return text;
}

void TextQueue::work() {
  std::unique_lock lock{mutex_};
  for (;;) {
    changed_.wait(lock, [this] { return !waiting_.empty(); });
    const Text text{take()};
    is_writing_ = true;
    lock.unlock();
    const int error_number{write(text)};
    lock.lock();
    is_writing_ = false;
    note_result(text, error_number);
    changed_.notify_all();
  }
}

int TextQueue::write(const Text& text) {
  for (std::string_view rest{text.text}; !rest.empty();) {
    const ssize_t count{::write(text.descriptor, rest.data(), std::min<std::size_t>(rest.size(), PIPE_BUF))};
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && errno == EAGAIN) {  // another program has made it non-blocking
      pollfd wanted{text.descriptor, POLLOUT, 0};
      poll(&wanted, 1, -1);
      continue;
    }
    if (count < 0) return errno;
    rest.remove_prefix(static_cast<std::size_t>(count));
    ++written_pieces_;
  }
  return 0;
}

void TextQueue::note_result(const Text& text, int error_number) {
  if (text.kind == Kind::lines) return;
  --outputs_;
  if (output_error_ == 0) output_error_ = error_number;
}

bool TextQueue::is_empty() const {
  const std::lock_guard lock{mutex_};
  return waiting_.empty() && !is_writing_;
}

bool TextQueue::has_output() const {
  const std::lock_guard lock{mutex_};
  return outputs_ > 0;
}

bool TextQueue::drain(std::chrono::milliseconds patience) {
  std::unique_lock lock{mutex_};
  for (;;) {
    const std::uint64_t before{written_pieces_};
    if (changed_.wait_for(lock, patience, [this] { return waiting_.empty() && !is_writing_; })) return true;
    if (written_pieces_ == before) return false;
  }
}

int TextQueue::output_error() const {
  const std::lock_guard lock{mutex_};
  return output_error_;
}

}  // namespace stereogrid::app
