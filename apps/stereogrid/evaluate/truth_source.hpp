// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "frame_stages.hpp"
#include "input.hpp"
#include "stereogrid/evaluation/labels.hpp"
#include "stereogrid/evaluation/obstacles.hpp"
#include "stereogrid/io/run_folder/frame_lines.hpp"
#include "stereogrid/truth.hpp"

namespace stereogrid::io {
class TruthReader;
}

namespace stereogrid::app {

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
