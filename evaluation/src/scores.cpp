// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/evaluation/scores.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "totals.hpp"

namespace stereogrid::evaluation {
namespace {

constexpr std::size_t coarse_groups{512};  // for resamples: their ranks are rounded, those of the point estimates are
                                           // not
constexpr std::size_t frames_for_an_interval{5};

/// Cells of a frame within a band.
struct InBand {
  std::vector<Scores::Cell> cells;
  std::vector<ColumnDepth> columns;
};

std::vector<double> probabilities_of(const std::vector<InBand>& frames) {
  std::vector<double> values;
  for (const InBand& frame : frames) {
    for (const Scores::Cell& cell : frame.cells) values.push_back(clipped(cell.probability));
  }
  return values;
}

std::vector<double> errors_of(const std::vector<InBand>& frames) {
  std::vector<double> values;
  for (const InBand& frame : frames) {
    for (const ColumnDepth& column : frame.columns) values.push_back(depth_error(column));
  }
  return values;
}

Totals totals_of(const InBand& frame, const Ranking& probabilities, const Ranking& errors) {
  Totals totals{probabilities.size(), errors.size()};
  for (const Scores::Cell& cell : frame.cells) totals.add(cell, probabilities);
  for (const ColumnDepth& column : frame.columns) totals.add(column, errors);
  return totals;
}

void fill_counts(const Totals& totals, Summary& summary) {
  const auto whole = [](double count) { return static_cast<std::size_t>(count); };
  summary.cells = whole(totals.occupied + totals.free);
  summary.occupied = whole(totals.occupied);
  summary.hidden_occupied = whole(totals.hidden_occupied);
  for (const GroupCounts& group : totals.groups) summary.hidden_free += whole(group.hidden_free);
  summary.columns = whole(totals.columns);
  for (std::size_t i{0}; i < reliability_bins; ++i) {
    const CalibrationBin& bin{totals.bins[i]};
    if (bin.cells > 0)
      summary.reliability[i] = {whole(bin.cells), bin.probability / bin.cells, bin.occupied / bin.cells};
  }
}

/// The figures of the drive as it is, with exact ranks.
void fill_point(const std::vector<InBand>& frames, Summary& summary) {
  std::vector<double> values{probabilities_of(frames)};
  const std::size_t all{values.size()};
  const Ranking exact{std::move(values), all};
  std::vector<double> errors{errors_of(frames)};
  const std::size_t all_errors{errors.size()};
  const Ranking exact_errors{std::move(errors), all_errors};
  Totals totals{exact.size(), exact_errors.size()};
  for (const InBand& frame : frames) {
    for (const Scores::Cell& cell : frame.cells) totals.add(cell, exact);
    for (const ColumnDepth& column : frame.columns) totals.add(column, exact_errors);
    summary.frames += frame.cells.empty() ? 0 : 1;
  }
  fill_counts(totals, summary);
  fill_values(totals, exact_errors, summary);
}

void fill_intervals(const std::vector<InBand>& frames, int resamples, Summary& summary) {
  const Ranking probabilities{probabilities_of(frames), coarse_groups};
  const Ranking errors{errors_of(frames), coarse_groups};
  std::vector<Totals> by_frame;
  for (const InBand& frame : frames) by_frame.push_back(totals_of(frame, probabilities, errors));
  std::array<std::vector<double>, metrics.size()> drawn;
  BlockResampler resampler{frames.size()};
  for (int i{0}; i < resamples; ++i) {
    Totals totals{probabilities.size(), errors.size()};
    const std::vector<int>& times{resampler.draw()};
    for (std::size_t frame{0}; frame < frames.size(); ++frame) {
      for (int k{0}; k < times[frame]; ++k) totals += by_frame[frame];
    }
    Summary resample;
    fill_values(totals, errors, resample);
    for (std::size_t m{0}; m < metrics.size(); ++m) drawn[m].push_back((resample.*metrics[m].estimate).value);
  }
  for (std::size_t m{0}; m < metrics.size(); ++m) {
    Estimate& estimate{summary.*metrics[m].estimate};
    if (std::isnan(estimate.value)) continue;
    estimate.low = quantile(drawn[m], 0.025);
    estimate.high = quantile(drawn[m], 0.975);
  }
}

template <class Frames, class Contains>
std::vector<InBand> frames_in(const Frames& frames, Band band, Contains contains) {
  std::vector<InBand> chosen;
  for (const auto& frame : frames) {
    InBand& in{chosen.emplace_back()};
    std::ranges::copy_if(frame.cells, std::back_inserter(in.cells), contains);
    std::ranges::copy_if(frame.columns, std::back_inserter(in.columns), [band](const ColumnDepth& column) {
      return static_cast<double>(column.truth_m) >= band.from_m && static_cast<double>(column.truth_m) < band.to_m;
    });
  }
  return chosen;
}

bool touches_occupied(const Image<std::int8_t>& labels, int ix, int iy) {
  for (int y{std::max(iy - 1, 0)}; y <= std::min(iy + 1, labels.height() - 1); ++y) {
    for (int x{std::max(ix - 1, 0)}; x <= std::min(ix + 1, labels.width() - 1); ++x) {
      if (labels(x, y) == labelled_occupied) return true;
    }
  }
  return false;
}

}  // namespace

void Scores::add(std::string frame_name, View<const float> probability, const Labels& labels) {
  const GridGeometry& grid{labels.geometry};
  if (probability.width != grid.nx || probability.height != grid.ny || labels.cells.width() != grid.nx ||
      labels.cells.height() != grid.ny) {
    throw std::invalid_argument{"Scores::add: probabilities, labels and their geometry differ in size"};
  }
  if (!frames_.empty() && grid != geometry_) throw std::invalid_argument{"Scores::add: the grid has changed"};
  geometry_ = grid;
  has_hidden_ground_ = labels.hidden_ground.size() > 0;
  Frame frame{std::move(frame_name), {}, free_space(probability, labels)};
  for (int iy{0}; iy < grid.ny; ++iy) {
    for (int ix{0}; ix < grid.nx; ++ix) {
      const std::int8_t label{labels.cells(ix, iy)};
      if (label == not_scored) continue;
      const bool is_occupied{label == labelled_occupied};
      frame.cells.push_back({probability(ix, iy), static_cast<std::uint16_t>(ix), is_occupied,
                             labels.partly_hidden(ix, iy) != 0, !is_occupied && touches_occupied(labels.cells, ix, iy),
                             has_hidden_ground_ && labels.hidden_ground(ix, iy) != 0});
    }
  }
  frames_.push_back(std::move(frame));
}

bool Scores::contains(Band band, const Cell& cell) const {
  const double centre_m{geometry_.x_min_m + (cell.ix + 0.5) * geometry_.cell_size_m};
  return centre_m >= band.from_m && centre_m < band.to_m && !(band.clear && cell.is_hidden_ground);
}

Summary Scores::summary(Band band, int resamples) const {
  const auto frames{frames_in(frames_, band, [&](const Cell& cell) { return contains(band, cell); })};
  Summary summary;
  fill_point(frames, summary);
  if (resamples > 0 && frames.size() >= frames_for_an_interval) fill_intervals(frames, resamples, summary);
  return summary;
}

std::vector<RocPoint> Scores::roc(Band band, Positives positives) const {
  const auto frames{frames_in(frames_, band, [&](const Cell& cell) { return contains(band, cell); })};
  const Ranking ranking{probabilities_of(frames), coarse_groups};
  Totals totals{ranking.size(), 0};
  for (const InBand& frame : frames) {
    for (const Cell& cell : frame.cells) totals.add(cell, ranking);
  }
  return roc_of(totals.groups, positives == Positives::all ? &GroupCounts::occupied : &GroupCounts::hidden_occupied,
                &GroupCounts::free);
}

std::vector<Scores::FrameLoss> Scores::frame_losses(Band band) const {
  std::vector<FrameLoss> losses;
  const auto frames{frames_in(frames_, band, [&](const Cell& cell) { return contains(band, cell); })};
  for (std::size_t i{0}; i < frames.size(); ++i) {
    Summary summary;
    fill_point({{frames[i].cells, {}}}, summary);
    losses.push_back({frames_[i].name, summary.balanced_log_loss.value});
  }
  return losses;
}

std::vector<float> Scores::depth_errors_m(Band band) const {
  std::vector<float> errors;
  for (const InBand& frame : frames_in(frames_, band, [](const Cell&) { return false; })) {
    for (const ColumnDepth& column : frame.columns) errors.push_back(column.found_m - column.truth_m);
  }
  return errors;
}

namespace {

/// Near edge (m ahead) of the first cell for which `test(ix, iy)`, on the ray y = slope · x.
template <class Test>
std::optional<double> first_along(const GridGeometry& grid, double slope, double from_m, Test test) {
  const int first{static_cast<int>(std::max(std::ceil((from_m - grid.x_min_m) / grid.cell_size_m - 1e-9), 0.0))};
  const auto row_at = [&](double x) {
    return static_cast<int>(std::floor((slope * x - grid.y_min_m) / grid.cell_size_m));
  };
  for (int ix{first}; ix < grid.nx; ++ix) {
    const double near_m{grid.x_min_m + ix * grid.cell_size_m};
    const int last_row{row_at(near_m + grid.cell_size_m)};
    for (int iy{row_at(near_m)};; iy += slope > 0 ? 1 : -1) {
      if (iy >= 0 && iy < grid.ny && test(ix, iy)) return near_m;
      if (iy == last_row) break;
    }
  }
  return std::nullopt;
}

}  // namespace

std::vector<ColumnDepth> free_space(View<const float> probability, const Labels& labels, double from_m) {
  const GridGeometry& grid{labels.geometry};
  const double end_m{grid.x_min_m + grid.nx * grid.cell_size_m};
  std::vector<ColumnDepth> columns;
  for (int u{0}; u < labels.rig.width_px; ++u) {
    const double slope{-(u - labels.rig.cx_px) / labels.rig.focal_px};
    const auto truth{
        first_along(grid, slope, from_m, [&](int ix, int iy) { return labels.cells(ix, iy) == labelled_occupied; })};
    if (!truth) continue;
    const auto found{first_along(grid, slope, from_m, [&](int ix, int iy) { return probability(ix, iy) > 0.5F; })};
    columns.push_back({static_cast<float>(*truth), static_cast<float>(found.value_or(end_m))});
  }
  return columns;
}

}  // namespace stereogrid::evaluation
