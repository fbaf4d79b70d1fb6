// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <set>

#include "batch/inputs.hpp"
#include "batch/runner.hpp"
#include "batch/subcommands.hpp"
#include "cli/commands.hpp"
#include "cli/console.hpp"
#include "cli/option_checks.hpp"
#include "cli/progress.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/config_file.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::app::batch {
namespace {

namespace fs = std::filesystem;

struct Options {
  RunOptions run;
  std::string out;
  std::vector<std::string> sweeps;
  int frames_per_shard{1000};
  int warm_up{50};
  bool content_digests{false};
  bool no_evaluation{false};
  bool skip_bad{false};
};

/// Returns "key=value" of all parameters that differ from the preset.
std::vector<std::string> settings_of(const Config& config, const std::string& preset_name) {
  const Config standard{preset(preset_name)};
  std::vector<std::string> settings;
  visit_parameters(config, [&](std::string_view group, const Parameter& parameter, const auto&) {
    const std::string key{fmt::format("{}.{}", group, parameter.name)};
    if (get(config, key) != get(standard, key)) settings.push_back(fmt::format("{}={}", key, get(config, key)));
  });
  return settings;
}

/// Returns the configurations of a plan: all combinations of the sweeps; without any, the one. Throws ConfigError.
std::vector<Variant> variants_of(const ConfigOptions& options, const std::vector<std::string>& sweeps) {
  std::vector<Variant> variants;
  for (const std::vector<std::string>& swept : combinations(sweeps)) {
    ConfigOptions with_swept{options};
    with_swept.settings.insert(with_swept.settings.end(), swept.begin(), swept.end());
    const Config config{config_from(with_swept)};
    variants.push_back({swept, settings_of(config, with_swept.preset), Json::parse(io::to_json(config))});
  }
  return variants;
}

/// Memory of a runner, MB (10^6 bytes): the pipeline, frames in its queues, the program.
class MemoryEstimate {
 public:
  explicit MemoryEstimate(const Options& options) : options_{options} {}

  /// `frames`: frames of the longest shard.
  void look_at(const Rig& rig, const std::vector<Variant>& variants, std::size_t frames) {
    const std::string key{fmt::format("{} {} {} {}", rig.width_px, rig.height_px, rig.focal_px, rig.baseline_m)};
    if (!seen_.insert(key).second && frames <= most_frames_) return;
    most_frames_ = std::max(most_frames_, frames);
    for (const Variant& variant : variants) {
      const Config config{config_from({options_.run.config.preset, "", variant.settings})};
      const Pipeline pipeline{start_pipeline(config, rig, {"cpu", 1}, {.horizons_s = options_.run.predict_s})};
      const GridGeometry grid{pipeline.vehicle_grid()};
      const double images{30.0 * rig.width_px * rig.height_px};  // eight frames, decoded and raw; visualisations
      const double scored{options_.no_evaluation ? 0.0 : 20.0 * grid.nx * grid.ny * static_cast<double>(most_frames_)};
      bytes_ = std::max(bytes_, static_cast<double>(pipeline.memory_use().host_bytes) * 1.3 + images + scored);
    }
  }
  [[nodiscard]] std::uint64_t megabytes() const {
    constexpr double program_mb{200};
    return static_cast<std::uint64_t>(program_mb + bytes_ / 1e6);
  }

 private:
  const Options& options_;
  std::set<std::string> seen_;
  std::size_t most_frames_{0};
  double bytes_{0};
};

/// Cuts drives into shards.
class Planner {
 public:
  Planner(const Options& options, Plan& plan, PlanWriter& writer)
      : options_{options}, plan_{plan}, writer_{writer}, memory_{options} {}

  void add(const std::string& path) {
    try {
      add_drive(path);
    } catch (const InputError& error) {
      const bool folder{!path.starts_with("scene:") && io::is_folder(path)};
      if (!folder || !add_drives_within(path)) refuse(error.what());
    }
  }
  void finish() {
    if (plan_.drives == 0) throw InputError{"None of the inputs can be used: there is nothing to plan."};
    plan_.memory_mb = memory_.megabytes();
    writer_.finish(plan_);
  }

 private:
  void refuse(const std::string& why) {
    if (!options_.skip_bad) throw InputError{why + "\nNo plan was made. With --skip-bad such inputs are left out."};
    spdlog::warn("left out: {}", why);
    plan_.left_out.push_back(why);
  }

  bool add_drives_within(const std::string& folder) {
    std::vector<std::string> bad;
    std::size_t good{0};
    for (const std::string& path : drives_within(folder)) {
      try {
        add_drive(path);
        ++good;
      } catch (const InputError& error) {
        bad.emplace_back(error.what());
      }
    }
    if (good == 0) return false;
    for (const std::string& why : bad) refuse(why);
    return true;
  }

  void add_drive(const std::string& path) {
    InputOptions input_options{options_.run.input};
    input_options.paths = {path};
    const Input input{open_input(input_options)};
    const std::size_t frames{input.source->size()};
    if (frames == 0) throw InputError{path, "has no frames.", "Give a drive that has some."};
    const Rig& rig{input.source->rig()};
    memory_.look_at(rig, plan_.variants, (frames + parts_of(frames) - 1) / parts_of(frames));
    Shard shard{.drive = names_.name_of(path),
                .input = {path},
                .input_digest = digest_of_input(
                    input_options, options_.content_digests ? DigestOf::content : DigestOf::names_and_sizes)};
    for (shard.variant = 0; shard.variant < plan_.variants.size(); ++shard.variant) {
      cut(shard, frames, static_cast<double>(rig.width_px) * rig.height_px);
    }
    ++plan_.drives;
  }

