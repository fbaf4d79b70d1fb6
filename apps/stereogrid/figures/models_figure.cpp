// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>

#include "figures/chart.hpp"
#include "figures/colour_map.hpp"
#include "figures/equations.hpp"
#include "figures/figures.hpp"

namespace stereogrid::app::figures {
namespace {

constexpr int surface_width_px{560};
constexpr int surface_height_px{430};
constexpr int side_px{380};

/// A function of two shares as a surface.
Panel surface_panel(std::string title, const Function2& function, const Axis& x, const Axis& y,
                    const std::string& z_label) {
  Panel panel;
  panel.title = std::move(title);
  panel.picture = draw_surface(function, x, y, axis(z_label, 0, 1, 6), surface_width_px, surface_height_px);
  return panel;
}

Panel contour_panel(std::string title, const Function2& function, const Axis& x, const Axis& y,
                    const std::string& bar_label) {
  Panel panel{std::move(title), draw_contours(function, x, y, side_px, side_px), x, y};
  panel.bar = probability_bar(bar_label);
  return panel;
}

Panel confidence_panel(const UDisparityConfig& config) {
  const Axis x{axis("r_O = N_O / N_V", 0, 1, 6)};
  const Axis y{axis("P(C)", 0, 1, 6)};
  Panel panel{"(a) obstacle confidence, eq. 13", empty_chart(x, y, surface_width_px - 80, side_px), x, y};
  constexpr std::array<Colour, 3> colours{{{33, 145, 140}, {68, 1, 84}, {200, 120, 20}}};
  const std::array<double, 3> taus{config.tau_obstacle / 2, config.tau_obstacle, config.tau_obstacle * 2};
  for (std::size_t i{0}; i < taus.size(); ++i) {
    const double tau{taus[i]};
    draw_curve(
        panel.picture, [tau](double share) { return obstacle_confidence(share, tau); }, x, y, colours[i]);
    panel.keys.push_back({colours[i], fmt::format("tau_O = {:g}{}", tau, i == 1 ? ", as set" : "")});
  }
  return panel;
}

}  // namespace

io::RgbImage figure_1(const UDisparityConfig& config) {
  const Axis visibility{axis("visibility P(V)", 0, 1, 6)};
  const Axis confidence{axis("confidence P(C)", 0, 1, 6)};
  const Function2 probability = [&config](double v, double c) { return obstacle_probability(v, c, config); };
  Sheet sheet{"Figure 1. Obstacle probability P(O), eq. 4",
              {fmt::format("P_FP = {:g}, P_FN = {:g}. What nothing is seen of stays at 0.5; a cell in full view is "
                           "decided by what was found in it.",
                           config.false_positive, config.false_negative)}};
  sheet.add_row({surface_panel("(a) as a surface", probability, visibility, confidence, "P(O)"),
                 contour_panel("(b) as a map, a line at every tenth", probability, visibility, confidence, "P(O)")});
  return sheet.draw();
}

io::RgbImage figure_2(const UDisparityConfig& config) {
  const Axis seen{axis("obstacle share r_O", 0, 0.3, 7)};
  const Axis road{axis("road share r_R", 0.5, 1, 6)};
  const Function2 confidence = [&config](double o, double r) { return road_confidence(r, o, config); };
  const Axis obstacle{axis("P(O)", 0, 1, 6)};
  const Axis road_probability{axis("P(R)", 0, 1, 6)};
  const Function2 total = [&config](double o, double r) { return occupancy(o, r, config); };
  Sheet sheet{"Figure 2. Confidences and what they make of the occupancy",
              {fmt::format("tau_O = {:g}, tau_R = {:g}. r_O: filled share of the visible rays. r_R: share of the nine "
                           "bins around that hold road.",
                           config.tau_obstacle, config.tau_road)}};
  sheet.add_row(
      {confidence_panel(config), contour_panel("(b) road confidence P(R), eq. 15", confidence, seen, road, "P(R)")});
  sheet.add_row({surface_panel("(c) road confidence P(R) as a surface", confidence, seen, road, "P(R)"),
                 contour_panel("(d) occupancy P(T), eq. 14", total, obstacle, road_probability, "P(T)")});
  return sheet.draw();
}

}  // namespace stereogrid::app::figures
