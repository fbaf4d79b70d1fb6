// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "commands.hpp"
#include "input.hpp"
#include "progress.hpp"
#include "run_reader.hpp"
#include "scores.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/io/truth.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace stereogrid::app {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t settling_ns{1'000'000'000};  // velocities are scored from one second on

struct Options {
  std::string run;
  std::string input;
  std::string json;
};

/// Where the truth comes from.
struct Truth {
  TruthGrid grid;
  std::function<std::optional<FrameTruth>(const std::string& name)> frame;
};

Truth truth_of_scene(const scenes::Scene& scene) {
  return {scene.truth_grid(), [&scene](const std::string& name) -> std::optional<FrameTruth> {
            for (std::size_t i{0}; i < scene.size(); ++i) {
              if (scene.name(i) == name) return scene.truth(i);
            }
            return std::nullopt;
          }};
}

Truth truth_in(const fs::path& folder) {
  const auto reader{std::make_shared<io::TruthReader>(folder)};
  return {reader->grid(), [reader](const std::string& name) -> std::optional<FrameTruth> {
            if (!reader->has(name)) return std::nullopt;
            return reader->frame(name);
          }};
}

struct Scores {
  CellScores observed;
  CellScores occupancy;
  MotionScores motion;
  std::size_t frames{0};
};

/// Cells that the truth lies to the right of and above the run's first cell. Throws InputError: not whole cells.
struct Shift {
  int x{0};
  int y{0};
};
Shift shift_between(const GridGeometry& run, const GridGeometry& truth) {
  const double x{(truth.x_min_m - run.x_min_m) / run.cell_size_m};
  const double y{(truth.y_min_m - run.y_min_m) / run.cell_size_m};
  const auto is_whole = [](double cells) { return std::abs(cells - std::round(cells)) < 1e-6; };
  if (std::abs(run.cell_size_m - truth.cell_size_m) > 1e-9 || !is_whole(x) || !is_whole(y)) {
    throw InputError{
        fmt::format("The run's cells ({:g} m) do not coincide with the truth's ({:g} m). Run with "
                    "--set grid.cell_size_m={:g}.",
                    run.cell_size_m, truth.cell_size_m, truth.cell_size_m)};
  }
  return {static_cast<int>(std::lround(x)), static_cast<int>(std::lround(y))};
}

void score_cells(const FrameTruth& truth, const RunGrids& run, Shift shift, Scores& scores) {
  for (int ty{0}; ty < truth.state.height(); ++ty) {
    for (int tx{0}; tx < truth.state.width(); ++tx) {
      const int ix{tx + shift.x};
      const int iy{ty + shift.y};
      if (ix < 0 || iy < 0 || ix >= run.observed.width() || iy >= run.observed.height()) continue;
      const auto state{static_cast<TruthCell>(truth.state(tx, ty))};
      if (state == TruthCell::hidden) {
        if (truth.occupied(tx, ty) == 0) continue;
        scores.observed.add_hidden_occupied(run.observed(ix, iy));
        scores.occupancy.add_hidden_occupied(run.occupancy(ix, iy));
        continue;
      }
      const bool occupied{state == TruthCell::seen_occupied};
      scores.observed.add(run.observed(ix, iy), occupied);
      scores.occupancy.add(run.occupancy(ix, iy), occupied);
      const bool is_static{truth.velocity_x(tx, ty) == 0 && truth.velocity_y(tx, ty) == 0};
      if (occupied && is_static) scores.motion.add_static_cell(run.occupancy(ix, iy), run.speed_mps(ix, iy));
    }
  }
}

Scores score(const RunReader& run, const Truth& truth) {
  Scores scores;
  const Shift shift{shift_between(run.grid(), truth.grid.geometry)};
  Progress progress{"frames", run.frames().size()};
  std::size_t done{0};
  for (const RunFrame& frame : run.frames()) {
    progress.update(done++);
    const std::optional<FrameTruth> known{truth.frame(frame.name)};
    if (!known) continue;
    ++scores.frames;
    score_cells(*known, run.grids(frame.name), shift, scores);
    if (frame.stamp_ns >= run.frames().front().stamp_ns + settling_ns) {
      scores.motion.add_objects(*known, run.grid(), frame.obstacles);
    }
  }
  if (scores.frames == 0) throw InputError{"No frame of the run has ground truth. Is it the same data set?"};
  return scores;
}