  [[nodiscard]] std::size_t parts_of(std::size_t frames) const {
    const auto most{static_cast<std::size_t>(options_.frames_per_shard)};
    return most == 0 ? 1 : (frames + most - 1) / most;
  }

  void cut(Shard shard, std::size_t frames, double pixels) {
    const std::size_t parts{parts_of(frames)};
    for (std::size_t i{0}; i < parts; ++i) {
      shard.first = frames * i / parts;
      shard.end = frames * (i + 1) / parts;
      shard.warm_up = std::min(shard.first, static_cast<std::size_t>(options_.warm_up));
      shard.cost = static_cast<double>(shard.end - shard.first + shard.warm_up) * pixels;
      writer_.add(shard, plan_);
    }
  }

  const Options& options_;
  Plan& plan_;
  PlanWriter& writer_;
  MemoryEstimate memory_;
  DriveNames names_;
};

void make_absolute(std::string& path) {
  if (!path.empty()) path = fs::weakly_canonical(fs::absolute(path)).string();
}

/// Throws ConfigError where results lack a layer that scoring needs.
void check_layers(const Options& options) {
  const std::vector<std::string> layers{layers_of(options.run)};
  if (layers.empty() || options.no_evaluation) return;
  for (const char* needed : {"observed", "occupancy", "velocity"}) {
    if (std::ranges::find(layers, needed) != layers.end()) continue;
    throw ConfigError{fmt::format(
        "--layers: where there is truth results are to be scored, which needs the layer {}, too. Add it, or give "
        "--no-evaluation.",
        needed)};
  }
}

int make_plan(Options options) {
  InputOptions& input{options.run.input};
  for (std::string* path : {&input.calibration, &input.mask, &input.disparities, &input.depth}) make_absolute(*path);
  if (!input.poses.empty() && input.poses != "file" && input.poses != "none" && input.poses != "odometry") {
    make_absolute(input.poses);
  }
  check_layers(options);
  Plan plan{.version = std::string{version()},
            .content_digests = options.content_digests,
            .run = to_json(options.run, !options.no_evaluation),
            .variants = variants_of(options.run.config, options.sweeps)};
  const std::vector<std::string> paths{expand_inputs(input.paths)};
  PlanWriter writer{options.out};
  Planner planner{options, plan, writer};
  Progress progress{"inputs", paths.size()};
  for (std::size_t i{0}; i < paths.size(); ++i) {
    planner.add(paths[i]);
    progress.update(i + 1);
  }
  planner.finish();
  if (!spdlog::should_log(spdlog::level::info)) return exit_done;
  tell("{} shards of {} drives, {} frames, {} configurations; a runner needs {} MB\nplan in {}\n", plan.shards,
       plan.drives, plan.frames, plan.variants.size(), plan.memory_mb, io::printable_path(options.out));
  return exit_done;
}

void add_shard_options(CLI::App& command, Options& options) {
  command.add_option("--out,-o", options.out, "Folder of the plan and its results, at the same path on all machines.")
      ->type_name("PLAN")
      ->required();
  command
      .add_option("--frames-per-shard", options.frames_per_shard,
                  "Maximum frames of a shard; longer drives are cut. 0: no limit.")
      ->type_name("N")
      ->check(whole_number(0, 1'000'000'000))
      ->capture_default_str();
  command.add_option("--warm-up", options.warm_up, "Frames before a cut that are processed, unwritten.")
      ->type_name("N")
      ->check(whole_number(0, 1'000'000'000))
      ->capture_default_str();
  command
      .add_option("--sweep", options.sweeps, "Values for every drive: KEY=A,B,C; several --sweep: every combination.")
      ->type_name("KEY=A,B,...")
      ->expected(1)
      ->take_all();
  command.add_flag("--content-digests", options.content_digests,
                   "Digest every byte of the inputs, not only names, sizes and small files.");
  command.add_flag("--no-evaluation", options.no_evaluation, "Do not score results where there is truth.");
  command.add_flag("--skip-bad", options.skip_bad, "Leave out inputs that cannot be used, and note them in the plan.");
}

}  // namespace

void add_plan_command(CLI::App& batch, int& exit_code) {
  auto options{std::make_shared<Options>()};
  options->run.device.device = "cpu";
  CLI::App* command{batch.add_subcommand(
      "plan",
      "Cut drives into shards. INPUT: drives, folders of drives, bags, scenes, patterns, lists (@FILE, .txt).")};
  add_input_options(*command, options->run.input);
  command->get_option("INPUT")->expected(1, 1 << 28)->type_name("...");
  add_shard_options(*command, *options);
  add_config_options(*command, options->run.config);
  add_result_options(*command, options->run);
  command
      ->add_option("--device", options->run.device.device,
                   "Device of all shards: results of CPU and GPU differ in the last digits.")
      ->check(CLI::IsMember({"cpu", "cuda"}))
      ->capture_default_str();
  command->callback([options, &exit_code] { exit_code = make_plan(*options); });
}

}  // namespace stereogrid::app::batch
