// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>

#include "evaluate/output.hpp"

namespace stereogrid::app {

struct EvaluateOptions {
  std::string run;
  std::string input;
  std::string truth;
  std::optional<double> camera_height_m;
  std::string json;
  std::string html;
};

/// Receives the number of scored frames and of all before each frame.
using NotifyProgress = std::function<void(std::size_t done, std::size_t total)>;

/// Scores a run. Throws InputError: no run, no truth, none of these frames.
[[nodiscard]] Evaluation evaluate(const EvaluateOptions& options, const NotifyProgress& notify = {});

}  // namespace stereogrid::app
