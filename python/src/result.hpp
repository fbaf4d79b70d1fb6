// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "stereogrid/result.hpp"

namespace stereogrid::python {

/// Results whose memory is used again. A result that Python releases returns its memory here, so that a loop which
/// keeps none allocates as little as the C++ loop does.
class ResultPool {
 public:
  [[nodiscard]] std::unique_ptr<FrameResult> take();
  void give_back(std::unique_ptr<FrameResult> result) noexcept;

 private:
  static constexpr std::size_t capacity_{4};
  std::mutex mutex_;
  std::vector<std::unique_ptr<FrameResult>> free_;
};

/// Result of a frame that Python owns. Views point into it and keep it alive; no later frame changes it.
struct Result {
  explicit Result(std::shared_ptr<ResultPool> results) : pool{std::move(results)}, memory{pool->take()} {}
  Result(const Result&) = delete;
  Result& operator=(const Result&) = delete;
  ~Result() { pool->give_back(std::move(memory)); }

  std::shared_ptr<ResultPool> pool;
  std::unique_ptr<FrameResult> memory;
  FrameResult& data{*memory};
  std::string name;
  std::int64_t index{0};
  std::int64_t stamp_ns{0};
};

/// A Result in Python.
using ResultObject = nanobind::typed<nanobind::object, Result>;

}  // namespace stereogrid::python
