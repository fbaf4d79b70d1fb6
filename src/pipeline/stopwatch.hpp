// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <utility>

namespace stereogrid {

/// Milliseconds since the last call.
class Stopwatch {
 public:
  double lap() {
    const auto now{std::chrono::steady_clock::now()};
    return std::chrono::duration<double, std::milli>(now - std::exchange(last_, now)).count();
  }

 private:
  std::chrono::steady_clock::time_point last_{std::chrono::steady_clock::now()};
};

/// Adds the milliseconds of its lifetime to a sum.
class ScopedTimer {
 public:
  explicit ScopedTimer(double& sum_ms) : sum_ms_{sum_ms} {}
  ScopedTimer(const ScopedTimer&) = delete;
  ScopedTimer& operator=(const ScopedTimer&) = delete;
  ~ScopedTimer() { sum_ms_ += watch_.lap(); }

 private:
  double& sum_ms_;
  Stopwatch watch_;
};

}  // namespace stereogrid
