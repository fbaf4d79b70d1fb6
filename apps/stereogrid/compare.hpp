// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "config_options.hpp"
#include "input.hpp"
#include "stereogrid/evaluation/scores.hpp"
#include "truth_source.hpp"

namespace stereogrid::app {

struct CompareOptions {
  InputOptions input;
  ConfigOptions config;
  std::string frames;
  TruthKind truth{TruthKind::automatic};
  bool hold_out{false};
  std::vector<std::string> only;
  int threads{0};
  std::string json;
  std::string pictures;
};

/// What a method has made of the input.
struct ComparedMethod {
  std::string name;
  std::string title;
  bool over_time{false};
  evaluation::Scores scores;
  std::vector<double> milliseconds;  ///< of every frame, from disparities and ground to the grid
};

struct Comparison {
  std::vector<ComparedMethod> methods;
  std::size_t frames{0};
  std::size_t frames_with_truth{0};
};

/// `stereogrid compare`: prints the table, writes the files asked for. Returns the exit code; throws ConfigError,
/// InputError, DeviceError.
[[nodiscard]] int compare(const CompareOptions& options);

}  // namespace stereogrid::app
