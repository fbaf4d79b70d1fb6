// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <chrono>
#include <optional>
#include <string>
#include <vector>

namespace stereogrid::app::testing {

/// A program running beside the test; silent.
class Process {
 public:
  /// stereogrid with `words` of its command line. `ignored`: a signal that it is started with ignored, as nohup does;
  /// 0: none.
  explicit Process(const std::vector<std::string>& words, int ignored = 0);
  /// Another program, searched in PATH.
  Process(const std::string& program, const std::vector<std::string>& words, int ignored = 0);
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  Process(Process&& other) noexcept;
  /// Kills it where it still runs.
  ~Process();

  [[nodiscard]] pid_t id() const { return id_; }
  void send(int signal) const;
  /// Waits for its end: the exit code, or 128 and the signal that killed it, as a shell says it.
  int wait();
  /// The same; none: it has not ended within `limit`.
  std::optional<int> wait_for(std::chrono::milliseconds limit);
  /// Waits until it has a handler for SIGTERM.
  void wait_until_it_catches_signals() const;

 private:
  pid_t id_{-1};
};

/// Runs a line of sh; its exit code.
int shell(const std::string& line);

}  // namespace stereogrid::app::testing
