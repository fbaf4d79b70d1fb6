// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>

#include "evaluate/output.hpp"

namespace stereogrid::app {
namespace {

using Json = nlohmann::ordered_json;

/// "0.285 ± 0.021": half the width of the 95 % interval.
std::string text_of(const Json& estimate) {
  if (estimate.at("value").is_null()) return "–";
  const double value{estimate.at("value").get<double>()};
  if (estimate.at("low").is_null() || estimate.at("high").is_null()) return fmt::format("{:.3f}", value);
  const double half{(estimate.at("high").get<double>() - estimate.at("low").get<double>()) / 2};
  return fmt::format("{:.3f} ± {:.3f}", value, half);
}

template <class TextOf>
std::string row(std::string_view title, const Json& bands, TextOf text) {
  std::string line{fmt::format("  {:<24}", title)};
  for (const auto& [key, band] : bands.items()) line += fmt::format("{:>16}", text(band));
  return line + "\n";
}

std::string bands_of(const Json& bands) {
  std::string text{fmt::format("  {:<24}", "")};
  for (const auto& [key, band] : bands.items()) {
    std::string title{key};
    text += fmt::format("{:>16}", title.insert(std::min(key.find(' '), key.size()), " m"));
  }
  text += "\n";
  for (const char* count : {"cells", "occupied"}) {
    text += row(count, bands, [&](const Json& band) { return band.at(count).dump(); });
  }
  for (const evaluation::Metric& metric : evaluation::metrics) {
    if (metric.name == "hidden_recall") {
      text += row("hidden: occupied / free", bands, [](const Json& band) {
        return band.at("hidden_occupied").dump() + " / " + band.at("hidden_free").dump();
      });
    }
    text += row(metric.title, bands, [&](const Json& band) { return text_of(band.at(std::string{metric.name})); });
  }
  return text;
}

std::string line(std::string_view title, const Json& value, std::string_view unit) {
  return fmt::format("  {:<48}{:>12} {}\n", title, value.is_null() ? "–" : fmt::format("{:.3f}", value.get<double>()),
                     unit);
}

std::string motion_of(const Json& motion) {
  const auto of = [&](const char* part, const char* whole) {
    return fmt::format("{} of {}", motion.at(part).dump(), motion.at(whole).dump());
  };
  std::string text{"\nmotion (medians of moving objects, from 1 s on)\n"};
  text += fmt::format("  {:<48}{:>12}\n", "moving objects found", of("found", "sightings"));
  text += fmt::format("  {:<48}{:>12}\n", "found under another id than before", motion.at("id_switches").dump());
  text += line("speed error", motion.at("speed_error_mps"), "m/s");
  text += line("direction error", motion.at("direction_error_deg"), "deg");
  text += line("velocity error", motion.at("velocity_error_mps"), "m/s");
  text +=
      line(fmt::format("share of {} obstacles away from movers above 1 m/s", motion.at("standing_obstacles").dump()),
           motion.at("standing_with_speed"), "");
  text += line(fmt::format("velocity error of {} moving cells", motion.at("moving_cells").dump()),
               motion.at("cell_velocity_error_mps"), "m/s");
  text += line(fmt::format("share of {} static cells that seem to move", motion.at("static_cells").dump()),
               motion.at("static_moving"), "");
  text += line(fmt::format("ghost time of {} cells left", motion.at("left_cells").dump()), motion.at("ghost_s"), "s");
  text += line("share of them gone within half a second", motion.at("gone_within_half_second"), "");
  text += line(fmt::format("survival of {} hidden objects", motion.at("hidden_episodes").dump()),
               motion.at("survived_s"), "s");
  text += line("they were hidden for", motion.at("hidden_s"), "s");
  text += line(fmt::format("share of {} hidden frames with mean p ≥ 0.5", motion.at("hidden_frames").dump()),
               motion.at("hidden_alive"), "");
  return text;
}

}  // namespace

std::string table_of(const Json& evaluation) {
  std::string text;
  for (const auto& [key, value] : evaluation.at("about").items()) {
    text += fmt::format("{:<10}{}\n", key, value.is_string() ? value.get<std::string>() : value.dump());
  }
  for (const auto& [name, series] : evaluation.at("series").items()) {
    text += fmt::format("\n{}\n", name) + bands_of(series.at("bands"));
    if (series.contains("motion")) text += motion_of(series.at("motion"));
    if (series.contains("terrain")) text += terrain_table_of(series.at("terrain"));
  }
  if (evaluation.contains("obstacles")) text += obstacles_table_of(evaluation.at("obstacles"));
  if (text.find(" clear\n") != std::string::npos) text += "\nclear: without ground that the camera cannot see.";
  text += evaluation.at("series").empty() ? "\n" : "\n± is half of the 95 % interval. ";
  return text + "Definitions: docs/evaluation.md\n";
}

}  // namespace stereogrid::app
