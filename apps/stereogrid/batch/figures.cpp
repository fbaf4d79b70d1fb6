// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "batch/merge.hpp"
#include "batch/results.hpp"

namespace stereogrid::app::batch {
namespace {

constexpr std::size_t resamples{1000};
constexpr double normal_95{1.96};

void add_numbers(const Json& object, const std::string& prefix, double frames, Figures& figures) {
  for (const auto& [key, value] : object.items()) {
    if (value.is_number()) figures[prefix + key] = {value.get<double>(), frames};
  }
}

void add_band(const Json& band, const std::string& prefix, Figures& figures) {
  const double frames{band.value("frames", 0.0)};
  for (const auto& [key, value] : band.items()) {
    if (!value.is_object() || !value.contains("value") || !value.at("value").is_number()) continue;
    figures[prefix + key] = {value.at("value").get<double>(), frames};
  }
}

/// Sets the ends of the middle 95 % of means of drives drawn with replacement.
void bootstrap(const std::vector<double>& values, FigureOverDrives& figure) {
  std::mt19937_64 random{20120901};
  std::vector<double> means(resamples);
  for (double& mean : means) {
    double sum{0};
    for (std::size_t i{0}; i < values.size(); ++i) sum += values[random() % values.size()];
    mean = sum / static_cast<double>(values.size());
  }
  std::sort(means.begin(), means.end());
  figure.low = means[resamples * 25 / 1000];
  figure.high = means[resamples * 975 / 1000 - 1];
}

constexpr const char* missed{"occupancy.3-20.missed"};
constexpr const char* false_alarms{"occupancy.3-20.false_alarms"};

struct Column {
  const char* figure;
  const char* heading;
};
constexpr std::array<Column, 12> shown{{{"occupancy.3-20.balanced_log_loss", "log-loss"},
                                        {missed, "missed"},
                                        {false_alarms, "false alarms"},
                                        {"occupancy.3-20.auc", "AUC"},
                                        {"occupancy.3-20.known", "known"},
                                        {"occupancy.3-20.depth_error_m", "depth error, m"},
                                        {"occupancy.3-20.depth_overshoot", "too deep"},
                                        {"observed.3-20.balanced_log_loss", "log-loss, single frame"},
                                        {"occupancy.motion.ghost_s", "ghosts, s"},
                                        {"obstacles.separate", "things separate"},
                                        {"obstacles.found", "things found"},
                                        {"obstacles.speed_error_mps", "speed error, m/s"}}};

constexpr const char* head{R"(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>stereogrid batch</title><style>
body{font:15px/1.4 sans-serif;margin:2em auto;max-width:75em;padding:0 1em;color:#222;background:#fff}
table{border-collapse:collapse;margin:1em 0}td,th{padding:.2em .7em;border-bottom:1px solid #ccc;text-align:right}
td{white-space:nowrap}td:first-child,th:first-child{text-align:left}small{color:#666}.wide{overflow-x:auto}
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
  std::string text{fmt::format("<td>{:.3g}", figure.at("value").get<double>())};
  if (figure.at("low").is_number()) {
    text += fmt::format("<br><small>{:.3g} … {:.3g}</small>", figure.at("low").get<double>(),
                        figure.at("high").get<double>());
  }
  return text + "</td>";
}

std::string table(const Json& variants) {
  std::vector<Column> columns;
  for (const Column& column : shown) {
    const bool known{
        std::ranges::any_of(variants, [&](const Json& v) { return v.at("figures").contains(column.figure); })};
    if (known) columns.push_back(column);
  }
  std::string html{"<div class=\"wide\"><table><tr><th>configuration</th><th>drives</th><th>frames</th>"};
  for (const Column& column : columns) html += fmt::format("<th>{}</th>", column.heading);
  html += "</tr>\n";
  for (const Json& variant : variants) {
    html += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td>", escaped(name_of(variant)),
                        variant.at("drives").get<std::uint64_t>(), variant.at("frames").get<std::uint64_t>());
    for (const Column& column : columns) html += cell(variant.at("figures"), column.figure);
    html += "</tr>\n";
  }
  return html + "</table></div>\n";
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

/// Range of an axis, with a margin.
struct Extent {
  Extent(const std::vector<Point>& points, double Point::*of)
      : least{std::ranges::min(points, {}, of).*of}, most{std::ranges::max(points, {}, of).*of} {
    const double margin{most > least ? 0.1 * (most - least) : 0.1 * std::abs(most) + 1e-9};
    least -= margin;
    most += margin;
  }
  [[nodiscard]] double share(double value) const { return (value - least) / (most - least); }

  double least;
  double most;
};

/// Scatter plot as SVG; points on the Pareto front are filled.
std::string drawing(const std::vector<Point>& points) {
  const Extent x{points, &Point::x};
  const Extent y{points, &Point::y};
  std::string svg{
      "<svg width=\"700\" height=\"430\" viewBox=\"0 0 700 430\" font-size=\"12\">"
      "<path d=\"M70 10V380H690\" fill=\"none\" stroke=\"#888\"/>"};
  svg +=
      fmt::format("<text x=\"70\" y=\"398\">{:.3g}</text><text x=\"690\" y=\"398\" text-anchor=\"end\">{:.3g}</text>",
                  x.least, x.most);
  svg += fmt::format(
      "<text x=\"65\" y=\"20\" text-anchor=\"end\">{:.3g}</text><text x=\"65\" y=\"380\" "
      "text-anchor=\"end\">{:.3g}</text>",
      y.most, y.least);
  svg += "<text x=\"380\" y=\"415\" text-anchor=\"middle\">false alarms</text><text x=\"5\" y=\"200\">missed</text>";
  for (const Point& point : points) {
    svg += fmt::format(
        "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"5\" stroke=\"#06c\" fill=\"{}\"><title>{}</title></circle>",
        70 + 620 * x.share(point.x), 380 - 370 * y.share(point.y), is_best(point, points) ? "#06c" : "none",
        escaped(point.name));
  }
  return svg + "</svg>";
}

std::string plot(const Json& variants) {
  std::vector<Point> points;
  for (const Json& variant : variants) {
    const Json& figures(variant.at("figures"));
    if (!figures.contains(missed) || !figures.contains(false_alarms)) continue;
    points.push_back({figures.at(false_alarms).at("value"), figures.at(missed).at("value"), name_of(variant)});
  }
  if (points.size() < 2) return "";
  std::string html{"<h2>Missed and false alarms, 3 to 20 m</h2>" + drawing(points) +
                   "<p>Filled, none is better in both:</p><ul>"};
  for (const Point& point : points) {
    if (is_best(point, points)) html += "<li>" + escaped(point.name) + "</li>";
  }
  return html + "</ul>\n";
}

}  // namespace

Figures figures_of(const Json& evaluation, double frames) {
  Figures figures;
  for (const auto& [name, series] : evaluation.at("series").items()) {
    for (const auto& [band, values] : series.at("bands").items()) add_band(values, name + '.' + band + '.', figures);
    if (series.contains("motion")) add_numbers(series.at("motion"), name + ".motion.", frames, figures);
  }
  if (evaluation.contains("obstacles")) add_numbers(evaluation.at("obstacles"), "obstacles.", frames, figures);
  return figures;
}

Json to_json(const Figures& figures) {
  Json json(Json::object());
  for (const auto& [name, figure] : figures) json[name] = {figure.value, figure.frames};
  return json;
}

Figures figures_in(const Json& json) {
  Figures figures;
  for (const auto& [name, figure] : json.items()) figures[name] = {figure.at(0), figure.at(1)};
  return figures;
}

void add_part(Figures& drive, const Figures& part) {
  for (const auto& [name, figure] : part) {
    Figure& all{drive[name]};
    const double frames{all.frames + figure.frames};
    if (frames > 0) all.value = (all.value * all.frames + figure.value * figure.frames) / frames;
    all.frames = frames;
  }
}

void FiguresOverDrives::add(const Figures& drive) {
  for (const auto& [name, figure] : drive) {
    if (!(figure.frames > 0)) continue;
    Sums& sums{sums_[name]};
    ++sums.drives;
    sums.sum += figure.value;
    sums.sum_of_squares += figure.value * figure.value;
    if (sums.kept.size() <= most_kept) sums.kept.push_back(figure.value);
  }
}

std::map<std::string, FigureOverDrives> FiguresOverDrives::means() const {
  std::map<std::string, FigureOverDrives> figures;
  for (const auto& [name, sums] : sums_) {
    const auto drives{static_cast<double>(sums.drives)};
    FigureOverDrives& figure{figures[name]};
    figure.value = sums.sum / drives;
    figure.drives = sums.drives;
    if (sums.drives < 2) continue;
    if (sums.drives <= most_kept) {
      bootstrap(sums.kept, figure);
    } else {
      const double variance{std::max(0.0, sums.sum_of_squares / drives - figure.value * figure.value)};
      const double half{normal_95 * std::sqrt(variance / (drives - 1))};
      figure.low = figure.value - half;
      figure.high = figure.value + half;
    }
  }
  return figures;
}

std::string summary_page(const Json& summary) {
  const auto count = [&](const char* key) { return summary.at(key).get<std::uint64_t>(); };
  std::string html{head};
  html += fmt::format(
      "<p>{} drives, {} shards ({} missing, {} failed), {} of {} frames, {} skipped. Version {}, plan {}.</p>\n",
      count("drives"), count("shards"), count("missing"), count("failed"), count("frames"), count("planned"),
      count("skipped"), escaped(summary.at("version")), summary.at("plan").get<std::string>().substr(0, 16));
  html += table(summary.at("variants"));
  html +=
      "<p><small>Filtered grids, 3 to 20 m ahead. Means over drives, with 95 % intervals over drives. Every figure: "
      "summary.json; –: not scored, see parts.jsonl.</small></p>\n";
  return html + plot(summary.at("variants")) + "</body></html>\n";
}

}  // namespace stereogrid::app::batch
