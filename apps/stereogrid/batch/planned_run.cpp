// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <system_error>

#include "batch/runner.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::app::batch {
namespace {

namespace fs = std::filesystem;

constexpr int frames_between_checkpoints{25};

void read(const Json& run, RunOptions& options) {
  options.config.preset = run.at("preset");
  InputOptions& input{options.input};
  input.calibration = run.at("calibration");
  input.poses = run.at("poses");
  input.disparities = run.at("disparities");
  input.mask = run.at("mask");
  input.depth = run.value("depth", std::string{});
  input.depth_scale = run.value("depth_scale", input.depth_scale);
  input.layout = run.value("layout", std::string{});
  input.left_topic = run.at("left_topic");
  input.right_topic = run.at("right_topic");
  input.pair_tolerance_ms = run.at("pair_tolerance_ms");
  options.fuse = run.at("fuse");
  options.predict_s = run.at("predict_s").get<std::vector<double>>();
  options.device.device = run.at("device");
  options.compact = run.value("compact", false);
  options.every = run.value("every", std::size_t{1});
  options.layers = run.value("layers", std::vector<std::string>{});
  options.save_stages = run.at("save_stages");
  options.pictures = run.at("pictures");
}

}  // namespace

Json to_json(const RunOptions& options, bool evaluate) {
  const InputOptions& input{options.input};
  return {{"preset", options.config.preset},
          {"calibration", input.calibration},
          {"poses", input.poses},
          {"disparities", input.disparities},
          {"depth", input.depth},
          {"depth_scale", input.depth_scale},
          {"mask", input.mask},
          {"layout", input.layout},
          {"left_topic", input.left_topic},
          {"right_topic", input.right_topic},
          {"pair_tolerance_ms", input.pair_tolerance_ms},
          {"fuse", options.fuse},
          {"predict_s", options.predict_s},
          {"device", options.device.device},
          {"compact", options.compact},
          {"every", options.every},
          {"layers", layers_of(options)},
          {"save_stages", options.save_stages},
          {"pictures", options.pictures},
          {"evaluate", evaluate}};
}

RunOptions run_options(const Plan& plan, const Shard& shard, const fs::path& folder) {
  RunOptions options;
  read(plan.run, options);  // well-formed: the shard's digest covers it
  options.input.paths = shard.input;
  options.config.settings = plan.variants.at(shard.variant).settings;
  options.folder = folder.string();
  options.frames = fmt::format("{}:{}", shard.first, shard.end - 1);
  options.warm_up = static_cast<int>(shard.warm_up);
  options.resume = true;
  options.checkpoint_every = frames_between_checkpoints;
  return options;
}

bool is_evaluated(const Plan& plan) {
  return plan.run.value("evaluate", false);
}

std::string digest_of_input(const InputOptions& input, DigestOf what) {
  std::vector<std::string> paths{input.paths};
  for (const std::string& more : {input.calibration, input.mask, input.disparities, input.depth}) {
    if (!more.empty()) paths.push_back(more);
  }
  const bool poses_file{!input.poses.empty() && input.poses != "file" && input.poses != "none" &&
                        input.poses != "odometry"};
  if (poses_file) paths.push_back(input.poses);
  return input_digest(paths, what);
}

std::string PlannedInput::missing() const {
  for (const std::string& path : shard_.input) {
    if (path.starts_with("scene:")) continue;
    const bool is_empty{io::is_folder(path) && !io::has_entries(path)};
    if (is_empty || !io::is_there(path)) return io::printable(path);
  }
  return "";
}

bool PlannedInput::is_as_planned() const {
  const DigestOf what{plan_.plan().content_digests ? DigestOf::content : DigestOf::names_and_sizes};
  try {
    return digest_of_input(run_options(plan_.plan(), shard_, {}).input, what) == shard_.input_digest;
  } catch (const InputError& error) {
    throw DeviceError{error.what()};
  }
}

bool PlannedInput::is_there() const {
  try {
    return missing().empty() && is_as_planned();
  } catch (const DeviceError&) {
    return false;
  }
}

}  // namespace stereogrid::app::batch
