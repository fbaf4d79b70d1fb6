// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "evaluate/figures.hpp"
#include "evaluate/output.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr double depth_histogram_end_m{10};
constexpr double depth_histogram_step_m{0.5};

/// Null for NaN, which JSON does not have.
Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json{};
}

Json json_of(const evaluation::Summary& summary) {
  Json json{{"frames", summary.frames},           {"cells", summary.cells},
            {"occupied", summary.occupied},       {"hidden_occupied", summary.hidden_occupied},
            {"hidden_free", summary.hidden_free}, {"columns", summary.columns}};
  for (const evaluation::Metric& metric : evaluation::metrics) {
    const evaluation::Estimate& estimate{summary.*metric.estimate};
    json[std::string{metric.name}] = {
        {"value", number(estimate.value)}, {"low", number(estimate.low)}, {"high", number(estimate.high)}};
  }
  Json bins(Json::array());
  for (const evaluation::ReliabilityBin& bin : summary.reliability) {
    bins.push_back(
        {{"cells", bin.cells}, {"mean_probability", bin.mean_probability}, {"share_occupied", bin.share_occupied}});
  }
  json["reliability"] = bins;
  return json;
}

Json json_of(const std::vector<evaluation::RocPoint>& roc) {
  Json points(Json::array());
  for (const evaluation::RocPoint& point : roc) points.push_back({point.false_alarms, point.recall});
  return points;
}

/// Counts by steps of half a metre; errors beyond ±10 m are counted in the outermost.
Json histogram_of(const std::vector<float>& errors_m) {
  constexpr auto bins{static_cast<std::size_t>(2 * depth_histogram_end_m / depth_histogram_step_m)};
  std::array<std::size_t, bins> counts{};
  for (const float error : errors_m) {
    const double place{std::floor((static_cast<double>(error) + depth_histogram_end_m) / depth_histogram_step_m)};
    ++counts[static_cast<std::size_t>(std::clamp(place, 0.0, bins - 1.0))];
  }
  return {{"from_m", -depth_histogram_end_m}, {"step_m", depth_histogram_step_m}, {"columns", counts}};
}

Json frames_of(const evaluation::Scores& scores, evaluation::Band band) {
  Json frames(Json::array());
  for (const evaluation::Scores::FrameLoss& frame : scores.frame_losses(band)) {
    frames.push_back({{"name", frame.name}, {"balanced_log_loss", number(frame.balanced_log_loss)}});
  }
  return frames;
}

Json json_of(const Series& series) {
  Json bands;
  Json frames;
  for (const evaluation::Band band : evaluation::bands) {
    if (band.clear && !series.scores.has_hidden_ground()) continue;
    const std::string key{key_of(band)};
    bands[key] = json_of(series.scores.summary(band));
    bands[key]["roc"] = json_of(series.scores.roc(band));
    bands[key]["roc_hidden"] = json_of(series.scores.roc(band, evaluation::Scores::Positives::partly_hidden));
    bands[key]["depth_errors"] = histogram_of(series.scores.depth_errors_m(band));
    frames[key] = frames_of(series.scores, band);
  }
  Json json{{"bands", bands}, {"frames", frames}};
  if (series.motion) json["motion"] = values_of(series.motion->summary(), motion_figures);
  if (const auto witness{series.witness.summary()}; witness.frames > 0)
    json["witness"] = values_of(witness, witness_figures);
  const evaluation::TerrainSummary terrain{series.terrain.summary()};
  if (terrain.frames > 0) json["terrain"] = app::json_of(terrain);
  return json;
}

Json list_of_metrics() {
  Json list(Json::array());
  for (const evaluation::Metric& metric : evaluation::metrics) {
    const char* const better{metric.better == evaluation::Better::higher  ? "higher"
                             : metric.better == evaluation::Better::lower ? "lower"
                                                                          : "zero"};
    list.push_back({{"name", metric.name}, {"title", metric.title}, {"better", better}});
  }
  return list;
}

Json json_of(const evaluation::ObstacleSummary& s) {
  Json json(values_of(s, thing_figures));
  Json& kinds{json["by_kind"]};
  kinds = Json::object();
  for (const auto& [name, kind] : s.by_kind) {
    kinds[name] = {{"things", kind.things},
                   {"separate", static_cast<double>(kind.separate) / static_cast<double>(kind.things)}};
  }
  json["tracking"] = values_of(s.tracking, tracking_figures, s.has_complete_truth);
  json["errors"] = {{"matches", s.tracking.matches}};
  json["errors"].update(values_of(s, error_figures));
  return json;
}

}  // namespace

std::string key_of(evaluation::Band band) {
  return fmt::format("{:g}-{:g}{}", band.from_m, band.to_m, band.clear ? " clear" : "");
}

Json json_of(const Evaluation& evaluation) {
  Json about{{"version", version()}};
  for (const auto& [key, text] : evaluation.about) about[key] = text;
  Json series(Json::object());
  for (const Series& one : evaluation.series) series[one.name] = json_of(one);
  Json json{{"about", about}, {"metrics", list_of_metrics()}, {"series", series}};
  if (evaluation.obstacles) json["obstacles"] = json_of(*evaluation.obstacles);
  return json;
}

}  // namespace stereogrid::app
