// SPDX-License-Identifier: Apache-2.0
//
// Near obstacles, compared with the matches of a frame column by column.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "clamped_to_int.hpp"
#include "geometry/road_plane.hpp"
#include "images/patch.hpp"
#include "obstacles/tracking/near_obstacles.hpp"

namespace stereogrid {
namespace {

/// Width of the unreliable part at the end of the disparity search, px.
constexpr double end_of_search_px{3};
/// Minimum share of a column's textured pixels that have matched behind the obstacle if it is gone. False matches reach
/// 0.6, visible ground has 0.85 and more.
constexpr double behind_min{0.75};
/// Minimum difference of the disparities of the obstacle and the surface behind it, as a share and in px.
constexpr double behind_share{0.15};
constexpr double behind_px{2};
/// Minimum share of textured pixels; with fewer, all pixels count.
constexpr double textured_min{0.1};
/// An obstacle fills the view where its foot is below this share of the image's rows, in this share of the columns.
constexpr double foot_min{0.9};
constexpr double filled_min{1.0 / 3};
/// Columns of MatchLattice to either side whose pixels are counted together.
constexpr int pooled_columns{6};
constexpr double infinite{std::numeric_limits<double>::infinity()};

}  // namespace

Point2 NearObstacles::centre(const Cell& cell, const Pose2& vehicle_from_world) const {
  return vehicle_from_world * Point2{(cell.x + 0.5) * cell_size_m_, (cell.y + 0.5) * cell_size_m_};
}

// May lie outside the image.
int NearObstacles::column_at(Point2 place) const {
  const double u{rig_.cx_px - rig_.focal_px * place.y / place.x};
  return clamped_to_int(std::round((u - MatchLattice::first_u) / MatchLattice::step_u));
}

void NearObstacles::compare(const MatchedFrame& frame, const Ground& road, const Pose2& world_from_vehicle,
                            const GridGeometry& window) {
  clear_result();
  if (cells_.empty()) return;
  cell_size_m_ = window.cell_size_m;
  const Pose2 vehicle_from_world{inverse(world_from_vehicle)};
  const double textured_grey{textured_from(frame, horizon_row(rig_, road))};
  for (std::size_t begin{0}, end{0}; begin < cells_.size(); begin = end) {
    while (end < cells_.size() && cells_[end].id == cells_[begin].id) ++end;
    const std::span<const Cell> cells{std::span{cells_}.subspan(begin, end - begin)};
    const std::span<CellState> states{std::span{states_}.subspan(begin, end - begin)};
    find_columns(cells, vehicle_from_world);
    count(frame, road, cells.front().height_m, textured_grey);
    decide_columns(road, cells.front().height_m);
    decide_cells(cells, states, vehicle_from_world);
    hold(cells, states, window);
  }
}

// Distance of the nearest cell in each column.
void NearObstacles::find_columns(std::span<const Cell> cells, const Pose2& vehicle_from_world) {
  const double half_m{0.5 * cell_size_m_};
  std::fill(columns_.begin(), columns_.end(), Column{infinite, 0, 0, 0, 0, CellState::out_of_view});
  const int last{static_cast<int>(columns_.size()) - 1};
  for (const Cell& cell : cells) {
    const Point2 at{centre(cell, vehicle_from_world)};
    if (at.x <= half_m) continue;
    const int first_column{std::max(column_at({at.x, at.y + half_m}), 0)};
    const int last_column{std::min(column_at({at.x, at.y - half_m}), last)};
    for (int i{first_column}; i <= last_column; ++i) {
      Column& column{columns_[static_cast<std::size_t>(i)]};
      column.near_m = std::min(column.near_m, at.x);
    }
  }
}

// Counts pixels between the rows of the obstacle's top and foot, and below the horizon: the sky never matches.
void NearObstacles::count(const MatchedFrame& frame, const Ground& road, double height_m, double textured_grey) {
  const RowsByHeight rows{rig_, road};
  const MatchLattice lattice{rig_.width_px, rig_.height_px};
  for (int i{0}; i < lattice.across; ++i) {
    Column& column{columns_[static_cast<std::size_t>(i)]};
    if (!(column.near_m < infinite)) continue;
    const double disparity{rig_.focal_px * rig_.baseline_m / column.near_m};
    const double behind{disparity - std::max(behind_px, behind_share * disparity)};
    const double top{std::max(rows.row(disparity, height_m), rows.horizon)};
    const double foot{rows.row(disparity, 0)};
    const int u{MatchLattice::first_u + i * MatchLattice::step_u};
    for (int j{0}; j < lattice.down; ++j) {
      const int v{MatchLattice::first_v + j * MatchLattice::step_v};
      if (v < top || v > foot || (!frame.masked.empty() && frame.masked(u, v) != 0)) continue;
      const float matched{std::max(frame.matches.obstacle(u, v), frame.matches.road(u, v))};
      const int is_behind{matched > 0 && matched < behind ? 1 : 0};
      const int is_textured{std::abs(frame.left(u + 1, v) - frame.left(u - 1, v)) >= textured_grey ? 1 : 0};
      column.pixels += 1;
      column.pixels_behind += is_behind;
      column.textured += is_textured;
      column.textured_behind += is_textured * is_behind;
    }
  }
}

bool NearObstacles::fills_view(const RowsByHeight& rows) const {
  const double foot_px{(foot_min * rig_.height_px - rows.horizon) * rows.baseline_across_m / rows.camera_height_m};
  const auto hides_ground = [&](const Column& column) {
    return column.near_m * foot_px <= rig_.focal_px * rig_.baseline_m;
  };
  const auto columns = std::ranges::count_if(columns_, hides_ground);
  return static_cast<double>(columns) >= filled_min * static_cast<double>(columns_.size());
}

// True where the matches around a column lie behind the obstacle.
bool NearObstacles::is_gone(int index) const {
  Column sum{};
  const int last{std::min(index + pooled_columns, static_cast<int>(columns_.size()) - 1)};
  for (int i{std::max(index - pooled_columns, 0)}; i <= last; ++i) {
    const Column& column{columns_[static_cast<std::size_t>(i)]};
    sum.pixels += column.pixels;
    sum.pixels_behind += column.pixels_behind;
    sum.textured += column.textured;
    sum.textured_behind += column.textured_behind;
  }
  const bool has_texture{sum.textured >= textured_min * sum.pixels};
  const int all{has_texture ? sum.textured : sum.pixels};
  const int behind{has_texture ? sum.textured_behind : sum.pixels_behind};
  return all > 0 && behind >= behind_min * all;
}

void NearObstacles::decide_columns(const Ground& road, double height_m) {
  const RowsByHeight rows{rig_, road};
  const bool fills{fills_view(rows)};
  for (int i{0}; i < static_cast<int>(columns_.size()); ++i) {
    Column& column{columns_[static_cast<std::size_t>(i)]};
    if (!(column.near_m < infinite)) continue;
    const double disparity{rig_.focal_px * rig_.baseline_m / column.near_m};
    const bool is_below_image{rows.row(disparity, height_m) >= rig_.height_px};
    const bool is_beyond_search{disparity > matching_.disparities - end_of_search_px};
    const int u{MatchLattice::first_u + i * MatchLattice::step_u};
    const bool is_beside_right_image{u < disparity + 0.5 * matching_.window_px};
    const bool is_lost{is_below_image || is_beyond_search || (fills && is_beside_right_image)};
    column.state = is_lost ? CellState::unmatchable : (fills ? CellState::present : CellState::in_view);
    if (is_gone(i)) column.state = CellState::gone;
  }
}

// Cells beside the image are decided by the obstacle's outermost columns.
void NearObstacles::decide_cells(std::span<const Cell> cells, std::span<CellState> states,
                                 const Pose2& vehicle_from_world) {
  const auto is_covered = [](const Column& column) { return column.near_m < infinite; };
  const auto first = std::find_if(columns_.begin(), columns_.end(), is_covered);
  if (first == columns_.end()) return;
  const auto last = std::find_if(columns_.rbegin(), columns_.rend(), is_covered);
  const int first_column{static_cast<int>(first - columns_.begin())};
  const int last_column{static_cast<int>(columns_.rend() - last) - 1};
  for (std::size_t i{0}; i < cells.size(); ++i) {
    const Point2 at{centre(cells[i], vehicle_from_world)};
    if (at.x <= 0.5 * cell_size_m_) continue;
    const int column{std::clamp(column_at(at), first_column, last_column)};
    states[i] = columns_[static_cast<std::size_t>(column)].state;
  }
}

void NearObstacles::hold(std::span<const Cell> cells, std::span<const CellState> states, const GridGeometry& window) {
  const int first_x{clamped_to_int(std::round(window.x_min_m / cell_size_m_))};
  const int first_y{clamped_to_int(std::round(window.y_min_m / cell_size_m_))};
  int unmatchable{0};
  int present{0};
  for (std::size_t i{0}; i < cells.size(); ++i) {
    const int x{cells[i].x - first_x};
    const int y{cells[i].y - first_y};
    const bool is_unmatchable{states[i] == CellState::unmatchable};
    const bool is_present{is_unmatchable || states[i] == CellState::present};
    unmatchable += is_unmatchable ? 1 : 0;
    present += is_present ? 1 : 0;
    if (x < 0 || x >= window.nx || y < 0 || y >= window.ny) continue;
    const RetainedCell held{y * window.nx + x, cells[i].occupancy};
    if (is_unmatchable) unmatchable_.cells.push_back(held);
    if (is_present) present_.cells.push_back(held);
  }
  const int all{static_cast<int>(cells.size())};
  if (2 * unmatchable >= all) unmatchable_.ids.push_back(cells.front().id);
  if (2 * present >= all) present_.ids.push_back(cells.front().id);
}

}  // namespace stereogrid
