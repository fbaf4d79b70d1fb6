// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>

#include "stereogrid/evaluation/motion.hpp"
#include "stereogrid/evaluation/obstacles.hpp"
#include "stereogrid/evaluation/terrain.hpp"

namespace stereogrid::app {

/// A figure of a summary: the one declaration for the JSON, the terminal and the page.
template <class Summary>
struct Figure {
  std::string_view name;  ///< key in the JSON
  std::variant<double Summary::*, std::size_t Summary::*> member;
  std::string_view title{};  ///< empty: only in the JSON, or the whole of another figure
  std::string_view unit{};
  std::string_view whole{};  ///< name of the count that it is a part or a median of
  bool needs_false{false};   ///< undefined unless the truth shows which obstacles are false
};

using Motion = evaluation::MotionSummary;
inline constexpr Figure<Motion> motion_figures[]{
    {"sightings", &Motion::sightings},
    {"found", &Motion::found, "moving objects found, from 1 s on", "", "sightings"},
    {"speed_error_mps", &Motion::speed_error_mps, "speed error, median", "m/s"},
    {"direction_error_deg", &Motion::direction_error_deg, "direction error, median", "°"},
    {"velocity_error_mps", &Motion::velocity_error_mps, "velocity error, median", "m/s"},
    {"id_switches", &Motion::id_switches, "found under another id than before"},
    {"standing_obstacles", &Motion::standing_obstacles},
    {"standing_with_speed", &Motion::standing_with_speed, "obstacles away from movers above 1 m/s", "",
     "standing_obstacles"},
    {"moving_cells", &Motion::moving_cells},
    {"cell_velocity_error_mps", &Motion::cell_velocity_error_mps, "velocity error of moving cells, median", "m/s",
     "moving_cells"},
    {"static_cells", &Motion::static_cells},
    {"static_moving", &Motion::static_moving, "static cells that seem to move", "", "static_cells"},
    {"left_cells", &Motion::left_cells},
    {"ghost_s", &Motion::ghost_s, "ghost time of cells left, median", "s", "left_cells"},
    {"gone_within_half_second", &Motion::gone_within_half_second, "cells left, gone within half a second"},
    {"hidden_episodes", &Motion::hidden_episodes},
    {"hidden_frames", &Motion::hidden_frames},
    {"hidden_alive", &Motion::hidden_alive, "hidden frames with mean p ≥ 0.5", "", "hidden_frames"},
    {"hidden_s", &Motion::hidden_s, "hidden objects, time hidden, median", "s", "hidden_episodes"},
    {"survived_s", &Motion::survived_s, "hidden objects, survival, median", "s", "hidden_episodes"}};

using Witnesses = evaluation::WitnessSummary;
inline constexpr Figure<Witnesses> witness_figures[]{
    {"ground", &Witnesses::ground},
    {"ground_occupied", &Witnesses::ground_occupied, "free by ground, occupied in truth", "", "ground"},
    {"memory", &Witnesses::memory},
    {"memory_occupied", &Witnesses::memory_occupied, "free by memory, occupied in truth", "", "memory"},
    {"source", &Witnesses::source},
    {"source_occupied", &Witnesses::source_occupied, "free by a source, occupied in truth", "", "source"},
    {"frames", &Witnesses::frames},
    {"failed", &Witnesses::failed, "frames with such a cell", "", "frames"},
    {"failed_at_most", &Witnesses::failed_at_most, "where there is none, at most (95 %)"}};

using Obstacles = evaluation::ObstacleSummary;
inline constexpr Figure<Obstacles> thing_figures[]{
    {"frames", &Obstacles::frames},
    {"things", &Obstacles::things},
    {"separate", &Obstacles::separate, "things with an obstacle of their own", "", "things"},
    {"found", &Obstacles::found, "things held by any outline"},
    {"in_extended", &Obstacles::in_extended, "things held by boundaries only"},
    {"merged", &Obstacles::merged, "things merged with another one"},
    {"split", &Obstacles::split, "things split over several obstacles"},
    {"free_cells", &Obstacles::free_cells},
    {"free_covered", &Obstacles::free_covered, "free cells inside outlines", "", "free_cells"},
    {"moving", &Obstacles::moving},
    {"moving_wrong", &Obstacles::moving_wrong, "moving obstacles where nothing moves", "", "moving"},
    {"moving_cells", &Obstacles::moving_cells},
    {"moving_cells_standing", &Obstacles::moving_cells_standing, "moving cells at static obstacles", "",
     "moving_cells"},
    {"speed_error_mps", &Obstacles::speed_error_mps, "velocity error of moving things, median", "m/s"},
    {"area_median_m2", &Obstacles::area_median_m2, "area, median", "m²"},
    {"area_p90_m2", &Obstacles::area_p90_m2, "area that 90 % do not exceed", "m²"},
    {"corners", &Obstacles::corners, "corners of an outline, mean"},
    {"turns_per_m", &Obstacles::turns_per_m, "turns above 30°", "per m"}};

using Tracking = evaluation::TrackingSummary;
inline constexpr Figure<Tracking> tracking_figures[]{
    {"tracks", &Tracking::tracks},
    {"objects", &Tracking::objects},
    {"matches", &Tracking::matches},
    {"misses", &Tracking::misses, "misses", "", "objects"},
    {"false_positives", &Tracking::false_positives, "false positives", "", "", true},
    {"id_switches", &Tracking::id_switches, "id switches"},
    {"fragmentations", &Tracking::fragmentations, "fragmentations"},
    {"mostly_tracked", &Tracking::mostly_tracked, "things mostly tracked", "", "tracks"},
    {"mostly_lost", &Tracking::mostly_lost, "things mostly lost", "", "tracks"},
    {"mota", &Tracking::mota, "MOTA", "", "", true},
    {"motp_m", &Tracking::motp, "MOTP, mean distance of centres", "m"},
    {"idtp", &Tracking::id_true_positives},
    {"idfp", &Tracking::id_false_positives, "", "", "", true},
    {"idfn", &Tracking::id_misses},
    {"idf1", &Tracking::idf1, "IDF1", "", "", true},
    {"idp", &Tracking::id_precision, "IDP", "", "", true},
    {"idr", &Tracking::id_recall, "IDR"}};

/// Medians over the matches.
inline constexpr Figure<Obstacles> error_figures[]{
    {"centre_m", &Obstacles::centre_error_m, "error of the centre", "m"},
    {"nearest_edge_m", &Obstacles::nearest_edge_error_m, "error of the distance to the nearest edge", "m"},
    {"near_side_sigmas", &Obstacles::near_side_sigmas, "mean distance of near sides", "σ"},
    {"length_m", &Obstacles::length_error_m, "error of the length", "m"},
    {"width_m", &Obstacles::width_error_m, "error of the width", "m"},
    {"movers", &Obstacles::movers},
    {"speed_mps", &Obstacles::mover_speed_error_mps, "speed error of moving things", "m/s", "movers"},
    {"headings", &Obstacles::headings},
    {"heading_deg", &Obstacles::heading_error_deg, "heading error of reported movers", "°", "headings"}};

/// Values by name; null: undefined.
template <class Summary, std::size_t count>
[[nodiscard]] nlohmann::ordered_json values_of(const Summary& summary, const Figure<Summary> (&figures)[count],
                                               bool has_complete_truth = true) {
  nlohmann::ordered_json json(nlohmann::ordered_json::object());
  for (const Figure<Summary>& figure : figures) {
    auto& value{json[std::string{figure.name}]};
    std::visit(
        [&](const auto member) {
          const auto number{summary.*member};
          if ((has_complete_truth || !figure.needs_false) && std::isfinite(static_cast<double>(number))) value = number;
        },
        figure.member);
  }
  return json;
}

/// A line of the terminal: a count as it is, a number with three decimals, and the count that it is a share or a median
/// of.
[[nodiscard]] inline std::string figure_line(std::string_view title, const nlohmann::ordered_json& value,
                                             std::string_view unit = "", std::string_view whole = "") {
  const std::string text{value.is_null()           ? "–"
                         : value.is_number_float() ? fmt::format("{:.3f}", value.get<double>())
                                                   : value.dump()};
  if (unit.empty()) return fmt::format("  {:<48}{:>12}{}{}\n", title, text, whole.empty() ? "" : " of ", whole);
  return fmt::format("  {:<48}{:>12} {}{}\n", title, text, unit, whole.empty() ? "" : fmt::format(" ({})", whole));
}

/// Lines of the figures that have a title, from values_of.
template <class Summary, std::size_t count>
[[nodiscard]] std::string lines_of(const nlohmann::ordered_json& values, const Figure<Summary> (&figures)[count]) {
  std::string text;
  for (const Figure<Summary>& figure : figures) {
    if (figure.title.empty()) continue;
    const std::string whole{figure.whole.empty() ? "" : values.at(std::string{figure.whole}).dump()};
    text += figure_line(figure.title, values.at(std::string{figure.name}), figure.unit, whole);
  }
  return text;
}

/// The declarations of figures that have a title, for the page.
template <class Summary, std::size_t count>
[[nodiscard]] nlohmann::ordered_json declarations_of(const Figure<Summary> (&figures)[count]) {
  nlohmann::ordered_json list(nlohmann::ordered_json::array());
  for (const Figure<Summary>& figure : figures) {
    if (figure.title.empty()) continue;
    list.push_back({{"name", figure.name},
                    {"title", figure.title},
                    {"unit", figure.unit},
                    {"whole", figure.whole},
                    {"is_count", std::holds_alternative<std::size_t Summary::*>(figure.member)}});
  }
  return list;
}

}  // namespace stereogrid::app
