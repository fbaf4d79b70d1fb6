// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstddef>

#include "figures/figures.hpp"
#include "figures/panels.hpp"

namespace stereogrid::app::figures {
namespace {

std::string source_line(const Material& material) {
  return fmt::format("{}, frame {}.", material.input, material.moment().frame.name);
}

/// How the filtered grids came about.
std::string filter_line(const Material& material) {
  return fmt::format("Filtered: after {} earlier frames, filter.model = {}.", material.frames_before,
                     get(material.config, "filter.model"));
}

}  // namespace

io::RgbImage figure_3(const Material& material) {
  const Moment& moment{material.moment()};
  const StageImages& stages{moment.result.stages};
  const Rig& rig{material.rig};
  const int disparities{material.config.matching.disparities};
  const auto plane = [&](std::string title, const Image<float>& shares, ColourBar bar) {
    return u_disparity_panel(std::move(title), shares, std::move(bar), rig, disparities);
  };
  const Image<std::uint16_t> road{road_counts(stages.road_disparity, stages.occupancy.height(), disparities)};
  Sheet sheet{"Figure 3. From the image to the grid", {source_line(material)}};
  sheet.add_row({camera_panel("(a) left image", moment.frame, rig),
                 count_panel("(b) obstacle pixels N_O", stages.observed, rig, disparities)});
  sheet.add_row({count_panel("(c) road pixels", road, rig, disparities),
                 plane("(d) visibility P(V)", stages.visibility, probability_bar("P(V)"))});
  sheet.add_row({plane("(e) obstacle confidence P(C)", stages.obstacle_confidence, probability_bar("P(C)")),
                 plane("(f) road confidence P(R)", stages.road_confidence, probability_bar("P(R)"))});
  sheet.add_row({plane("(g) occupancy P(T), after the Gaussian", stages.occupancy_smooth, occupancy_bar()),
                 grid_panel("(g) the same on the ground", moment.result.observed, moment.result.vehicle_grid, rig,
                            GridSize::large)});
  return sheet.draw();
}

io::RgbImage figure_4(const Material& material) {
  const FrameResult& result{material.moment().result};
  const Rig& rig{material.rig};
  const UDisparityConfig& config{material.config.u_disparity};
  const int disparities{material.config.matching.disparities};
  const auto grid = [&](std::string title, const Image<float>& occupancy) {
    return grid_panel(std::move(title), occupancy, result.vehicle_grid, rig, GridSize::small);
  };
  Sheet sheet{"Figure 4. What the Gaussian and the temporal filter do",
              {fmt::format("{} Gaussian: {:g} px along disparity, {:g} px along columns.", source_line(material),
                           config.sigma_disparity, config.sigma_column),
               filter_line(material)}};
  sheet.add_row(
      {u_disparity_panel("(a) P(T) as computed", result.stages.occupancy, occupancy_bar(), rig, disparities),
       u_disparity_panel("(b) after the Gaussian", result.stages.occupancy_smooth, occupancy_bar(), rig, disparities)});
  sheet.add_row({grid("(c) frame alone, no Gaussian", material.without_gaussian.observed),
                 grid("(d) frame alone, with it", result.observed), grid("(e) filtered", result.occupancy)});
  return sheet.draw();
}

io::RgbImage figure_7(const Material& material) {
  Sheet sheet{"Figure 7. The result on the camera image",
              {source_line(material) + " Coloured by P(T) of each pixel's "
                                       "bin of the u-disparity plane, before the Gaussian."}};
  for (std::size_t i{material.moments.size()}; i-- > 0;) {
    const Moment& moment{material.moments[i]};
    const auto letter{static_cast<char>('a' + (material.moments.size() - 1 - i))};
    Panel overlay{overlay_panel(fmt::format("({}) frame {}", letter, moment.frame.name), moment.frame, moment.result,
                                material.rig)};
    if (i == 0) overlay.keys = {{palette::upright, "upright, P(T) > 0.75"}, {palette::road, "road, P(T) < 0.4"}};
    sheet.add_row({overlay, grid_panel("frame alone", moment.result.observed, moment.result.vehicle_grid, material.rig,
                                       GridSize::small)});
  }
  return sheet.draw();
}

io::RgbImage figure_8(const Material& material) {
  const GridGeometry& cells{material.moment().result.vehicle_grid};
  Sheet sheet{"Figure 8. Influence of P_FP and P_FN", {source_line(material), filter_line(material)}};
  std::vector<Panel> alone;
  std::vector<Panel> filtered;
  for (const Variant& variant : material.error_rates) {
    const double rate{variant.config.false_positive};
    alone.push_back(grid_panel(fmt::format("frame alone, P_FP = P_FN = {:g}", rate), variant.observed, cells,
                               material.rig, GridSize::small));
    filtered.push_back(grid_panel(fmt::format("filtered, P_FP = P_FN = {:g}", rate), variant.occupancy, cells,
                                  material.rig, GridSize::small));
  }
  sheet.add_row(std::move(alone));
  sheet.add_row(std::move(filtered));
  return sheet.draw();
}

}  // namespace stereogrid::app::figures
