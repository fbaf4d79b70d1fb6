// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/config_options.hpp"
#include "compare/compare.hpp"
#include "evaluate/output.hpp"
#include "evaluate/truth_source.hpp"
#include "input.hpp"
#include "stereogrid/evaluation/labels.hpp"
#include "stereogrid/io/image_file.hpp"

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

struct NamedGrid {
  std::string name;
  std::string title;
  Image<float> occupancy;
};

/// The camera image, and below it the truth and every method's grid from above: white free, black occupied, grey
/// unknown; in the truth grey is not scored and red is a partly hidden obstacle.
[[nodiscard]] io::RgbImage draw_comparison(const Image<std::uint8_t>& left, const evaluation::Labels& labels,
                                           const std::vector<NamedGrid>& grids);

/// A line per method, 3–20 m.
void print_table(const Comparison& comparison);

/// JSON of the evaluations, with each method's title and time. `about`: see Evaluation.
[[nodiscard]] nlohmann::ordered_json json_of(const Comparison& comparison,
                                             const std::vector<std::pair<std::string, std::string>>& about);

}  // namespace stereogrid::research
