// SPDX-License-Identifier: Apache-2.0
#include "cli/config_options.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <array>
#include <utility>

#include "cli/program.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/config_file.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::app {

void add_config_options(Command command, ConfigOptions& options) {
  command.group(Group::parameters);
  command
      .add_option("--preset default|robot|paper|auto", options.preset,
                  "Preset: default, robot (a low camera), paper (as published), or auto: robot for a camera less than "
                  "0.6 m above the ground, else default.")
      .show_default();
  command.add_option("--config FILE.yaml", options.file, "YAML file with parameters, as 'config --yaml' prints.");
  command
      .add_option("--set KEY=VALUE", options.settings,
                  "Value of a parameter, such as grid.length_m=30. May be repeated.")
      .expected(1)
      .take_all();
}

Config config_from(const ConfigOptions& options) {
  Config config{preset(options.preset == automatic_preset ? "default" : options.preset)};
  if (!options.file.empty()) io::load_config(options.file, config);
  for (const std::string& setting : options.settings) {
    const std::size_t equals{setting.find('=')};
    if (equals == std::string::npos) {
      throw ConfigError{fmt::format("--set {}: give KEY=VALUE, such as grid.length_m=30.", setting)};
    }
    set(config, setting.substr(0, equals), setting.substr(equals + 1));
  }
  return config;
}

Config resolve_preset(ConfigOptions& options, const std::function<PresetChoice()>& choose) {
  if (options.preset == automatic_preset) {
    PresetChoice choice{choose()};
    spdlog::info("preset {}: {}", choice.preset, choice.reason);
    options.preset = std::move(choice.preset);
  }
  return config_from(options);
}

std::string why_unread(const Config& config, std::string_view key, const InputUse& input) {
  struct Rule {
    std::vector<std::string_view> keys;  // one that ends in a dot is a group
    bool is_read;
    std::string_view condition;
  };
  const std::array rules{
      Rule{{"paper."},
           config.projection.model == ProjectionModel::bins,
           "projection.model=bins; with rays, stage images and figures show it, grids do not"},
      Rule{{"vehicle."}, config.ground.model == GroundModel::terrain, "ground.model=terrain"},
      Rule{{"ground.height_gate_m", "ground.pitch_gate_deg", "ground.roll_gate_deg"},
           config.ground.estimate,
           "ground.estimate=true"},
      Rule{{"filter.decay_time_in_view_s"}, config.filter.model == FilterModel::joint, "filter.model=joint"},
      Rule{{"matching.external_sigma_px", "matching.external_sigma_per_m"},
           input.has_disparities,
           "disparities or depth as input"},
      Rule{{"matching.align_rows", "matching.uniqueness", "matching.texture", "matching.cost_limit",
            "matching.left_right_px", "matching.subpixel", "matching.thin_tops"},
           !input.has_disparities,
           "right images as input"},
      Rule{{"fusion.stereo_confidence"}, input.is_fused, "grids of another source (--fuse)"}};
  bool is_known{false};
  visit_parameters(config, [&](std::string_view group, const Parameter& parameter, const auto&) {
    is_known = is_known || key == fmt::format("{}.{}", group, parameter.name);
  });
  constexpr std::string_view former{"u_disparity."};  // group of the parameters of `paper`
  if (!is_known && key.starts_with(former))
    return why_unread(config, fmt::format("paper.{}", key.substr(former.size())), input);
  for (const Rule& rule : rules) {
    if (rule.is_read) continue;
    for (const std::string_view named : rule.keys) {
      if (key == named || (named.ends_with('.') && key.starts_with(named))) return std::string{rule.condition};
    }
  }
  return {};
}

void warn_of_unread(const ConfigOptions& options, const Config& config, const InputUse& input) {
  for (const std::string& setting : options.settings) {
    const std::string key{setting.substr(0, setting.find('='))};
    if (const std::string condition{why_unread(config, key, input)}; !condition.empty()) {
      spdlog::warn("--set {}: not read here. It needs {}.", io::printable(setting), condition);
    }
  }
}

void add_device_options(Command command, DeviceOptions& options) {
  command.group(Group::device);
  const auto set = [&options](const std::string& device) {
    options.device = device;
    options.is_explicit = true;
  };
  command
      .add_option_function("--device auto|cpu|cuda|cuda:N|reference", set,
                           "Device that computes. Default: auto, the fastest available.")
      .check(device_problem);
  command
      .add_option("--threads N", options.threads, "Threads of the pipeline; 0: all cores. Results do not depend on it.")
      .check(whole_number(0, 1024))
      .show_default();
}

Pipeline start_pipeline(const Config& config, std::span<const Rig> rigs, const DeviceOptions& options,
                        PipelineOptions made) {
  set_device(made, options);
  try {
    Pipeline pipeline{config, rigs, made};
    if (pipeline.back_end() == BackEnd::cuda) spdlog::info("on the GPU");
    if (!pipeline.why_not_cuda().empty()) {
      spdlog::log(options.is_explicit ? spdlog::level::info : spdlog::level::debug, "on the CPU. No GPU: {}",
                  pipeline.why_not_cuda());
    }
    return pipeline;
  } catch (const DeviceError& error) {
    if (made.back_end != BackEnd::cuda) throw;  // such as a thread that cannot be started
    throw DeviceError{fmt::format("--device {}: {} Take --device cpu, or auto.", options.device, error.what())};
  }
}

}  // namespace stereogrid::app
