// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/evaluation/tracking.hpp"

#include <algorithm>
#include <cmath>

namespace stereogrid::evaluation {
namespace {

/// Rows are given columns one after another; potentials keep every reduced cost at 0 or above. Row and column 0 stand
/// for none.
class Assignment {
 public:
  Assignment(const std::vector<double>& costs, std::size_t rows, std::size_t columns)
      : costs_{costs},
        columns_{columns},
        row_potential_(rows + 1),
        column_potential_(columns + 1),
        row_of_(columns + 1),
        way_(columns + 1) {}

  void add(std::size_t row) {
    row_of_[0] = row;
    smallest_.assign(columns_ + 1, std::numeric_limits<double>::infinity());
    used_.assign(columns_ + 1, false);
    std::size_t column{0};
    do {
      used_[column] = true;
      column = step_from(column);
    } while (row_of_[column] != 0);
    while (column != 0) {
      const std::size_t before{way_[column]};
      row_of_[column] = row_of_[before];
      column = before;
    }
  }

  [[nodiscard]] std::size_t row_of(std::size_t column) const { return row_of_[column]; }

 private:
  /// The free column that is reached at the least cost.
  std::size_t step_from(std::size_t column) {
    const std::size_t row{row_of_[column]};
    double delta{std::numeric_limits<double>::infinity()};
    std::size_t next{0};
    for (std::size_t j{1}; j <= columns_; ++j) {
      if (used_[j]) continue;
      const double reduced{costs_[(row - 1) * columns_ + j - 1] - row_potential_[row] - column_potential_[j]};
      if (reduced < smallest_[j]) {
        smallest_[j] = reduced;
        way_[j] = column;
      }
      if (smallest_[j] < delta) {
        delta = smallest_[j];
        next = j;
      }
    }
    shift(delta);
    return next;
  }

  void shift(double delta) {
    for (std::size_t j{0}; j <= columns_; ++j) {
      if (used_[j]) {
        row_potential_[row_of_[j]] += delta;
        column_potential_[j] -= delta;
      } else {
        smallest_[j] -= delta;
      }
    }
  }