nlohmann::ordered_json number(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json{};
}

nlohmann::ordered_json json_of(const CellScores::Summary& s) {
  return {{"cells", s.cells},
          {"occupied", s.occupied},
          {"accuracy", number(s.accuracy)},
          {"missed", number(s.missed)},
          {"false_alarms", number(s.false_alarms)},
          {"balanced_log_loss", number(s.balanced_log_loss)},
          {"auc", number(s.auc)},
          {"known", number(s.known)},
          {"hidden_occupied_mean", number(s.hidden_occupied_mean)}};
}

nlohmann::ordered_json json_of(const MotionScores::Summary& s) {
  return {{"sightings", s.sightings},
          {"found", s.found},
          {"speed_error_mps", number(s.speed_error_mps)},
          {"direction_error_deg", number(s.direction_error_deg)},
          {"static_cells", s.static_cells},
          {"static_moving", number(s.static_moving)}};
}

void print_table(const Scores& scores) {
  const CellScores::Summary a{scores.observed.summary()};
  const CellScores::Summary b{scores.occupancy.summary()};
  const MotionScores::Summary m{scores.motion.summary()};
  const auto row = [](const char* what, double observed, double filtered) {
    fmt::print("{:<44}{:>10.4f}{:>11.4f}\n", what, observed, filtered);
  };
  fmt::print("{} frames, {} cells seen, {} of them occupied\n\n", scores.frames, a.cells, a.occupied);
  fmt::print("{:<44}{:>10}{:>11}\n", "cells", "observed", "occupancy");
  row("accuracy (p > 0.5)", a.accuracy, b.accuracy);
  row("missed: occupied, p < 0.45", a.missed, b.missed);
  row("false alarms: free, p > 0.55", a.false_alarms, b.false_alarms);
  row("balanced log-loss", a.balanced_log_loss, b.balanced_log_loss);
  row("AUC", a.auc, b.auc);
  row("known: |p - 0.5| > 0.05", a.known, b.known);
  row("mean p of hidden cells that are occupied", a.hidden_occupied_mean, b.hidden_occupied_mean);
  fmt::print("\nmoving objects after 1 s: {} sightings, {} found\n", m.sightings, m.found);
  if (m.found > 0) {
    fmt::print("median error: speed {:.2f} m/s, direction {:.1f} deg\n", m.speed_error_mps, m.direction_error_deg);
  }
  fmt::print("static occupied cells that seem to move: {:.4f} of {}\n", m.static_moving, m.static_cells);
}

int evaluate(const Options& options) {
  const RunReader run{options.run};
  Input scene_input;
  Truth truth;
  if (options.input.starts_with("scene:")) {
    scene_input = open_input({{options.input}, "", "", ""});
    truth = truth_of_scene(*scene_input.scene);
  } else {
    const fs::path folder{options.input};
    truth = truth_in(fs::is_directory(folder / "truth") ? folder / "truth" : folder);
  }
  const Scores scores{score(run, truth)};
  print_table(scores);
  if (options.json.empty()) return exit_done;
  const nlohmann::ordered_json json{{"frames", scores.frames},
                                    {"observed", json_of(scores.observed.summary())},
                                    {"occupancy", json_of(scores.occupancy.summary())},
                                    {"motion", json_of(scores.motion.summary())}};
  io::write_file(options.json, json.dump(2) + "\n");
  return exit_done;
}

}  // namespace

void add_evaluate_command(CLI::App& tool, int& exit_code) {
  auto options{std::make_shared<Options>()};
  CLI::App* command{tool.add_subcommand("evaluate", "Score a run against ground truth.")};
  command->add_option("RUN_DIR", options->run, "What `stereogrid run --out` has left.")->type_name(" ")->required();
  command->add_option("INPUT,--truth", options->input, "The run's input, with truth/; its truth/; or the scene.")
      ->type_name(" ")
      ->required();
  command->add_option("--json", options->json, "Also write the scores to this file.")->type_name("FILE");
  command->callback([options, &exit_code] { exit_code = evaluate(*options); });
}

}  // namespace stereogrid::app
