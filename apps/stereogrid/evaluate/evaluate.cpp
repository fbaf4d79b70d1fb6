// SPDX-License-Identifier: Apache-2.0
#include "evaluate/output.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "stereogrid/error.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/io/run_folder/run_reader.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::app {
namespace {

namespace fs = std::filesystem;

bool has_cell_truth(const Input& input) {
  return input.scene != nullptr || input.recording->has_truth() || Sweeps{input.recording}.exist();
}

InputOptions input_options(const EvaluateOptions& options, const io::RunReader& run) {
  const io::RunInput& from{run.input()};
  if (options.input.starts_with("scene:")) return {.paths = {options.input}};
  if (!options.input.empty()) return {.paths = {options.input}, .poses = "none", .cameras = from.cameras};
  for (const std::string& path : from.paths) {
    if (path.starts_with("scene:") || io::is_there(path)) continue;
    throw InputError{path, "is not there any more; the run was made from it.",
                     "Say where it is now: stereogrid evaluate " + options.run + " INPUT."};
  }
  // the run's own poses stand in its frames; where the input's are does not matter any more
  return {.paths = from.paths,
          .calibration = from.calibration,
          .poses = from.kind == "scene" ? "" : "none",
          .disparities = from.disparities,
          .cameras = from.cameras};
}

TruthKind kind_of(const std::string& truth, const Input& input) {
  if (truth.empty()) {
    return !has_cell_truth(input) && has_object_labels(input) ? TruthKind::objects : TruthKind::automatic;
  }
  return truth == "lidar" ? TruthKind::lidar : TruthKind::exact;
}

/// Checks more than names, as many drives begin with 000000.
void check_same_images(const io::RunReader& run, const Rig& input) {
  const Rig& rig{run.rig()};
  if (rig.width_px == input.width_px && rig.height_px == input.height_px) return;
  throw InputError{io::printable_path(run.folder()),
                   fmt::format("was made from images of {} × {} px, but the input's have {} × {} px.", rig.width_px,
                               rig.height_px, input.width_px, input.height_px),
                   "Give the input that the run was made from."};
}

std::string text_of(const InputOptions& input) {
  std::string text;
  for (const std::string& path : input.paths) text += (text.empty() ? "" : " ") + io::printable_path(path);
  return text;
}

[[noreturn]] void report_names(const io::RunReader& run, const TruthSource& truth) {
  const char* const known{truth.kind() == TruthKind::lidar   ? "a lidar sweep"
                          : truth.kind() == TruthKind::exact ? "ground truth"
                                                             : "object labels from 1 s on"};
  throw InputError{
      io::printable_path(run.folder()),
      fmt::format("none of its frames ({} to {}) has {} in the input, whose frames are {} to {}.",
                  run.frames().front().name, run.frames().back().name, known, truth.input().source->name(0),
                  truth.input().source->name(truth.input().source->size() - 1)),
      "Give the input that the run was made from."};
}

/// Centres of those from 3 to 20 m ahead.
std::vector<Point2> moving_cells_of(const io::RunGrids& grids, const GridGeometry& geometry) {
  constexpr double nearest_m{3};
  constexpr double farthest_m{20};
  constexpr float moving_mps{1};
  std::vector<Point2> cells;
  for (int iy{0}; iy < geometry.ny; ++iy) {
    for (int ix{0}; ix < geometry.nx; ++ix) {
      const Point2 centre{geometry.centre(ix, iy)};
      if (centre.x < nearest_m || centre.x >= farthest_m || !(grids.occupancy(ix, iy) > 0.5F)) continue;
      if (std::hypot(grids.velocity_x(ix, iy), grids.velocity_y(ix, iy)) > moving_mps) cells.push_back(centre);
    }
  }
  return cells;
}

/// Scores of the grids and the obstacles of a run, frame after frame.
class Scorer {
 public:
  Scorer(const io::RunReader& run, const TruthSource& truth) : run_{run}, truth_{truth}, objects_{truth} {
    if (truth.kind() == TruthKind::exact) occupancy_.motion.emplace();
  }

