// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/run_options.hpp"

#include <fmt/format.h>

namespace stereogrid::app::batch {
namespace {

constexpr int frames_between_checkpoints{25};

void read(const Json& run, RunOptions& options) {
  options.config.preset = run.at("preset");
  InputOptions& input{options.input};
  input.calibration = run.at("calibration");
  input.poses = run.at("poses");
  input.disparities = run.at("disparities");
  input.mask = run.at("mask");
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

void take_copy(std::string& path, const std::map<std::string, std::string>& copies) {
  const auto copy{copies.find(path)};
  if (copy != copies.end()) path = copy->second;
}

}  // namespace

Json to_json(const RunOptions& options, bool evaluate) {
  const InputOptions& input{options.input};
  return {{"preset", options.config.preset},
          {"calibration", input.calibration},
          {"poses", input.poses},
          {"disparities", input.disparities},
          {"mask", input.mask},
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

RunOptions run_options(const Plan& plan, const Shard& shard, const std::filesystem::path& folder,
                       const std::map<std::string, std::string>& copies) {
  RunOptions options;
  // whole and well-formed: the shard's digest is also of it
  read(plan.run, options);
  options.input.paths = shard.input;
  options.copies = copies;
  for (std::string& path : options.input.paths) take_copy(path, copies);
  for (std::string* path :
       {&options.input.calibration, &options.input.mask, &options.input.disparities, &options.input.poses}) {
    take_copy(*path, copies);
  }
  options.config.settings = plan.variants.at(shard.variant).settings;
  options.folder = folder.string();
  options.frames = fmt::format("{}:{}", shard.first, shard.end - 1);
  options.warm_up = static_cast<int>(shard.warm_up);
  options.world_of_input = true;
  options.save_last = plan.hand_on;
  options.resume = true;
  options.checkpoint_every = frames_between_checkpoints;
  return options;
}

std::vector<std::string> files_of(const InputOptions& input) {
  std::vector<std::string> paths{input.paths};
  for (const std::string& more : {input.calibration, input.mask, input.disparities}) {
    if (!more.empty()) paths.push_back(more);
  }
  const bool poses_file{!input.poses.empty() && input.poses != "file" && input.poses != "none" &&
                        input.poses != "odometry"};
  if (poses_file) paths.push_back(input.poses);
  return paths;
}

std::string digest_of_input(const InputOptions& input, DigestOf what) {
  return input_digest(files_of(input), what);
}

bool is_evaluated(const Plan& plan) {
  return plan.run.value("evaluate", false);
}

}  // namespace stereogrid::app::batch
