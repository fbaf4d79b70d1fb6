// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "accuracy/measure.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "stereogrid/io/npz.hpp"

namespace stereogrid::bench {
namespace {

struct Pixel {
  int u;
  int v;
};

Pixel pixel_of(const TruthPoint& point) {
  return {static_cast<int>(std::lround(point.u)), static_cast<int>(std::lround(point.v))};
}

Surface label_at(const Matched& matched, Pixel at) {
  return matched.label.empty() ? Surface::other : matched.label(at.u, at.v);
}

void tally(const Matched& matched, const std::vector<TruthPoint>& points, MatcherTally& sums) {
  for (const TruthPoint& point : points) {
    const Pixel at{pixel_of(point)};
    const float disparity{matched.disparity(at.u, at.v)};
    sums.all.add(disparity, point.disparity);
    if (disparity > 0 && !matched.confidence.empty())
      sums.reliability.add(matched.confidence(at.u, at.v), is_right(disparity, point.disparity));
    if (point.surface == Surface::other) continue;
    const bool is_road{point.surface == Surface::road};
    (is_road ? sums.road : sums.obstacle).add(disparity, point.disparity);
    if (!matched.label.empty()) (is_road ? sums.road_label : sums.obstacle_label).add(label_at(matched, at), point);
  }
}

void compare(const Matched& ours, const Matched& theirs, const std::vector<TruthPoint>& points, MatcherResult& result) {
  for (const TruthPoint& point : points) {
    const Pixel at{pixel_of(point)};
    const float our_disparity{ours.disparity(at.u, at.v)};
    const float their_disparity{theirs.disparity(at.u, at.v)};
    const auto add{[&](CommonTally& common) {
      ++common.points;
      if (our_disparity <= 0 || their_disparity <= 0) return;
      common.ours.add(our_disparity, point.disparity);
      common.theirs.add(their_disparity, point.disparity);
    }};
    add(result.all);
    if (point.surface == Surface::road) add(result.road);
    if (point.surface == Surface::obstacle) add(result.obstacle);
  }
}

/// `set`, `frame` and `matcher` are places in the JSON report; surfaces: 0 other or none, 1 road, 2 obstacle.
void sample(const TruthSet& set, const MeasureOptions& options, std::size_t frame, std::size_t matcher,
            const Matched& matched, const TruthFrame& truth) {
  for (const TruthPoint& point : truth.points) {
    const Pixel at{pixel_of(point)};
    const float disparity{matched.disparity(at.u, at.v)};
    if (disparity <= 0 || at.u % set.sample_step != 0 || at.v % set.sample_step != 0) continue;
    options.samples->add({{"set", options.set_number},
                          {"frame", static_cast<double>(frame)},
                          {"matcher", static_cast<double>(matcher)},
                          {"u", at.u},
                          {"v", at.v},
                          {"surface", static_cast<double>(point.surface)},
                          {"near_contact", point.near_contact ? 1 : 0},
                          {"label", static_cast<double>(label_at(matched, at))},
                          {"disparity", disparity},
                          {"truth", point.disparity},
                          {"error", disparity - point.disparity},
                          {"road_truth", truth.plane.disparity(at.u, at.v)},
                          {"confidence", matched.confidence.empty() ? -1 : matched.confidence(at.u, at.v)}});
  }
}

std::vector<Matcher> chosen(std::vector<Matcher> matchers, const std::string& only) {
  const auto named{[&](const Matcher& matcher) { return matcher.name.find(only) != std::string::npos; }};
  std::vector<std::string> kept;
  for (const Matcher& matcher : matchers) {
    if (!named(matcher)) continue;
    kept.push_back(matcher.name);
    kept.push_back(matcher.peer);
  }
  std::erase_if(matchers, [&](const Matcher& matcher) { return std::ranges::count(kept, matcher.name) == 0; });
  return matchers;
}

}  // namespace

void Samples::add(const Row& row) {
  if (names_.empty()) {
    for (const auto& [name, value] : row) names_.push_back(name);
    columns_.resize(row.size());
  }
  for (std::size_t i{0}; i < row.size(); ++i) columns_.at(i).push_back(static_cast<float>(row[i].second));
}

void Samples::write(const std::filesystem::path& path) const {
  std::vector<io::NpzArray> arrays;
  for (std::size_t i{0}; i < names_.size(); ++i) {
    arrays.emplace_back(names_[i], std::vector<std::size_t>{columns_[i].size()}, columns_[i]);
  }
  io::write_npz(path, arrays);
}

CommonTally& CommonTally::operator+=(const CommonTally& other) {
  points += other.points;
  ours += other.ours;
  theirs += other.theirs;
  return *this;
}

SetResult& SetResult::operator+=(const SetResult& other) {
  frames += other.frames;
  points += other.points;
  for (std::size_t i{0}; i < matchers.size(); ++i) {
    matchers[i].tally += other.matchers.at(i).tally;
    matchers[i].road += other.matchers[i].road;
    matchers[i].obstacle += other.matchers[i].obstacle;
    matchers[i].all += other.matchers[i].all;
  }
  return *this;
}

SetResult measure(const TruthSet& set, const MeasureOptions& options) {
  const std::vector<Matcher> matchers{chosen(matchers_for(set, options.config), options.only)};
  SetResult result{set.name, 0, 0, {}};
  for (const Matcher& matcher : matchers) result.matchers.push_back({matcher.name, matcher.peer, {}, {}, {}, {}});
  for (std::size_t i{0}; i < set.frames; i += static_cast<std::size_t>(options.every)) {
    const TruthFrame truth{set.load(i)};
    std::fprintf(stderr, "\r%s: frame %zu of %zu ", set.name.c_str(), i + 1, set.frames);
    ++result.frames;
    result.points += static_cast<Count>(truth.points.size());
    std::map<std::string, Matched> of_opencv;
    for (std::size_t m{0}; m < matchers.size(); ++m) {
      const Matched matched{matchers[m].match(truth)};
      tally(matched, truth.points, result.matchers[m].tally);
      if (options.samples != nullptr) sample(set, options, i, m, matched, truth);
      if (matchers[m].peer.empty()) {
        of_opencv[matchers[m].name] = matched;
      } else {
        compare(matched, of_opencv.at(matchers[m].peer), truth.points, result.matchers[m]);
      }
    }
  }
  std::fprintf(stderr, "\n");
  return result;
}

}  // namespace stereogrid::bench