  void add(const io::RunFrame& frame) {
    const auto known{truth_.frame(frame.name, run_.grid(), run_.rig_of(frame))};
    const auto obstacles{objects_.frame(frame.name, known)};
    if (!obstacles && !known) return;
    const io::RunGrids grids{run_.grids(frame.name)};
    if (obstacles) {
      obstacles_.add(*obstacles, frame.obstacles, moving_cells_of(grids, run_.grid()));
      ++obstacle_frames_;
    }
    if (known) add_grids(frame, grids, *known);
  }

  /// Number of frames with truth.
  [[nodiscard]] std::size_t frames() const {
    return truth_.kind() == TruthKind::objects ? obstacle_frames_ : observed_.scores.frames();
  }
  /// Observed and filtered grids of them.
  [[nodiscard]] std::vector<Series> take_series() {
    std::vector<Series> series;
    if (truth_.kind() == TruthKind::objects) return series;
    series.push_back(std::move(observed_));
    series.push_back(std::move(occupancy_));
    return series;
  }
  [[nodiscard]] std::optional<evaluation::ObstacleSummary> obstacles() const {
    return obstacle_frames_ > 0 ? std::optional{obstacles_.summary()} : std::nullopt;
  }
  /// Source of the obstacles' truth, or the reason why there is none.
  [[nodiscard]] std::string obstacles_text() const {
    if (!objects_.exists()) return "not scored: the input has no object labels";
    if (obstacle_frames_ == 0) return "not scored: no frame of the run, from 1 s on, has object labels";
    return fmt::format("{}, {} frames", objects_.name(), obstacle_frames_);
  }

 private:
  void add_grids(const io::RunFrame& frame, const io::RunGrids& grids, const TruthSource::FrameLabels& known) {
    observed_.scores.add(frame.name, grids.observed.view(), known.labels);
    occupancy_.scores.add(frame.name, grids.occupancy.view(), known.labels);
    observed_.witness.add(grids.observed.view(), grids.witness.view(), known.labels);
    occupancy_.witness.add(grids.occupancy.view(), grids.witness.view(), known.labels);
    if (!known.truth) return;
    observed_.terrain.add(grids.observed.view(), run_.grid(), *known.truth, truth_.grid());
    occupancy_.terrain.add(grids.occupancy.view(), run_.grid(), *known.truth, truth_.grid());
    occupancy_.motion->add({*known.truth, truth_.grid(), truth_.input().source->rig(), run_.grid(),
                            grids.occupancy.view(), grids.velocity_x.view(), grids.velocity_y.view(), frame.obstacles});
  }

  const io::RunReader& run_;
  const TruthSource& truth_;
  ObstacleSource objects_;
  Series observed_{"observed", {}};
  Series occupancy_{"occupancy", {}};
  evaluation::ObstacleScores obstacles_;
  std::size_t obstacle_frames_{0};
};

Scorer score(const io::RunReader& run, const TruthSource& truth, const NotifyProgress& notify) {
  Scorer scorer{run, truth};
  std::size_t done{0};
  for (const io::RunFrame& frame : run.frames()) {
    if (notify) notify(done++, run.frames().size());
    scorer.add(frame);
  }
  if (scorer.frames() == 0) report_names(run, truth);
  return scorer;
}

std::string truth_text(const TruthSource& truth) {
  if (truth.kind() == TruthKind::exact) return "exact";
  return truth.kind() == TruthKind::objects ? "none of the cells" : "lidar";
}

}  // namespace

Evaluation evaluate(const EvaluateOptions& options, const NotifyProgress& notify) {
  const io::RunReader run{options.run};
  const InputOptions input{input_options(options, run)};
  Input opened{open_input(input)};
  const TruthKind kind{kind_of(options.truth, opened)};
  const TruthSource truth{std::move(opened), kind, options.camera_height_m};
  check_same_images(run, truth.input().source->rig());
  Scorer scorer{score(run, truth, notify)};
  Evaluation evaluation;
  evaluation.about = {{"run", io::printable_path(run.folder())},
                      {"preset", run.preset()},
                      {"input", text_of(input)},
                      {"truth", truth_text(truth)},
                      {"frames", fmt::format("{} of {}", scorer.frames(), run.frames().size())},
                      {"obstacles", scorer.obstacles_text()}};
  evaluation.series = scorer.take_series();
  evaluation.obstacles = scorer.obstacles();
  return evaluation;
}

}  // namespace stereogrid::app
