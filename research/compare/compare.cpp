// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "compare/compare.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "cli/console.hpp"
#include "cli/program.hpp"
#include "compare/methods.hpp"
#include "pose_stage.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/evaluation/ray_fan.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/frame_queue.hpp"
#include "stereogrid/io/json_text.hpp"
#include "stereogrid/io/npz.hpp"
#include "stereogrid/io/recording.hpp"

namespace stereogrid::research {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t pictures_at_most{6};

/// External knowledge about a frame.
struct Known {
  std::optional<evaluation::Labels> labels;
  std::optional<FrameTruth> truth;
  std::vector<evaluation::CameraPoint> sweep;
};

double ms_after_ground(const StageTimes& times, bool over_time) {
  return times.count + times.project + (over_time ? times.filter : 0);
}

/// Takes the frames of an input through all methods.
class Comparer {
 public:
  Comparer(const CompareOptions& options, const app::TruthSource& truth)
      : options_{options},
        truth_{truth},
        methods_{compare_methods(app::config_from(options.config), truth.has_sweeps(), options.only)},
        first_{app::config_from(options.config), truth.input().source->rig(), {.threads = options.threads}} {
    for (const CompareMethod& method : methods_) {
      ComparedMethod compared{method.title, method.over_time, {method.name, {}}, {}};
      if (method.over_time && truth.kind() == app::TruthKind::exact) compared.series.motion.emplace();
      comparison_.methods.push_back(std::move(compared));
      pipelines_.push_back(pipeline_for(method));
    }
  }

  Comparison run(io::FrameRange range) {
    app::Progress progress{"frames", range.end - range.first};
    io::FrameQueue queue{*truth_.input().source, range.first, range.end};
    const app::Input& input{truth_.input()};
    app::PoseStage poses{input.poses, input.source->rig(), input.mask};
    picture_every_ = std::max<std::size_t>(1, (range.end - range.first) / pictures_at_most);
    next_picture_ = range.first;
    while (std::optional<io::QueuedFrame> queued{queue.next()}) {
      if (queued->frame) {
        poses.place(*queued->frame);
        opencv_.match(*queued->frame);
        take(*queued->frame);
      } else {
        spdlog::warn("frame {} is skipped: {}", queued->name, queued->error);
      }
      progress.update(queued->index + 1 - range.first);
    }
    if (comparison_.frames_with_truth == 0) throw InputError{"None of the frames has lidar or truth to compare with."};
    return std::move(comparison_);
  }

 private:
  // the first pipeline's disparities serve all other methods; nothing is filtered twice
  [[nodiscard]] std::unique_ptr<Pipeline> pipeline_for(const CompareMethod& method) const {
    if (!method.config || method.name == "observed") return nullptr;
    return std::make_unique<Pipeline>(*method.config, truth_.input().source->rig(),
                                      PipelineOptions{.threads = options_.threads});
  }

  [[nodiscard]] Known known_about(const StereoFrame& frame) const {
    Known known;
    if (truth_.has_sweeps())
      known.sweep = truth_.sweep(frame.name, options_.hold_out ? app::Rings::even : app::Rings::all);
    if (auto labelled{truth_.frame(frame.name, first_.vehicle_grid(), first_.rig())}) {
      known.labels = std::move(labelled->labels);
      known.truth = std::move(labelled->truth);
    }
    return known;
  }

  void take(const StereoFrame& frame) {
    Known known{known_about(frame)};
    const FrameResult& result{first_.process(frame)};
    const ComparedFrame compared{{first_.rig(), result.ground, first_.config().matching.disparities,
                                  result.stages.obstacle_disparity.view(), result.stages.road_disparity.view()},
                                 result.vehicle.geometry,
                                 result.world_from_vehicle,
                                 std::move(known.sweep),
                                 truth_.lidar_in_camera(),
                                 truth_.lidar_road_m(first_.rig())};
    ++comparison_.frames;
    comparison_.frames_with_truth += known.labels ? 1 : 0;
    std::vector<NamedGrid> grids;
    for (std::size_t i{0}; i < methods_.size(); ++i) {
      const MethodResult made{run(i, frame, result, compared)};
      if (made.occupancy.empty()) continue;
      comparison_.methods[i].milliseconds.push_back(made.milliseconds);
      if (known.labels) score(comparison_.methods[i].series, frame.name, known, made, result.vehicle.geometry);
      if (keeps_grids_) grids.push_back({methods_[i].name, methods_[i].title, made.occupancy});
    }
    if (known.labels) draw(frame, *known.labels, grids);
    if (!options_.grids.empty()) write_grids(frame.name, grids, compared.sweep);
  }

  static StereoFrame with_lidar(StereoFrame frame, const ComparedFrame& compared) {
    if (compared.sweep.empty()) return frame;
    const Rig& rig{compared.disparities.rig};
    frame.other_grids.push_back({compared.grid, evaluation::lidar_grid(compared.sweep, compared.lidar, rig,
                                                                       compared.grid, rig.camera_height_m)});
    return frame;
  }

