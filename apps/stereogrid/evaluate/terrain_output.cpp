// SPDX-FileCopyrightText: 2026 The stereogrid authors
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
  return {{"frames", summary.frames}, {"tolerance_m", summary.scale.tolerance_m}, {"ranges", ranges}, {"steps", steps}};
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
  return text;
}

}  // namespace stereogrid::app
