// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "evaluate/output.hpp"

namespace stereogrid::app {
namespace {

using OrderedJson = nlohmann::ordered_json;

OrderedJson terrain_range_json(const evaluation::TerrainCounts& counts) {
  OrderedJson json{{"drivable", counts.drivable},
                   {"objects", counts.objects},
                   {"rises", counts.rises},
                   {"edges", counts.edges},
                   {"deadly", counts.deadly}};
  for (const evaluation::TerrainMetric& metric : evaluation::terrain_metrics) {
    const std::size_t whole{counts.*metric.whole};
    json[std::string{metric.name}] =
        whole > 0 ? OrderedJson(static_cast<double>(counts.*metric.part) / static_cast<double>(whole)) : OrderedJson{};
  }
  return json;
}

OrderedJson step_json(double height_m) {
  return std::isfinite(height_m) ? OrderedJson(height_m) : OrderedJson{};
}

OrderedJson zones_json(const std::vector<evaluation::ZoneScore>& zones) {
  std::size_t hazards{0};
  std::size_t found{0};
  std::size_t marked{0};
  OrderedJson list(OrderedJson::array());
  for (const evaluation::ZoneScore& score : zones) {
    const bool is_hazard{score.zone.is_hazard};
    hazards += is_hazard ? 1 : 0;
    found += is_hazard && score.is_found() ? 1 : 0;
    marked += !is_hazard && score.is_false() ? 1 : 0;
    list.push_back({{"kind", score.zone.kind},
                    {"is_hazard", is_hazard},
                    {"x_m", score.zone.low.x},
                    {"marks", score.marks},
                    {"marks_found", score.marks_found},
                    {"deadly", score.deadly},
                    {"deadly_free", score.deadly_free},
                    {"drivable", score.drivable},
                    {"drivable_occupied", score.drivable_occupied}});
  }
  return {{"hazards", hazards},
          {"hazards_found", found},
          {"harmless", zones.size() - hazards},
          {"harmless_marked", marked},
          {"zones", list}};
}

std::string zone_text(const OrderedJson& zone) {
  const auto of = [&](const char* part, const char* whole) {
    return fmt::format("{} of {}", zone.at(part).dump(), zone.at(whole).dump());
  };
  return fmt::format("  {:<10}{:>8.1f} m {:>8}{:>16}{:>16}{:>18}\n", zone.at("kind").get<std::string>(),
                     zone.at("x_m").get<double>(), zone.at("is_hazard").get<bool>() ? "hazard" : "",
                     of("marks_found", "marks"), of("deadly_free", "deadly"), of("drivable_occupied", "drivable"));
}

std::string course_text(const OrderedJson& course) {
  std::string text{fmt::format("  hazards found: {} of {}; harmless things marked: {} of {}\n",
                               course.at("hazards_found").dump(), course.at("hazards").dump(),
                               course.at("harmless_marked").dump(), course.at("harmless").dump())};
  text +=
      fmt::format("  {:<20} {:>8}{:>16}{:>16}{:>18}\n", "zone", "", "marks found", "deadly free", "drivable occupied");
  for (const OrderedJson& zone : course.at("zones")) text += zone_text(zone);
  return text;
}

std::string cell_text(const OrderedJson& value, const char* unit = "") {
  return value.is_null() ? "–" : fmt::format("{:.3f}{}", value.get<double>(), unit);
}

}  // namespace

OrderedJson json_of(const evaluation::TerrainSummary& summary) {
  OrderedJson ranges(OrderedJson::object());
  for (std::size_t i{0}; i < summary.ranges.size(); ++i) {
    ranges[key_of(summary.scale.ranges[i])] = terrain_range_json(summary.ranges[i]);
  }
  OrderedJson steps(OrderedJson::array());
  for (const evaluation::SmallestStep& step : summary.steps) {
    steps.push_back({{"from_m", step.range.from_m},
                     {"to_m", step.range.to_m},
                     {"up_m", step_json(step.up_m)},
                     {"down_m", step_json(step.down_m)}});
  }
  OrderedJson json{
      {"frames", summary.frames}, {"tolerance_m", summary.scale.tolerance_m}, {"ranges", ranges}, {"steps", steps}};
  if (!summary.zones.empty()) json["course"] = zones_json(summary.zones);
  return json;
}

std::string terrain_table_of(const OrderedJson& terrain) {
  std::string text{fmt::format("\nterrain ({} frames)\n  {:<24}", terrain.at("frames").dump(), "")};
  const OrderedJson& ranges{terrain.at("ranges")};
  for (const auto& [key, range] : ranges.items()) text += fmt::format("{:>16}", key + " m");
  text += "\n";
  for (const evaluation::TerrainMetric& metric : evaluation::terrain_metrics) {
    text += fmt::format("  {:<24}", metric.title);
    for (const auto& [key, range] : ranges.items()) {
      text += fmt::format("{:>16}", cell_text(range.at(std::string{metric.name})));
    }
    text += "\n";
  }
  for (const OrderedJson& step : terrain.at("steps")) {
    text += fmt::format(
        "  {:<24}up {}, down {}\n",
        fmt::format("smallest step, {:g}–{:g} m", step.at("from_m").get<double>(), step.at("to_m").get<double>()),
        cell_text(step.at("up_m"), " m"), cell_text(step.at("down_m"), " m"));
  }
  return terrain.contains("course") ? text + course_text(terrain.at("course")) : text;
}

}  // namespace stereogrid::app
