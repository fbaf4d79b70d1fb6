// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/figures.hpp"

#include <algorithm>
#include <cmath>
#include <random>

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

/// The ends of the middle 95 % of means of drives drawn with replacement.
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

}  // namespace stereogrid::app::batch
