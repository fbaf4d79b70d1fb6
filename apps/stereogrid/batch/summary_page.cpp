// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/summary_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

namespace stereogrid::app::batch {
namespace {

constexpr const char* missed{"occupancy.3-20.missed"};
constexpr const char* false_alarms{"occupancy.3-20.false_alarms"};

constexpr std::array<const char*, 12> shown{"occupancy.3-20.balanced_log_loss",
                                            missed,
                                            false_alarms,
                                            "occupancy.3-20.auc",
                                            "occupancy.3-20.known",
                                            "occupancy.3-20.depth_error_m",
                                            "occupancy.3-20.depth_overshoot",
                                            "observed.3-20.balanced_log_loss",
                                            "occupancy.motion.ghost_s",
                                            "obstacles.separate",
                                            "obstacles.found",
                                            "obstacles.speed_error_mps"};

constexpr const char* head{R"(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>stereogrid batch</title><style>
body{font:15px/1.4 sans-serif;margin:2em auto;max-width:75em;padding:0 1em;color:#222;background:#fff}
table{border-collapse:collapse;margin:1em 0}td,th{padding:.2em .7em;border-bottom:1px solid #ccc;text-align:right}
td:first-child,th:first-child{text-align:left}small{color:#666}
</style></head><body><h1>stereogrid batch</h1>
)"};

std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    safe += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : c == '"' ? "&quot;" : std::string(1, c);
  }
  return safe;
}

std::string name_of(const Json& variant) {
  std::string name;
  for (const Json& setting : variant.at("swept")) name += (name.empty() ? "" : ", ") + setting.get<std::string>();
  return name.empty() ? "as planned" : name;
}

std::string cell(const Json& figures, const std::string& name) {
  if (!figures.contains(name)) return "<td>–</td>";
  const Json& figure(figures.at(name));
  std::string text{fmt::format("<td>{:.4g}", figure.at("value").get<double>())};
  if (figure.at("low").is_number()) {
    text +=
        fmt::format(" <small>{:.4g} … {:.4g}</small>", figure.at("low").get<double>(), figure.at("high").get<double>());
  }
  return text + "</td>";
}

std::string table(const Json& variants) {
  std::vector<std::string> columns;
  for (const char* name : shown) {
    const bool known{std::ranges::any_of(variants, [&](const Json& v) { return v.at("figures").contains(name); })};
    if (known) columns.emplace_back(name);
  }
  std::string html{"<table><tr><th>configuration</th><th>drives</th><th>frames</th>"};
  for (const std::string& name : columns) html += "<th>" + name + "</th>";
  html += "</tr>\n";
  for (const Json& variant : variants) {
    html += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td>", escaped(name_of(variant)),
                        variant.at("drives").get<std::uint64_t>(), variant.at("frames").get<std::uint64_t>());
    for (const std::string& name : columns) html += cell(variant.at("figures"), name);
    html += "</tr>\n";
  }
  return html + "</table>\n";
}

struct Point {
  double x{0};
  double y{0};
  std::string name;
};

bool is_best(const Point& point, const std::vector<Point>& points) {
  return std::ranges::none_of(points, [&](const Point& other) {
    return other.x <= point.x && other.y <= point.y && (other.x < point.x || other.y < point.y);
  });
}

/// Missed against false alarms; filled: no other one is better in both.
std::string plot(const Json& variants) {
  std::vector<Point> points;
  for (const Json& variant : variants) {
    const Json& figures(variant.at("figures"));
    if (!figures.contains(missed) || !figures.contains(false_alarms)) continue;
    points.push_back({figures.at(false_alarms).at("value"), figures.at(missed).at("value"), name_of(variant)});
  }
  if (points.size() < 2) return "";
  const double x_most{std::max(1e-9, 1.1 * std::ranges::max(points, {}, &Point::x).x)};
  const double y_most{std::max(1e-9, 1.1 * std::ranges::max(points, {}, &Point::y).y)};
  std::string svg{
      "<h2>Missed and false alarms, 3 to 20 m</h2><svg width=\"640\" height=\"420\" viewBox=\"0 0 640 420\" "
      "font-size=\"12\"><path d=\"M50 10V380H630\" fill=\"none\" stroke=\"#888\"/>"};
  svg += fmt::format("<text x=\"50\" y=\"400\">0</text><text x=\"590\" y=\"400\">{:.3g}</text>", x_most);
  svg += fmt::format("<text x=\"5\" y=\"20\">{:.3g}</text><text x=\"280\" y=\"415\">false alarms</text>", y_most);
  svg += "<text x=\"5\" y=\"200\">missed</text>";
  for (const Point& point : points) {
    svg += fmt::format(
        "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"5\" stroke=\"#06c\" fill=\"{}\"><title>{}</title></circle>",
        50 + 580 * point.x / x_most, 380 - 370 * point.y / y_most, is_best(point, points) ? "#06c" : "none",
        escaped(point.name));
  }
  svg += "</svg><p>Filled, none is better in both:</p><ul>";
  for (const Point& point : points) {
    if (is_best(point, points)) svg += "<li>" + escaped(point.name) + "</li>";
  }
  return svg + "</ul>\n";
}

}  // namespace

std::string summary_page(const Json& summary) {
  const auto count = [&](const char* key) { return summary.at(key).get<std::uint64_t>(); };
  std::string html{head};
  html += fmt::format(
      "<p>{} drives, {} shards ({} missing, {} failed), {} frames, {} skipped. Version {}, plan {}.</p>\n",
      count("drives"), count("shards"), count("missing"), count("failed"), count("frames"), count("skipped"),
      escaped(summary.at("version")), summary.at("plan").get<std::string>().substr(0, 16));
  html += table(summary.at("variants"));
  html += "<p><small>Means over drives, with 95 % intervals over drives. Every figure: summary.json.</small></p>\n";
  return html + plot(summary.at("variants")) + "</body></html>\n";
}

}  // namespace stereogrid::app::batch
