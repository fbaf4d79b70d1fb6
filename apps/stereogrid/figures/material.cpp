// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "figures/material.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <utility>

#include "progress.hpp"
#include "run/pose_stage.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/io/scan.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace stereogrid::app::figures {
namespace {

constexpr std::size_t most_frames_before{20};
constexpr std::size_t moment_step{8};
constexpr std::size_t moments{3};
constexpr std::array<double, 3> rates{0.01, 0.1, 0.3};

bool has_scan(const Input& input, std::size_t index) {
  return input.recording != nullptr && !input.recording->contents().frames[index].scan.empty() &&
         input.recording->contents().calibration.camera_from_velodyne.has_value();
}

std::vector<Config> variants_of(const Config& config) {
  std::vector<Config> variants(1 + rates.size(), config);
  variants[0].u_disparity.sigma_disparity = 0;
  variants[0].u_disparity.sigma_column = 0;
  for (std::size_t i{0}; i < rates.size(); ++i) {
    variants[1 + i].u_disparity.false_positive = rates[i];
    variants[1 + i].u_disparity.false_negative = rates[i];
  }
  return variants;
}

/// Pipelines that see the same frames.
class Side {
 public:
  Side(const Config& config, const Rig& rig) {
    for (const Config& variant : variants_of(config)) pipelines_.emplace_back(variant, rig);
  }

  void process(const StereoFrame& frame) {
    results_.clear();
    for (Pipeline& pipeline : pipelines_) {
      const FrameResult& result{pipeline.process(frame)};
      results_.push_back({pipeline.config().u_disparity, result.observed, result.occupancy});
    }
  }

  /// Of the last frame.
  [[nodiscard]] std::vector<Variant> results() { return std::move(results_); }

 private:
  std::vector<Pipeline> pipelines_;
  std::vector<Variant> results_;
};

/// The frames [first, last] through the pipeline and its variants. Frames before the last may be damaged.
void process(const Input& input, std::size_t first, std::size_t last, const Config& config, Material& material) {
  Pipeline pipeline{config, material.rig};
  Side side{config, material.rig};
  PoseStage poses{input};
  material.config = pipeline.config();
  Progress progress{"frames", last - first + 1};
  for (std::size_t index{first}; index <= last; ++index) {
    try {
      StereoFrame frame{input.source->load(index)};
      poses.place(frame);
      const FrameResult& result{pipeline.process(frame)};
      side.process(frame);
      const std::size_t before{last - index};
      if (before % moment_step == 0 && before / moment_step < moments) {
        material.moments.push_back({std::move(frame), result});
      }
      if (before > 0) ++material.frames_before;
    } catch (const InputError& error) {
      if (index == last) throw;
      spdlog::warn("frame {} is skipped: {}", input.source->name(index), error.what());
    }
    progress.update(index - first + 1);
  }
  material.error_rates = side.results();
  material.without_gaussian = material.error_rates.front();
  material.error_rates.erase(material.error_rates.begin());
}

std::optional<std::vector<LidarPoint>> scan_of(const Input& input, std::size_t index, const Material& material) {
  if (!has_scan(input, index)) return std::nullopt;
  const io::RecordingContents& contents{input.recording->contents()};
  return in_vehicle(io::read_scan(contents.frames[index].scan), *contents.calibration.camera_from_velodyne,
                    material.rig, material.moment().result.ground);
}

std::optional<FrameTruth> truth_of(const Input& input, std::size_t index, const GridGeometry& grid) {
  if (input.scene == nullptr || !(input.scene->truth_grid().geometry == grid)) return std::nullopt;
  return input.scene->truth(index);
}

}  // namespace

std::size_t frame_index(const Input& input, const std::string& name) {
  const std::size_t frames{input.source->size()};
  for (std::size_t index{0}; index < frames && !name.empty(); ++index) {
    if (input.source->name(index) == name) return index;
  }
  if (!name.empty()) {
    throw ConfigError{fmt::format("--frame {}: the input has no frame of this name. It has {} frames, {} to {}.", name,
                                  frames, input.source->name(0), input.source->name(frames - 1))};
  }
  const std::size_t middle{frames / 2};
  for (std::size_t away{0}; away <= middle; ++away) {
    if (has_scan(input, middle - away)) return middle - away;
    if (middle + away < frames && has_scan(input, middle + away)) return middle + away;
  }
  return middle;
}

Material gather(const Input& input, std::size_t index, const Config& config) {
  Material material;
  material.rig = input.source->rig();
  process(input, index - std::min(index, most_frames_before), index, config, material);
  material.scan = scan_of(input, index, material);
  material.truth = truth_of(input, index, material.moment().result.vehicle_grid);
  return material;
}

}  // namespace stereogrid::app::figures
