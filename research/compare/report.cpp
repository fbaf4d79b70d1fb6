// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "compare/compare.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/console.hpp"

namespace stereogrid::research {
namespace {

using evaluation::Band;
using evaluation::Estimate;
using evaluation::Summary;
using Json = nlohmann::ordered_json;

constexpr Band table_band{3, 20};
constexpr Band clear_band{3, 20, true};

struct Column {
  const char* title;
  Estimate Summary::*estimate;
};
constexpr Column columns[]{{"log-loss", &Summary::balanced_log_loss},
                           {"AUC", &Summary::auc},
                           {"IoU occ", &Summary::iou_occupied},
                           {"IoU free", &Summary::iou_free},
                           {"missed", &Summary::missed},
                           {"known", &Summary::known},
                           {"calib.", &Summary::calibration_error},
                           {"hidden", &Summary::hidden_recall}};

double median(std::vector<double> values) {
  if (values.empty()) return std::nan("");
  const auto middle{values.begin() + std::ssize(values) / 2};
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json{};
}

void print_figures(const ComparedMethod& method, Band band) {
  const Summary summary{method.series.scores.summary(band, 0)};
  app::print("{:<42}", band.clear ? "  clear" : method.title);
  for (const Column& column : columns) {
    const double value{(summary.*column.estimate).value};
    app::print("{:>10}", std::isfinite(value) ? fmt::format("{:.3f}", value) : "–");
  }
}

}  // namespace

void print_table(const Comparison& comparison) {
  app::print("{} frames, {} with truth; cells {:g}–{:g} m ahead\n\n{:<42}", comparison.frames,
             comparison.frames_with_truth, table_band.from_m, table_band.to_m, "method");
  for (const Column& column : columns) app::print("{:>10}", column.title);
  app::print("{:>10}\n", "ms");
  bool over_time{false};
  for (const ComparedMethod& method : comparison.methods) {
    if (method.over_time && !over_time) app::print("over time\n");
    over_time = method.over_time;
    print_figures(method, table_band);
    app::print("{:>10.1f}\n", median(method.milliseconds));
    if (!method.series.scores.has_hidden_ground()) continue;
    print_figures(method, clear_band);
    app::print("\n");
  }
  app::print(
      "\nclear: without ground that the camera cannot see (lidar). hidden: recall of partly hidden obstacles at 1 %\n"
      "false alarms. ms: median from disparities and ground to the grid. Methods: docs/evaluation.md. Figures: "
      "docs/evaluation.md.\n");
}

Json json_of(const Comparison& comparison, const std::vector<std::pair<std::string, std::string>>& about) {
  app::Evaluation evaluation{about, {}};
  for (const ComparedMethod& method : comparison.methods) evaluation.series.push_back(method.series);
  Json json(app::json_of(evaluation));
  for (const ComparedMethod& method : comparison.methods) {
    Json& series{json["series"][method.series.name]};
    series["title"] = method.title;
    series["over_time"] = method.over_time;
    series["median_ms"] = number(median(method.milliseconds));
  }
  return json;
}

}  // namespace stereogrid::research
