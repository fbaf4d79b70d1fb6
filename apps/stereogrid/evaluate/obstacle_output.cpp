// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "evaluate/figures.hpp"
#include "evaluate/output.hpp"

namespace stereogrid::app {

nlohmann::ordered_json json_of(const evaluation::ObstacleSummary& s) {
  nlohmann::ordered_json json(values_of(s, thing_figures));
  nlohmann::ordered_json& kinds{json["by_kind"]};
  kinds = nlohmann::ordered_json::object();
  for (const auto& [name, kind] : s.by_kind) {
    kinds[name] = {{"things", kind.things},
                   {"separate", static_cast<double>(kind.separate) / static_cast<double>(kind.things)}};
  }
  json["tracking"] = values_of(s.tracking, tracking_figures, s.knows_false);
  json["errors"] = {{"matches", s.tracking.matches}};
  json["errors"].update(values_of(s, error_figures));
  return json;
}

std::string obstacles_table_of(const nlohmann::ordered_json& obstacles) {
  std::string text{"\nobstacles (3–20 m ahead, from 1 s on)\n" + lines_of(obstacles, thing_figures)};
  for (const auto& [kind, counts] : obstacles.at("by_kind").items()) {
    text += figure_line("  " + kind + " with an obstacle of its own", counts.at("separate"), "",
                        counts.at("things").dump());
  }
  text += "\nobstacles followed (things and frames as above)\n" + lines_of(obstacles.at("tracking"), tracking_figures);
  const nlohmann::ordered_json& errors{obstacles.at("errors")};
  return text + fmt::format("\nobstacles matched there (medians of {})\n", errors.at("matches").dump()) +
         lines_of(errors, error_figures);
}

}  // namespace stereogrid::app
