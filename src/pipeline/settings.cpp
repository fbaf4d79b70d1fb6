// SPDX-License-Identifier: Apache-2.0
#include "pipeline/settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>

#include "clamped_to_int.hpp"
#include "geometry/road_plane.hpp"
#include "pipeline/camera_pipeline.hpp"
#include "pipeline/saved_state.hpp"
#include "stereogrid/level_mapping.hpp"

namespace stereogrid {
namespace {

// Enough disparities for a tenth of the image's width, and for the nearest road that the image shows.
int automatic_disparities(const Rig& level_rig, bool extrinsics_given) {
  const int disparities_min{extrinsics_given ? 64 : 128};  // ground of unknown extrinsics may be near
  constexpr int disparities_max{256};
  constexpr int disparities_step{16};
  const RoadPlane road{road_plane(level_rig, extrinsics_of(level_rig))};
  const int last_row{level_rig.height_px - 1};
  const double nearest_px{std::max(road.disparity(0, last_row), road.disparity(level_rig.width_px - 1, last_row))};
  const int wanted{
      std::max(level_rig.width_px / 10, clamped_to_int(std::clamp(nearest_px, 0.0, 1.0 * disparities_max)) + 2)};
  return std::clamp((wanted + disparities_step - 1) / disparities_step * disparities_step, disparities_min,
                    disparities_max);
}

// True: a ray from a point passes through the grid.
bool crosses(const GridGeometry& grid, Point2 from, double heading_rad) {
  double enters_m{0};
  double leaves_m{std::numeric_limits<double>::infinity()};
  const auto clip = [&](double at, double along, double begin, double cells) {
    const double first_m{(begin - at) / along};
    const double second_m{(begin + cells * grid.cell_size_m - at) / along};
    enters_m = std::max(enters_m, std::min(first_m, second_m));
    leaves_m = std::min(leaves_m, std::max(first_m, second_m));
  };
  clip(from.x, std::cos(heading_rad), grid.x_min_m, grid.nx);
  clip(from.y, std::sin(heading_rad), grid.y_min_m, grid.ny);
  return enters_m < leaves_m;
}

std::string_view name_of(BackEnd back_end) {
  return back_end == BackEnd::cuda ? "cuda" : back_end == BackEnd::reference ? "reference" : "cpu";
}

}  // namespace

Config resolved(Config config, std::span<const Rig> rigs, std::size_t camera, bool extrinsics_given) {
  MatchingConfig& matching{config.matching};
  if (matching.disparities == 0) {
    for (const Rig& rig : rigs) {
      const int wanted{automatic_disparities(LevelMapping{rig}.level_rig(), extrinsics_given)};
      matching.disparities = std::max(matching.disparities, wanted);
    }
  }
  const Rig level_rig{LevelMapping{rigs[camera]}.level_rig()};
  if (matching.external_sigma_per_m > 0) {
    const double sigma_px{matching.external_sigma_per_m * level_rig.focal_px * level_rig.baseline_m};
    matching.external_sigma_px = std::min(sigma_px, 10.0);
  }
  return config;
}

const Image<std::uint8_t>& mask_of(const PipelineOptions& options, std::size_t camera) {
  static const Image<std::uint8_t> none;
  if (camera == 0) return options.mask;
  return camera <= options.other_masks.size() ? options.other_masks[camera - 1] : none;
}

std::string name_of_camera(const PipelineOptions& options, std::size_t camera) {
  return options.camera_names.empty() ? "camera" + std::to_string(camera) : options.camera_names[camera];
}

bool contains_view(const GridGeometry& grid, const Rig& rig) {
  const HorizontalView view{horizontal_view(rig)};
  return std::ranges::all_of(std::array{view.left_rad, 0.0, view.right_rad}, [&](double bearing_rad) {
    return crosses(grid, {rig.camera_x_m, rig.camera_y_m}, rig.camera_yaw_rad + bearing_rad);
  });
}

std::uint64_t settings_of(const Config& config, const std::vector<Rig>& rigs, const PipelineOptions& options) {
  std::string text{version()};
  text += name_of(options.back_end);
  visit_parameters(config, [&](std::string_view group, const Parameter& parameter, const auto&) {
    const std::string key{std::string{group} + "." + std::string{parameter.name}};
    text += "\n" + key + "=" + get(config, key);
  });
  text += options.extrinsics_given ? "\nextrinsics given" : "";
  StateWriter numbers;
  std::vector<Rig> same{rigs};
  Image<std::uint8_t> mask{options.mask};
  std::vector<Image<std::uint8_t>> other_masks{options.other_masks};
  numbers(same, mask, other_masks);
  return checksum_of(numbers.bytes()) ^ checksum_of(std::as_bytes(std::span{text}));
}

}  // namespace stereogrid
