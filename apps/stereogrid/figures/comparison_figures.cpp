// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "baselines/baselines.hpp"
#include "figures/figures.hpp"
#include "figures/panels.hpp"
#include "figures/reference_panels.hpp"
#include "pictures/panels.hpp"

namespace stereogrid::app::figures {
namespace {

/// The nearest obstacle of each column ends what is known of it: free before, unknown behind.
Image<float> ternary_grid(const Material& material) {
  const FrameResult& result{material.moment().result};
  const UDisparityConfig& config{material.config.u_disparity};
  Rig level{material.rig};
  if (is_levelled(level)) level.camera_pitch_rad = 0;
  const research::DisparityFrame frame{level, result.ground, material.config.matching.disparities,
                                       result.stages.obstacle_disparity.view(), result.stages.road_disparity.view()};
  research::NearestObstacleParameters parameters;
  parameters.levels = {config.false_negative, 1 - config.false_positive};
  return research::nearest_obstacle_grid(frame, result.vehicle_grid, parameters);
}

std::string source_line(const Material& material) {
  return fmt::format("{}, frame {}. Lines: what the camera can see, and its distance.", material.input,
                     material.moment().frame.name);
}

}  // namespace

io::RgbImage figure_6(const Material& material) {
  const Moment& moment{material.moment()};
  const GridGeometry& grid{moment.result.vehicle_grid};
  const Rig& rig{material.rig};
  Sheet sheet{"Figure 6. Beside the grid of nearest obstacles", {source_line(material)}};
  std::vector<Panel> above{camera_panel("(a) left image", moment.frame, rig)};
  if (material.truth) {
    above.push_back(truth_panel("what is there", *material.truth, grid, rig));
  } else if (material.scan) {
    above.push_back(scan_panel("lidar, from above", *material.scan, grid, rig));
  }
  sheet.add_row(std::move(above));
  sheet.add_row({grid_panel("(b) visibility-based, frame alone", moment.result.observed, grid, rig, GridSize::large),
                 grid_panel("(c) nearest obstacle: free, occupied, unknown", ternary_grid(material), grid, rig,
                            GridSize::large)});
  return sheet.draw();
}

std::optional<io::RgbImage> figure_9(const Material& material) {
  if (!material.scan) return std::nullopt;
  const FrameResult& result{material.moment().result};
  const GridGeometry& grid{result.vehicle_grid};
  Sheet sheet{"Figure 9. Beside the lidar", {source_line(material)}};
  sheet.add_row({grid_panel("(a) frame alone", result.observed, grid, material.rig, GridSize::large),
                 grid_panel("(b) filtered", result.occupancy, grid, material.rig, GridSize::large),
                 scan_panel("(c) lidar, from above", *material.scan, grid, material.rig)});
  return sheet.draw();
}

}  // namespace stereogrid::app::figures
