// SPDX-License-Identifier: Apache-2.0
#include "baselines/columns.hpp"

#include <cmath>

namespace stereogrid::research {
namespace {

std::vector<double> gaussian_weights(double sigma) {
  const int reach{static_cast<int>(std::ceil(3 * sigma))};
  std::vector<double> weights;
  double sum{0};
  for (int k{-reach}; k <= reach; ++k) {
    const double root{sigma * std::sqrt(2.0)};
    weights.push_back(sigma > 0 ? std::erf((k + 0.5) / root) - std::erf((k - 0.5) / root) : 1);
    sum += weights.back();
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

// Borders replicate.
Image<float> smoothed(const Image<float>& image, const std::vector<double>& weights, bool across) {
  const int reach{static_cast<int>(weights.size()) / 2};
  if (reach == 0) return image;
  Image<float> result{image.width(), image.height()};
  for (int v{0}; v < image.height(); ++v) {
    for (int u{0}; u < image.width(); ++u) {
      double sum{0};
      for (int k{-reach}; k <= reach; ++k) {
        const int uu{across ? std::clamp(u + k, 0, image.width() - 1) : u};
        const int vv{across ? v : std::clamp(v + k, 0, image.height() - 1)};
        sum += weights[static_cast<std::size_t>(k + reach)] * static_cast<double>(image(uu, vv));
      }
      result(u, v) = static_cast<float>(sum);
    }
  }
  return result;
}

struct Source {
  float cost;
  int state;
};

// Best predecessor of each state: two sweeps of the distance transform, and a jump from the cheapest of all.
std::vector<Source> sources(const std::vector<float>& totals, float jump_cost, int jump_max) {
  const int states{static_cast<int>(totals.size())};
  std::vector<Source> best(totals.size());
  const int cheapest{static_cast<int>(std::min_element(totals.begin(), totals.end()) - totals.begin())};
  const Source far{totals[static_cast<std::size_t>(cheapest)] + jump_cost * static_cast<float>(jump_max), cheapest};
  for (int i{0}; i < states; ++i) {
    const auto at{static_cast<std::size_t>(i)};
    best[at] = {totals[at], i};
    if (i > 0 && best[at - 1].cost + jump_cost < best[at].cost)
      best[at] = {best[at - 1].cost + jump_cost, best[at - 1].state};
  }
  for (int i{states - 1}; i >= 0; --i) {
    const auto at{static_cast<std::size_t>(i)};
    if (i + 1 < states && best[at + 1].cost + jump_cost < best[at].cost) {
      best[at] = {best[at + 1].cost + jump_cost, best[at + 1].state};
    }
  }
  for (Source& source : best) {
    if (far.cost < source.cost) source = far;
  }
  return best;
}

}  // namespace

RoadModel::RoadModel(const Rig& rig, const Ground& ground) : camera_height_m_{ground.height_m} {
  const double scale{rig.baseline_m / ground.height_m};
  per_u_ = scale * std::cos(ground.pitch_rad) * std::sin(ground.roll_rad);
  per_v_ = scale * std::cos(ground.pitch_rad) * std::cos(ground.roll_rad);
  at_origin_ = scale * rig.focal_px * std::sin(ground.pitch_rad) - per_u_ * rig.cx_px - per_v_ * rig.cy_px;
}

DisparityPlane::DisparityPlane(const DisparityFrame& frame, const ColumnGridParameters& parameters)
    : rig_{frame.rig},
      parameters_{parameters},
      bins_per_px_{static_cast<double>(parameters.bins_per_px)},
      plane_{frame.obstacle.width, frame.disparities * parameters.bins_per_px, 0.5F} {}

DisparityPlane::Bins DisparityPlane::bins(double from, double to) const {
  const auto bin = [&](double disparity) { return static_cast<int>(std::lround(disparity * bins_per_px_)); };
  return {std::max(1, bin(from)), std::min(plane_.height() - 1, bin(to))};
}

void DisparityPlane::set(int u, double from, double to, double probability) {
  const Bins range{bins(from, to)};
  for (int k{range.first}; k <= range.last; ++k) plane_(u, k) = static_cast<float>(probability);
}

void DisparityPlane::raise(int u, double from, double to, double probability) {
  const Bins range{bins(from, to)};
  for (int k{range.first}; k <= range.last; ++k) {
    if (plane_(u, k) <= 0.5F || plane_(u, k) < static_cast<float>(probability)) {
      plane_(u, k) = static_cast<float>(probability);
    }
  }
}

void DisparityPlane::smooth() {
  plane_ = smoothed(plane_, gaussian_weights(parameters_.sigma_column), true);
  plane_ = smoothed(plane_, gaussian_weights(parameters_.sigma_disparity * bins_per_px_), false);
}

void DisparityPlane::drop_left_border() {
  for (int k{0}; k < plane_.height(); ++k) {
    const int border{static_cast<int>(std::ceil(k / bins_per_px_)) + parameters_.left_border_px};
    for (int u{0}; u < std::min(border, plane_.width()); ++u) plane_(u, k) = 0.5F;
  }
}

float DisparityPlane::largest_in(int bin, double x_near, double x_far, double y0, double y1, float so_far) const {
  // the part of the cell within the bin's depth is a rectangle: its corners span the columns that see it
  const double columns[4]{rig_.cx_px - rig_.focal_px * y0 / x_near, rig_.cx_px - rig_.focal_px * y0 / x_far,
                          rig_.cx_px - rig_.focal_px * y1 / x_near, rig_.cx_px - rig_.focal_px * y1 / x_far};
  const auto [smallest, largest]{std::minmax_element(columns, columns + 4)};
  const int first{std::max(0, static_cast<int>(std::ceil(*smallest - 0.5)))};
  const int last{std::min(plane_.width() - 1, static_cast<int>(std::floor(*largest + 0.5)))};
  for (int u{first}; u <= last; ++u) so_far = std::max(so_far, plane_(u, bin));
  return so_far;
}

float DisparityPlane::cell(double x0, double x1, double y0, double y1) const {
  if (x0 <= 0) return 0.5F;
  const double constant{rig_.focal_px * rig_.baseline_m * bins_per_px_};
  const int first{std::max(1, static_cast<int>(std::floor(constant / x1 + 0.5)))};
  const int last{std::min(plane_.height() - 1, static_cast<int>(std::ceil(constant / x0 - 0.5)))};
  float largest{-1};
  for (int bin{first}; bin <= last; ++bin) {
    const double near{std::max(x0, constant / (bin + 0.5))};
    const double far{std::min(x1, constant / (bin - 0.5))};
    if (near < far) largest = largest_in(bin, near, far, y0, y1, largest);
  }
  return largest < 0 ? 0.5F : largest;
}

Image<float> DisparityPlane::to_cells(const GridGeometry& grid) {
  smooth();
  drop_left_border();
  Image<float> cells{grid.nx, grid.ny};
  for (int iy{0}; iy < grid.ny; ++iy) {
    const double y{grid.y_min_m + iy * grid.cell_size_m};
    for (int ix{0}; ix < grid.nx; ++ix) {
      const double x{grid.x_min_m + ix * grid.cell_size_m};
      cells(ix, iy) = cell(x, x + grid.cell_size_m, y, y + grid.cell_size_m);
    }
  }
  return cells;
}

Image<float> boundary_grid(const DisparityFrame& frame, const std::vector<ColumnBoundary>& columns,
                           const ColumnGridParameters& parameters, const Levels& levels, const GridGeometry& grid) {
  DisparityPlane plane{frame, parameters};
  const double half_bin{0.5 / parameters.bins_per_px};
  for (std::size_t u{0}; u < columns.size(); ++u) {
    const ColumnBoundary& column{columns[u]};
    const int place{static_cast<int>(u)};
    if (column.disparity > 0) {
      plane.set(place, column.disparity, plane.disparity_max(), levels.free);
      plane.set(place, column.disparity - 0.5 + half_bin, column.disparity + 0.5 - half_bin, levels.occupied);
    } else if (column.free_to > 0) {
      plane.set(place, column.free_to, plane.disparity_max(), levels.free);
    }
  }
  return plane.to_cells(grid);
}

std::vector<double> farthest_road(const DisparityFrame& frame) {
  constexpr std::ptrdiff_t pixels_beyond{4};
  std::vector<double> farthest(static_cast<std::size_t>(frame.road.width));
  std::vector<float> column;
  for (int u{0}; u < frame.road.width; ++u) {
    column.clear();
    for (int v{0}; v < frame.road.height; ++v) {
      if (frame.road(u, v) > 0) column.push_back(frame.road(u, v));
    }
    if (std::ssize(column) <= pixels_beyond) continue;
    std::nth_element(column.begin(), column.begin() + pixels_beyond, column.end());
    farthest[static_cast<std::size_t>(u)] = static_cast<double>(column[pixels_beyond]);
  }
  return farthest;
}

std::vector<int> best_path(const Image<float>& costs, double jump_cost, int jump_max) {
  if (costs.empty()) return {};
  const int states{costs.width()};
  Image<int> from{states, costs.height()};
  std::vector<float> totals(costs.row(0), costs.row(0) + states);
  for (int column{1}; column < costs.height(); ++column) {
    const std::vector<Source> best{sources(totals, static_cast<float>(jump_cost), jump_max)};
    for (int state{0}; state < states; ++state) {
      const Source& source{best[static_cast<std::size_t>(state)]};
      totals[static_cast<std::size_t>(state)] = source.cost + costs(state, column);
      from(state, column) = source.state;
    }
  }
  std::vector<int> path(static_cast<std::size_t>(costs.height()));
  int state{static_cast<int>(std::min_element(totals.begin(), totals.end()) - totals.begin())};
  for (int column{costs.height() - 1}; column >= 0; --column) {
    path[static_cast<std::size_t>(column)] = state;
    state = from(state, column);
  }
  return path;
}

}  // namespace stereogrid::research
