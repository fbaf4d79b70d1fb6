// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace stereogrid::app {

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

}  // namespace stereogrid::app
