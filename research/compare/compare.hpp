// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "cli/config_options.hpp"
#include "evaluate/output.hpp"
#include "evaluate/truth_source.hpp"
#include "input.hpp"

namespace stereogrid::research {

struct CompareOptions {
  app::InputOptions input;
  app::ConfigOptions config;
  std::string frames;
  app::TruthKind truth{app::TruthKind::automatic};
  bool hold_out{false};
  std::string matcher{"own"};
  std::vector<std::string> only;
  int threads{0};
  std::optional<double> camera_height_m;
  std::string json;
  std::string pictures;
  std::string grids;
};

/// Results of a method.
struct ComparedMethod {
  std::string title;
  bool over_time{false};
  app::Series series;
  std::vector<double> milliseconds;  ///< time of every frame, from disparities and ground to the grid
};

struct Comparison {
  std::vector<ComparedMethod> methods;
  std::size_t frames{0};
  std::size_t frames_with_truth{0};
};

/// Prints the table and writes the requested files. Returns the exit code; throws ConfigError, InputError, DeviceError.
[[nodiscard]] int compare(const CompareOptions& options);

}  // namespace stereogrid::research
