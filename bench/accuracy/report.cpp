// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "accuracy/report.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace stereogrid::bench {
namespace {

using Json = nlohmann::ordered_json;

std::string disparities(const SetResult& result, const char* part, DisparityTally MatcherTally::*tally) {
  if (result.matchers.empty() || (result.matchers.front().tally.*tally).points() == 0) return {};
  std::string text{
      fmt::format("\n**{}**, {} points\n\n"
                  "| matcher | matched % | of matched > 3 px % | > 1 px % | of all > 3 px % | > 1 px % | median px |\n"
                  "|---|---|---|---|---|---|---|\n",
                  part, (result.matchers.front().tally.*tally).points())};
  for (const MatcherResult& matcher : result.matchers) {
    const DisparityTally& t{matcher.tally.*tally};
    text += fmt::format("| {} | {:.1f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} |\n", matcher.name,
                        100 * t.density(), 100 * t.wrong_by_3_of_matched(), 100 * t.wrong_by_1_of_matched(),
                        100 * t.wrong_by_3_of_all(), 100 * t.wrong_by_1_of_all(), t.median_error_px());
  }
  return text;
}

std::string labels(const SetResult& result) {
  std::string text{
      "\n**Labels**: of the matched points; away: more than 10 px from the boundary of road and obstacle\n\n"
      "| matcher | road right % | obstacle right % | road right, away % | obstacle right, away % | both right, away % "
      "| "
      "of all road called obstacle % | of all road, away % |\n|---|---|---|---|---|---|---|---|\n"};
  bool any{false};
  for (const MatcherResult& matcher : result.matchers) {
    const LabelTally& road{matcher.tally.road_label};
    const LabelTally& obstacle{matcher.tally.obstacle_label};
    if (road.points == 0) continue;
    any = true;
    LabelTally both{road};
    both += obstacle;
    text += fmt::format("| {} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} |\n", matcher.name,
                        100 * road.accuracy(), 100 * obstacle.accuracy(), 100 * road.accuracy_away(),
                        100 * obstacle.accuracy_away(), 100 * both.accuracy_away(), 100 * road.mistaken(),
                        100 * road.mistaken_away());
  }
  return any ? text : std::string{};
}

std::string common(const SetResult& result) {
  std::string text{
      "\n**On the points that both match**: ours / OpenCV's, wrong by more than 3 px (1 px), %\n\n"
      "| ours / OpenCV's | both match % | all | road | obstacle |\n|---|---|---|---|---|\n"};
  bool any{false};
  const auto pair{[](const CommonTally& c) {
    return fmt::format("{:.2f} / {:.2f} ({:.2f} / {:.2f})", 100 * c.ours.wrong_by_3_of_matched(),
                       100 * c.theirs.wrong_by_3_of_matched(), 100 * c.ours.wrong_by_1_of_matched(),
                       100 * c.theirs.wrong_by_1_of_matched());
  }};
  for (const MatcherResult& matcher : result.matchers) {
    if (matcher.peer.empty()) continue;
    any = true;
    text += fmt::format("| {} / {} | {:.1f} | {} | {} | {} |\n", matcher.name, matcher.peer,
                        100 * share(matcher.all.ours.points(), matcher.all.points), pair(matcher.all),
                        pair(matcher.road), pair(matcher.obstacle));
  }
  return any ? text : std::string{};
}

Json json_of(const DisparityTally& t) {
  return {{"points", t.points()},
          {"density", t.density()},
          {"wrong_by_3_of_matched", t.wrong_by_3_of_matched()},
          {"wrong_by_1_of_matched", t.wrong_by_1_of_matched()},
          {"wrong_by_3_of_all", t.wrong_by_3_of_all()},
          {"wrong_by_1_of_all", t.wrong_by_1_of_all()},
          {"median_error_px", t.median_error_px()}};
}

Json json_of(const LabelTally& t) {
  return {{"points", t.points},           {"matched", t.matched},           {"right", t.right},
          {"points_away", t.points_away}, {"matched_away", t.matched_away}, {"right_away", t.right_away}};
}

Json json_of(const Reliability& r) {
  Json table = Json::array();
  for (const Reliability::Bin& bin : r.table()) {
    table.push_back(
        {{"points", bin.points}, {"mean_confidence", bin.mean_confidence()}, {"right_share", bin.right_share()}});
  }
  return {{"expected_calibration_error", r.expected_calibration_error()}, {"table", table}};
}

Json json_of(const CommonTally& c) {
  return {{"points", c.points}, {"ours", json_of(c.ours)}, {"theirs", json_of(c.theirs)}};
}

Json json_of(const MatcherResult& matcher) {
  const MatcherTally& t{matcher.tally};
  Json json{
      {"name", matcher.name}, {"road", json_of(t.road)}, {"obstacle", json_of(t.obstacle)}, {"all", json_of(t.all)}};
  if (t.road_label.points != 0)
    json["labels"] = {{"road", json_of(t.road_label)}, {"obstacle", json_of(t.obstacle_label)}};
  if (t.reliability.points() != 0) json["reliability"] = json_of(t.reliability);
  if (matcher.peer.empty()) return json;
  json["common"] = {{"with", matcher.peer},
                    {"road", json_of(matcher.road)},
                    {"obstacle", json_of(matcher.obstacle)},
                    {"all", json_of(matcher.all)}};
  return json;
}

}  // namespace

std::string markdown(const Reliability& reliability, const std::string& matcher) {
  if (reliability.points() == 0) return {};
  std::string text{
      fmt::format("\n**Confidence of {}**: expected calibration error {:.3f}\n\n"
                  "| mean confidence | right to 1 px | points |\n|---|---|---|\n",
                  matcher, reliability.expected_calibration_error())};
  for (const Reliability::Bin& bin : reliability.table()) {
    if (bin.points != 0)
      text += fmt::format("| {:.3f} | {:.3f} | {} |\n", bin.mean_confidence(), bin.right_share(), bin.points);
  }
  return text;
}

std::string markdown(const SetResult& result) {
  std::string text{fmt::format("\n## {}, {} frames\n", result.name, result.frames)};
  text += disparities(result, "Road", &MatcherTally::road);
  text += disparities(result, "Obstacles", &MatcherTally::obstacle);
  text += disparities(result, "All", &MatcherTally::all);
  text += labels(result) + common(result);
  for (const MatcherResult& matcher : result.matchers) text += markdown(matcher.tally.reliability, matcher.name);
  return text;
}

std::string json(const std::vector<SetResult>& results) {
  Json sets = Json::array();
  for (const SetResult& result : results) {
    Json matchers = Json::array();
    for (const MatcherResult& matcher : result.matchers) matchers.push_back(json_of(matcher));
    sets.push_back(
        {{"name", result.name}, {"frames", result.frames}, {"points", result.points}, {"matchers", matchers}});
  }
  return Json{{"sets", sets}}.dump(2) + "\n";
}

}  // namespace stereogrid::bench
