// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>

#include "evaluate/figures.hpp"
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

std::string obstacles_table_of(const Json& obstacles) {
  std::string text{"\nobstacles (3–20 m ahead, from 1 s on)\n" + lines_of(obstacles, thing_figures)};
  for (const auto& [kind, counts] : obstacles.at("by_kind").items()) {
    text += figure_line("  " + kind + " with an obstacle of its own", counts.at("separate"), "",
                        counts.at("things").dump());
  }
  text += "\nobstacles followed (things and frames as above)\n" + lines_of(obstacles.at("tracking"), tracking_figures);
  const Json& errors{obstacles.at("errors")};
  return text + fmt::format("\nobstacles matched there (medians of {})\n", errors.at("matches").dump()) +
         lines_of(errors, error_figures);
}

}  // namespace

std::string table_of(const Json& evaluation) {
  std::string text;
  for (const auto& [key, value] : evaluation.at("about").items()) {
    text += fmt::format("{:<10}{}\n", key, value.is_string() ? value.get<std::string>() : value.dump());
  }
  for (const auto& [name, series] : evaluation.at("series").items()) {
    text += fmt::format("\n{}\n", name) + bands_of(series.at("bands"));
    if (series.contains("motion")) text += "\nmotion\n" + lines_of(series.at("motion"), motion_figures);
    if (series.contains("witness")) text += "\nfree cells\n" + lines_of(series.at("witness"), witness_figures);
    if (series.contains("terrain")) text += terrain_table_of(series.at("terrain"));
  }
  if (evaluation.contains("obstacles")) text += obstacles_table_of(evaluation.at("obstacles"));
  if (text.find(" clear\n") != std::string::npos) text += "\nclear: without ground that the camera cannot see.";
  text += evaluation.at("series").empty() ? "\n" : "\n± is half of the 95 % interval. ";
  return text + "Definitions: docs/evaluation.md\n";
}

}  // namespace stereogrid::app