  const std::vector<double>& costs_;
  std::size_t columns_;
  std::vector<double> row_potential_;
  std::vector<double> column_potential_;
  std::vector<std::size_t> row_of_;
  std::vector<std::size_t> way_;
  std::vector<double> smallest_;
  std::vector<bool> used_;
};

/// For each row the column it is given, each column once, so that the sum of costs [row][column] is the least
/// (Hungarian method, O(rows² · columns)). Costs are finite. There are at least as many columns as rows.
std::vector<std::size_t> cheapest_columns(const std::vector<double>& costs, std::size_t rows, std::size_t columns) {
  Assignment assignment{costs, rows, columns};
  for (std::size_t row{1}; row <= rows; ++row) assignment.add(row);
  std::vector<std::size_t> column_of(rows);
  for (std::size_t j{1}; j <= columns; ++j) {
    if (assignment.row_of(j) != 0) column_of[assignment.row_of(j) - 1] = j - 1;
  }
  return column_of;
}

constexpr double mostly_tracked_from{0.8};
constexpr double mostly_lost_below{0.2};

double share(std::size_t part, std::size_t whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : TrackingSummary::nothing;
}

double distance(const TrackingFrame& frame, TrackingScores::Match pair) {
  return frame.distances[pair.object * frame.hypotheses.size() + pair.hypothesis];
}

/// Places of those that no match has taken.
template <class Place>
std::vector<std::size_t> left_over(std::size_t count, const std::vector<TrackingScores::Match>& matches, Place place) {
  std::vector<bool> taken(count);
  for (const TrackingScores::Match& match : matches) taken[match.*place] = true;
  std::vector<std::size_t> left;
  for (std::size_t i{0}; i < count; ++i) {
    if (!taken[i]) left.push_back(i);
  }
  return left;
}

/// Matches as many as can be of those that are left, with the least sum of distances.
void match_the_rest(const TrackingFrame& frame, std::vector<TrackingScores::Match>& matches) {
  const auto objects{left_over(frame.objects.size(), matches, &TrackingScores::Match::object)};
  const auto hypotheses{left_over(frame.hypotheses.size(), matches, &TrackingScores::Match::hypothesis)};
  // a column more for each object: staying alone, which costs more than all matches together
  const std::size_t columns{hypotheses.size() + objects.size()};
  double alone{1};
  for (const double d : frame.distances) alone += std::isfinite(d) ? d : 0;
  std::vector<double> costs(objects.size() * columns, alone);
  const auto for_pairs = [&](auto&& visit) {
    for (std::size_t i{0}; i < objects.size(); ++i) {
      for (std::size_t j{0}; j < hypotheses.size(); ++j) visit(i, j, distance(frame, {objects[i], hypotheses[j]}));
    }
  };
  for_pairs([&](std::size_t i, std::size_t j, double d) { costs[i * columns + j] = std::isfinite(d) ? d : 2 * alone; });
  const std::vector<std::size_t> column_of{cheapest_columns(costs, objects.size(), columns)};
  for_pairs([&](std::size_t i, std::size_t j, double d) {
    if (column_of[i] == j && std::isfinite(d)) matches.push_back({objects[i], hypotheses[j]});
  });
}

}  // namespace

std::vector<TrackingScores::Match> TrackingScores::match(const TrackingFrame& frame) const {
  std::vector<Match> matches;
  std::vector<bool> taken(frame.hypotheses.size());
  for (std::size_t i{0}; i < frame.objects.size(); ++i) {
    const auto track{tracks_.find(frame.objects[i])};
    if (track == tracks_.end() || !track->second.hypothesis) continue;
    for (std::size_t j{0}; j < frame.hypotheses.size(); ++j) {
      const bool had{frame.hypotheses[j].id == *track->second.hypothesis};
      if (!had || taken[j] || !std::isfinite(distance(frame, {i, j}))) continue;
      taken[j] = true;
      matches.push_back({i, j});
      break;
    }
  }
  match_the_rest(frame, matches);
  std::ranges::sort(matches, {}, &Match::object);
  return matches;
}

std::vector<TrackingScores::Match> TrackingScores::add(const TrackingFrame& frame) {
  std::vector<Match> matches{match(frame)};
  follow(frame, matches);
  std::vector<bool> counted;
  for (const TrackingFrame::Hypothesis& hypothesis : frame.hypotheses) counted.push_back(!hypothesis.ignored);
  false_positives_ += static_cast<std::size_t>(std::ranges::count(counted, true));
  for (const Match& match : matches) {
    if (counted[match.hypothesis]) --false_positives_;
    counted[match.hypothesis] = true;
    distance_sum_ += distance(frame, match);
  }
  count_identities(frame, counted);
  return matches;
}

void TrackingScores::follow(const TrackingFrame& frame, const std::vector<Match>& matches) {
  auto next{matches.begin()};
  for (std::size_t i{0}; i < frame.objects.size(); ++i) {
    Track& track{tracks_[frame.objects[i]]};
    ++track.frames;
    if (next == matches.end() || next->object != i) {
      track.missed = track.hypothesis.has_value();
      continue;
    }
    const std::int64_t id{frame.hypotheses[next->hypothesis].id};
    ++next;
    ++track.matched;
    if (track.missed) ++track.fragmentations;
    if (track.hypothesis && *track.hypothesis != id) ++id_switches_;
    track.hypothesis = id;
    track.missed = false;
  }
}

void TrackingScores::count_identities(const TrackingFrame& frame, const std::vector<bool>& counted) {
  for (std::size_t j{0}; j < frame.hypotheses.size(); ++j) {
    if (!counted[j]) continue;
    ++hypotheses_;
    for (std::size_t i{0}; i < frame.objects.size(); ++i) {
      if (std::isfinite(distance(frame, {i, j}))) ++together_[{frame.objects[i], frame.hypotheses[j].id}];
    }
  }
}

/// One hypothesis for each object over the whole drive, so that they are together in as many frames as can be.
void TrackingScores::add_identities(TrackingSummary& summary) const {
  std::map<std::int64_t, std::size_t> rows;
  std::map<std::int64_t, std::size_t> columns;
  for (const auto& [pair, frames] : together_) {
    rows.emplace(pair.first, rows.size());
    columns.emplace(pair.second, columns.size());
  }
  const std::size_t width{columns.size() + rows.size()};  // and a column for each that stays alone
  std::vector<double> costs(rows.size() * width);
  for (const auto& [pair, frames] : together_) {
    costs[rows[pair.first] * width + columns[pair.second]] = -static_cast<double>(frames);
  }
  const std::vector<std::size_t> column_of{cheapest_columns(costs, rows.size(), width)};
  for (const auto& [pair, frames] : together_) {
    if (column_of[rows[pair.first]] == columns[pair.second]) summary.id_true_positives += frames;
  }
  summary.id_false_positives = hypotheses_ - summary.id_true_positives;
  summary.id_misses = summary.objects - summary.id_true_positives;
  summary.id_precision = share(summary.id_true_positives, hypotheses_);
  summary.id_recall = share(summary.id_true_positives, summary.objects);
  summary.idf1 = share(2 * summary.id_true_positives, hypotheses_ + summary.objects);
}

TrackingSummary TrackingScores::summary() const {
  TrackingSummary summary;
  summary.tracks = tracks_.size();
  for (const auto& [id, track] : tracks_) {
    summary.objects += track.frames;
    summary.matches += track.matched;
    summary.fragmentations += track.fragmentations;
    const double matched{share(track.matched, track.frames)};
    if (matched >= mostly_tracked_from) ++summary.mostly_tracked;
    if (matched < mostly_lost_below) ++summary.mostly_lost;
  }
  summary.misses = summary.objects - summary.matches;
  summary.false_positives = false_positives_;
  summary.id_switches = id_switches_;
  if (summary.objects > 0) {
    const auto errors{static_cast<double>(summary.misses + false_positives_ + id_switches_)};
    summary.mota = 1 - errors / static_cast<double>(summary.objects);
  }
  if (summary.matches > 0) summary.motp = distance_sum_ / static_cast<double>(summary.matches);
  add_identities(summary);
  return summary;
}

}  // namespace stereogrid::evaluation
