// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "frame_stages.hpp"
#include "input.hpp"
#include "stereogrid/evaluation/labels.hpp"
#include "stereogrid/evaluation/motion.hpp"
#include "stereogrid/evaluation/obstacles.hpp"
#include "stereogrid/evaluation/scores.hpp"
#include "stereogrid/evaluation/terrain.hpp"
#include "stereogrid/io/run_folder/frame_lines.hpp"
#include "stereogrid/truth.hpp"

namespace stereogrid::io {
class TruthReader;
}

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

/// `objects`: nothing is known of the cells.
enum class TruthKind { automatic, lidar, exact, objects };

/// Truth of the grids of an input: its lidar sweeps, or the exact truth of a scene or a rendered drive.
class TruthSource {
 public:
  /// `automatic`: exact truth if there is some, else lidar. Throws InputError if the input lacks the requested truth;
  /// the message names the available one. `camera_height_m`: start of the search for the lidar's road; none: the height
  /// estimated by a run, else KITTI's.
  TruthSource(Input input, TruthKind kind, std::optional<double> camera_height_m = std::nullopt);
  ~TruthSource();

  [[nodiscard]] const Input& input() const { return input_; }
  /// lidar, exact or objects.
  [[nodiscard]] TruthKind kind() const { return kind_; }
  /// Grid of the exact truth.
  [[nodiscard]] const TruthGrid& grid() const { return truth_grid_; }

  /// The frames of exact truth, in their order.
  [[nodiscard]] std::vector<std::string> exact_names() const;

  /// A frame's labels; `truth` is set where the truth is exact.
  struct FrameLabels {
    evaluation::Labels labels;
    std::optional<FrameTruth> truth;
  };
  /// None: nothing is known about a frame of this name. `rig`: how the camera was mounted, by which the lidar's points
  /// are placed in the vehicle frame. Throws InputError.
  [[nodiscard]] std::optional<FrameLabels> frame(const std::string& name, const GridGeometry& grid,
                                                 const Rig& rig) const;

 private:
  void check_lidar() const;
  /// Height at which the search for the lidar's road starts, below a camera with the extrinsics of `rig`.
  [[nodiscard]] double lidar_road_m(const Rig& rig) const;
  [[nodiscard]] bool has_exact() const;
  [[nodiscard]] std::optional<FrameTruth> exact(const std::string& name) const;
  [[nodiscard]] std::optional<evaluation::Labels> lidar(const std::string& name, const GridGeometry& grid,
                                                        const Rig& rig) const;

  Input input_;
  TruthKind kind_;
  std::optional<double> camera_height_m_;
  Sweeps sweeps_;
  std::map<std::string, std::size_t> places_;  // frames of the input
  std::unique_ptr<io::TruthReader> reader_;
  TruthGrid truth_grid_;
};

/// True if the drive has labelled objects in its own file (objects.jsonl).
[[nodiscard]] bool has_object_labels(const Input& input);

/// Truth of obstacles of an input: exact truth, or the drive's labelled boxes.
class ObstacleSource {
 public:
  /// Throws InputError where labels are damaged. `truth` must outlive this.
  explicit ObstacleSource(const TruthSource& truth);

  /// True if any frame has truth.
  [[nodiscard]] bool exists() const { return !places_.empty(); }
  /// "exact truth" or "labelled boxes".
  [[nodiscard]] std::string name() const;
  /// None: nothing is known of a frame of this name, or it lies within the first second. `known`: the frame's cells.
  [[nodiscard]] std::optional<evaluation::ObstacleTruth> frame(
      const std::string& name, const std::optional<TruthSource::FrameLabels>& known) const;

 private:
  const TruthSource& truth_;
  std::map<std::string, std::size_t> places_;  // frames with truth
  std::vector<std::vector<LabelledObject>> labels_;
};

}  // namespace stereogrid::app
