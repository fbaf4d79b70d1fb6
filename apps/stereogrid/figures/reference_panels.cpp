// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "figures/reference_panels.hpp"

#include <fmt/format.h>

#include <utility>

#include "pictures/top_view.hpp"

namespace stereogrid::app::figures {
namespace {

constexpr Colour low_colour{200, 202, 206};
constexpr Colour upright_colour{200, 40, 30};
constexpr Colour high_colour{70, 130, 200};
// what the scores against lidar count as an obstacle
constexpr double upright_from_m{0.3};
constexpr double upright_to_m{1.8};

constexpr Colour hidden_colour{160, 162, 166};
constexpr Colour hidden_obstacle_colour{205, 130, 40};

Colour colour_of(const LidarPoint& point) {
  if (point.height_m < upright_from_m) return low_colour;
  return point.height_m < upright_to_m ? upright_colour : high_colour;
}

// Shares that stand for the four states of a cell, and their colours.
constexpr float shares_of_states[]{0, 0.25F, 0.75F, 1};
constexpr Colour colours_of_states[]{{255, 255, 255}, hidden_colour, hidden_obstacle_colour, palette::ink};

float state_share(TruthCell state, bool is_occupied) {
  if (state == TruthCell::hidden) return shares_of_states[is_occupied ? 2 : 1];
  return shares_of_states[state == TruthCell::seen_occupied ? 3 : 0];
}

Colour state_colour(double share) {
  return colours_of_states[share < 0.1 ? 0 : share < 0.5 ? 1 : share < 0.9 ? 2 : 3];
}

}  // namespace

Panel scan_panel(std::string title, const std::vector<LidarPoint>& scan, const GridGeometry& grid, const Rig& rig) {
  Panel panel{empty_grid_panel(std::move(title), grid, GridSize::large)};
  const cv::Rect inside{1, 1, panel.picture.cols - 2, panel.picture.rows - 2};
  const TopView view{{0, 0, panel.picture.cols, panel.picture.rows}, grid};
  // obstacles last, so that nothing hides them
  for (const Colour layer : {low_colour, high_colour, upright_colour}) {
    for (const LidarPoint& point : scan) {
      const cv::Point at{view.at(point.x_m, point.y_m)};
      if (colour_of(point) == layer && inside.contains(at)) fill_box(panel.picture, {at.x, at.y, 2, 2}, layer);
    }
  }
  draw_rulers(panel.picture, view, rig);
  panel.keys = {{upright_colour, fmt::format("{:g} to {:g} m above the road", upright_from_m, upright_to_m)},
                {low_colour, "lower"},
                {high_colour, "higher"}};
  return panel;
}

Panel truth_panel(std::string title, const FrameTruth& truth, const GridGeometry& grid, const Rig& rig) {
  Image<float> states(truth.state.width(), truth.state.height());
  for (int iy{0}; iy < states.height(); ++iy) {
    for (int ix{0}; ix < states.width(); ++ix) {
      states(ix, iy) = state_share(static_cast<TruthCell>(truth.state(ix, iy)), truth.occupied(ix, iy) != 0);
    }
  }
  Panel panel{cells_panel(std::move(title), states, state_colour, grid, rig, GridSize::large)};
  panel.keys = {{palette::ink, "obstacle, seen"},
                {hidden_obstacle_colour, "obstacle, nothing of it seen"},
                {{255, 255, 255}, "free, seen"},
                {hidden_colour, "hidden"}};
  return panel;
}

}  // namespace stereogrid::app::figures
