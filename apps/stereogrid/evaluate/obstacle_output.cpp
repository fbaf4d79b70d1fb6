// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "evaluate/output.hpp"

namespace stereogrid::app {
namespace {

using Json = nlohmann::ordered_json;

/// Null for NaN, which JSON does not have, and if `known` is false.
Json number(double value, bool known = true) {
  return known && std::isfinite(value) ? Json(value) : Json{};
}

Json tracking_of(const evaluation::TrackingSummary& t, bool knows_false) {
  const auto count = [knows_false](std::size_t value) { return knows_false ? Json(value) : Json{}; };
  return {{"tracks", t.tracks},
          {"objects", t.objects},
          {"matches", t.matches},
          {"misses", t.misses},
          {"false_positives", count(t.false_positives)},
          {"id_switches", t.id_switches},
          {"fragmentations", t.fragmentations},
          {"mostly_tracked", t.mostly_tracked},
          {"mostly_lost", t.mostly_lost},
          {"mota", number(t.mota, knows_false)},
          {"motp_m", number(t.motp)},
          {"idtp", t.id_true_positives},
          {"idfp", count(t.id_false_positives)},
          {"idfn", t.id_misses},
          {"idf1", number(t.idf1, knows_false)},
          {"idp", number(t.id_precision, knows_false)},
          {"idr", number(t.id_recall)}};
}

Json errors_of(const evaluation::ObstacleSummary& s) {
  return {{"matches", s.tracking.matches},
          {"centre_m", number(s.centre_error_m)},
          {"nearest_edge_m", number(s.nearest_edge_error_m)},
          {"near_side_sigmas", number(s.near_side_sigmas)},
          {"length_m", number(s.length_error_m)},
          {"width_m", number(s.width_error_m)},
          {"movers", s.movers},
          {"speed_mps", number(s.mover_speed_error_mps)},
          {"headings", s.headings},
          {"heading_deg", number(s.heading_error_deg)}};
}

std::string line(std::string_view title, const Json& value, std::string_view unit = "") {
  const std::string text{value.is_null()           ? "–"
                         : value.is_number_float() ? fmt::format("{:.3f}", value.get<double>())
                                                   : value.dump()};
  return fmt::format("  {:<48}{:>12}{}{}\n", title, text, unit.empty() ? "" : " ", unit);
}

std::string things_of(const Json& o) {
  std::string text{
      line(fmt::format("share of {} things with an obstacle of their own", o.at("things").dump()), o.at("separate"))};
  for (const auto& [kind, counts] : o.at("by_kind").items()) {
    text += line("  " + kind, counts.at("separate"), "of " + counts.at("things").dump());
  }
  text += line("share held by any outline", o.at("found"));
  text += line("share held by extended outlines only", o.at("in_extended"));
  text += line("share merged with another thing", o.at("merged"));
  text += line("share split over several obstacles", o.at("split"));
  text += line(fmt::format("share of {} free cells inside outlines", o.at("free_cells").dump()), o.at("free_covered"));
  text += line(fmt::format("share of {} moving obstacles where nothing moves", o.at("moving").dump()),
               o.at("moving_wrong"));
  text += line(fmt::format("share of {} moving cells by standing obstacles", o.at("moving_cells").dump()),
               o.at("moving_cells_standing"));
  text += line("velocity error of things that move", o.at("speed_error_mps"), "m/s");
  text += line("area, median", o.at("area_median_m2"), "m²");
  text += line("area that 90 % do not exceed", o.at("area_p90_m2"), "m²");
  text += line("corners of an outline, mean", o.at("corners"));
  return text + line("turns above 30°", o.at("turns_per_m"), "per m");
}

std::string tracks_of(const Json& t) {
  std::string text;
  for (const auto& [title, key] : {std::pair{"MOTA", "mota"}, {"IDF1", "idf1"}, {"IDP", "idp"}, {"IDR", "idr"}}) {
    text += line(title, t.at(key));
  }
  text += line("MOTP, mean distance of centres", t.at("motp_m"), "m");
  text += line(fmt::format("misses of {} things × frames", t.at("objects").dump()), t.at("misses"));
  text += line("false positives", t.at("false_positives"));
  text += line("id switches", t.at("id_switches"));
  text += line("fragmentations", t.at("fragmentations"));
  text += line("things mostly tracked", t.at("mostly_tracked"), "of " + t.at("tracks").dump());
  return text + line("things mostly lost", t.at("mostly_lost"), "of " + t.at("tracks").dump());
}

std::string errors_text_of(const Json& e) {
  std::string text{line("error of the centre", e.at("centre_m"), "m")};
  text += line("error of the distance to the nearest edge", e.at("nearest_edge_m"), "m");
  text += line("mean distance of near sides", e.at("near_side_sigmas"), "σ");
  text += line("error of the length", e.at("length_m"), "m");
  text += line("error of the width", e.at("width_m"), "m");
  text += line(fmt::format("speed error of {} that move", e.at("movers").dump()), e.at("speed_mps"), "m/s");
  return text + line(fmt::format("heading error of {} that are said to move", e.at("headings").dump()),
                     e.at("heading_deg"), "deg");
}

}  // namespace

Json json_of(const evaluation::ObstacleSummary& s) {
  Json kinds(Json::object());
  for (const auto& [name, kind] : s.by_kind) {
    kinds[name] = {{"things", kind.things},
                   {"separate", static_cast<double>(kind.separate) / static_cast<double>(kind.things)}};
  }
  return {{"frames", s.frames},
          {"things", s.things},
          {"separate", number(s.separate)},
          {"by_kind", kinds},
          {"found", number(s.found)},
          {"in_extended", number(s.in_extended)},
          {"merged", number(s.merged)},
          {"split", number(s.split)},
          {"free_cells", s.free_cells},
          {"free_covered", number(s.free_covered)},
          {"moving", s.moving},
          {"moving_wrong", number(s.moving_wrong)},
          {"moving_cells", s.moving_cells},
          {"moving_cells_standing", number(s.moving_cells_standing)},
          {"speed_error_mps", number(s.speed_error_mps)},
          {"area_median_m2", number(s.area_median_m2)},
          {"area_p90_m2", number(s.area_p90_m2)},
          {"corners", number(s.corners)},
          {"turns_per_m", number(s.turns_per_m)},
          {"tracking", tracking_of(s.tracking, s.knows_false)},
          {"errors", errors_of(s)}};
}

std::string obstacles_table_of(const Json& obstacles) {
  return "\nobstacles (3–20 m ahead, from 1 s on)\n" + things_of(obstacles) +
         "\nobstacles followed (things and frames as above)\n" + tracks_of(obstacles.at("tracking")) +
         fmt::format("\nobstacles matched there (medians of {})\n", obstacles.at("errors").at("matches").dump()) +
         errors_text_of(obstacles.at("errors"));
}

}  // namespace stereogrid::app
