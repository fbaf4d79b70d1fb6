// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "compare/methods.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "baselines/baselines.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/evaluation/ray_fan.hpp"

namespace stereogrid::research {
namespace {

using Methods = std::vector<CompareMethod>;

/// The grid as published, on the same disparities and ground.
Config with_paper_grid(Config config) {
  const Config paper{preset("paper")};
  config.u_disparity = paper.u_disparity;
  config.paper = paper.paper;
  config.projection = paper.projection;
  return config;
}

/// Ternary grid of the paper's figure 6 (c): the largest disparity of a column decides. Gaussian, probabilities and
/// volume are those of the paper's own grid, which has no left border.
NearestObstacleParameters paper_nearest_obstacle(const Config& config) {
  const Config paper{with_paper_grid(config)};
  return {.grid = {.bins_per_px = 1,
                   .left_border_px = -config.matching.disparities,
                   .sigma_column = paper.paper.sigma_column,
                   .sigma_disparity = paper.paper.sigma_disparity},
          .levels = {.free = paper.paper.false_negative, .occupied = 1 - paper.paper.false_positive},
          .height_min_m = paper.u_disparity.obstacle_min_height_m,
          .height_max_m = paper.u_disparity.obstacle_height_m,
          .filled_m = 0,
          .open_road = false};
}

void add_single_frame_methods(const Config& config, bool with_lidar, Methods& methods) {
  const auto add = [&](const char* name, const char* title, auto grid_of) {
    methods.push_back({name, title, false, std::nullopt, std::move(grid_of)});
  };
  methods.push_back({"observed", "visibility grid (this library)", false, config});
  methods.push_back({"observed_paper", "visibility grid as published", false, with_paper_grid(config)});
  add("nearest_obstacle", "nearest obstacle, ternary (2000)",
      [](const ComparedFrame& f) { return nearest_obstacle_grid(f.disparities, f.grid); });
  add("nearest_obstacle_paper", "nearest obstacle as in the paper",
      [parameters = paper_nearest_obstacle(config)](const ComparedFrame& f) {
        return nearest_obstacle_grid(f.disparities, f.grid, parameters);
      });
  add("occupancy_boundary", "stochastic grid, dyn. programming (2007)",
      [](const ComparedFrame& f) { return occupancy_boundary_grid(f.disparities, f.grid); });
  add("free_space", "free space of stixels (2009)",
      [](const ComparedFrame& f) { return free_space_grid(f.disparities, f.grid); });
  add("stixels", "multi-layer stixels (2011)",
      [](const ComparedFrame& f) { return stixel_grid(f.disparities, f.grid); });
  add("ray_casting", "point cloud, ray casting",
      [](const ComparedFrame& f) { return ray_casting_grid(f.disparities, f.grid); });
  if (!with_lidar) return;
  methods.push_back({"fused", "visibility grid, fused with lidar", false, config, {}, true});
  add("lidar", "lidar, inverse sensor model", [](const ComparedFrame& f) {
    if (f.sweep.empty()) return Image<float>{};
    return evaluation::lidar_grid(f.sweep, f.lidar, f.disparities.rig, f.grid, f.camera_height_m);
  });
}

void add_methods_over_time(const Config& config, bool with_lidar, Methods& methods) {
  constexpr auto models{names_of(FilterModel{})};
  for (std::size_t i{0}; i < models.size(); ++i) {
    Config filtered{config};
    filtered.filter.model = static_cast<FilterModel>(i);
    methods.push_back(
        {fmt::format("filter_{}", models[i]), fmt::format("visibility grid, filter {}", models[i]), true, filtered});
  }
  if (with_lidar) methods.push_back({"filter_fused", "fused with lidar, filtered", true, config, {}, true});
  auto map{std::make_shared<LogOddsMap>()};
  methods.push_back(
      {"ray_casting_map", "ray casting, log-odds over time", true, std::nullopt,
       [map](const ComparedFrame& f) { return map->update(f.disparities, f.world_from_vehicle, f.grid); }});
}

}  // namespace

std::vector<CompareMethod> compare_methods(const Config& config, bool with_lidar,
                                           const std::vector<std::string>& only) {
  Methods all;
  add_single_frame_methods(config, with_lidar, all);
  add_methods_over_time(config, with_lidar, all);
  if (only.empty()) return all;
  std::string known;
  for (const CompareMethod& method : all) known += (known.empty() ? "" : ", ") + method.name;
  for (const std::string& name : only) {
    if (std::none_of(all.begin(), all.end(), [&](const CompareMethod& m) { return m.name == name; })) {
      throw ConfigError{fmt::format("--only {}: there is no such method here. Known: {}.", name, known)};
    }
  }
  std::erase_if(all, [&](const CompareMethod& m) { return std::find(only.begin(), only.end(), m.name) == only.end(); });
  return all;
}

OpencvStage::OpencvStage(const std::string& name, int disparities) : disparities_{disparities} {
  if (name == "opencv-bm") matcher_ = io::OpencvMatcher::block;
  if (name == "opencv-sgbm") matcher_ = io::OpencvMatcher::semi_global;
}

void OpencvStage::match(StereoFrame& frame) const {
  if (!matcher_) return;
  frame.disparity = io::match_with_opencv(*matcher_, frame.left, frame.right, disparities_);
  frame.right = {};
}

}  // namespace stereogrid::research