  /// Grid, time from disparities and ground, and further results of this library.
  struct MethodResult {
    Image<float> occupancy;
    double milliseconds{0};
    const FrameResult* pipeline{nullptr};
  };

  MethodResult run(std::size_t i, const StereoFrame& frame, const FrameResult& first, const ComparedFrame& compared) {
    const CompareMethod& method{methods_[i]};
    if (!method.config) {
      const auto start{std::chrono::steady_clock::now()};
      Image<float> grid{method.grid_of(compared)};
      const std::chrono::duration<double, std::milli> spent{std::chrono::steady_clock::now() - start};
      return {std::move(grid), spent.count()};
    }
    const FrameResult& result{!pipelines_[i]       ? first
                              : method.fuses_lidar ? pipelines_[i]->process(with_lidar(frame, compared))
                                                   : pipelines_[i]->process(frame)};
    return {method.over_time ? result.vehicle.occupancy : result.observed,
            ms_after_ground(result.timing_ms, method.over_time), &result};
  }

  void score(app::Series& series, const std::string& name, const Known& known, const MethodResult& made,
             const GridGeometry& grid) const {
    series.scores.add(name, made.occupancy.view(), *known.labels);
    if (!series.motion || !known.truth) return;
    evaluation::MotionFrame motion{*known.truth, truth_.grid(), first_.rig(), grid, made.occupancy.view(), {}, {}, {}};
    if (made.pipeline != nullptr) {
      motion.velocity_x = made.pipeline->vehicle.velocity_x.view();
      motion.velocity_y = made.pipeline->vehicle.velocity_y.view();
      motion.obstacles = made.pipeline->obstacles;
    }
    series.motion->add(motion);
  }

  void draw(const StereoFrame& frame, const evaluation::Labels& labels, const std::vector<NamedGrid>& grids) {
    if (options_.pictures.empty() || static_cast<std::size_t>(frame.index) < next_picture_) return;
    next_picture_ += picture_every_;
    io::write_png(fs::path{options_.pictures} / (frame.name + ".png"), draw_comparison(frame.left, labels, grids));
  }

  void write_grids(const std::string& name, const std::vector<NamedGrid>& grids,
                   const std::vector<evaluation::CameraPoint>& sweep) const {
    static_assert(sizeof(evaluation::CameraPoint) == 3 * sizeof(double));
    std::vector<io::NpzArray> arrays;
    for (const NamedGrid& grid : grids) arrays.emplace_back(grid.name, grid.occupancy);
    const std::span<const double> coordinates{reinterpret_cast<const double*>(sweep.data()), 3 * sweep.size()};
    if (!sweep.empty()) arrays.emplace_back("sweep", std::vector<std::size_t>{sweep.size(), 3}, coordinates);
    io::write_npz(fs::path{options_.grids} / (name + ".npz"), arrays);
  }

  const CompareOptions& options_;
  const app::TruthSource& truth_;
  bool keeps_grids_{!options_.pictures.empty() || !options_.grids.empty()};
  std::vector<CompareMethod> methods_;
  Pipeline first_;
  OpencvStage opencv_{options_.matcher, first_.config().matching.disparities};
  std::vector<std::unique_ptr<Pipeline>> pipelines_;  // none: the method makes its own grid
  Comparison comparison_;
  std::size_t picture_every_{1};
  std::size_t next_picture_{0};
};

}  // namespace

int compare(const CompareOptions& options) {
  const app::TruthSource truth{app::open_input(options.input), options.hold_out ? app::TruthKind::lidar : options.truth,
                               options.camera_height_m, options.hold_out ? app::Rings::odd : app::Rings::all};
  app::log_input(truth.input());
  const io::Recording* const recording{truth.input().recording};
  if (options.matcher != "own" && recording != nullptr && recording->gives_disparities()) {
    throw ConfigError{fmt::format("--matcher {} needs right images, but the disparities are given ({}). Leave one out.",
                                  options.matcher, recording->contents().disparities.string())};
  }
  const io::FrameRange range{app::parse_frame_range(options.frames, truth.input().source->size())};
  for (const std::string& folder : {options.pictures, options.grids}) {
    if (!folder.empty()) io::create_folder(folder);
  }
  const Comparison comparison{Comparer{options, truth}.run(range)};
  print_table(comparison);
  if (options.json.empty()) return app::exit_done;
  const nlohmann::ordered_json json(
      json_of(comparison, {{"input", options.input.paths.front()},
                           {"preset", options.config.preset},
                           {"truth", truth.kind() == app::TruthKind::lidar ? "lidar" : "exact"},
                           {"frames", fmt::format("{} of {}", comparison.frames_with_truth, comparison.frames)}}));
  io::write_file(options.json, io::json_text(json, 1) + "\n");
  return app::exit_done;
}

}  // namespace stereogrid::research
