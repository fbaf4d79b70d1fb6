// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "stereogrid/evaluation/motion.hpp"
#include "stereogrid/evaluation/obstacles.hpp"
#include "stereogrid/evaluation/scores.hpp"
#include "stereogrid/evaluation/terrain.hpp"

namespace stereogrid::app {

/// Grids of one kind over a drive, and how good they are.
struct Series {
  std::string name;
  evaluation::Scores scores;
  std::optional<evaluation::MotionScores> motion{};
  evaluation::TerrainScores terrain{};  ///< empty without terrain truth
  evaluation::WitnessScores witness{};  ///< empty without witnesses
};

/// Result and sources of an evaluation.
struct Evaluation {
  std::vector<std::pair<std::string, std::string>> about;  ///< such as {"run", "runs/0009"}
  std::vector<Series> series;
  std::optional<evaluation::ObstacleSummary> obstacles{};  ///< none: nothing to score them against
};

/// Every figure with its interval, and what the report draws (docs/evaluation.md).
[[nodiscard]] nlohmann::ordered_json json_of(const Evaluation& evaluation);

/// "terrain" of a series, and its part of the table.
[[nodiscard]] nlohmann::ordered_json json_of(const evaluation::TerrainSummary& summary);
[[nodiscard]] std::string terrain_table_of(const nlohmann::ordered_json& terrain);

/// A table for the terminal, from json_of.
[[nodiscard]] std::string table_of(const nlohmann::ordered_json& evaluation);

/// "3–20 m" as a key: "3-20"; "3-20 clear" without hidden ground.
[[nodiscard]] std::string key_of(evaluation::Band band);

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
