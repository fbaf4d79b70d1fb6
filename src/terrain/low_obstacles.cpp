// SPDX-License-Identifier: Apache-2.0
#include "terrain/low_obstacles.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "terrain/rules.hpp"

namespace stereogrid {
namespace {

constexpr int read_columns{32};  ///< columns that are read together

// The cell or one beside it.
bool is_near_occupied(View<const float> occupancy, int ix, int iy) {
  for (int y{std::max(iy - 1, 0)}; y <= std::min(iy + 1, occupancy.height - 1); ++y) {
    for (int x{std::max(ix - 1, 0)}; x <= std::min(ix + 1, occupancy.width - 1); ++x) {
      if (occupancy(x, y) >= ruled_obstacle) return true;
    }
  }
  return false;
}

}  // namespace

LowModel::LowModel(const Rig& level_rig, const TerrainLimits& of_terrain, double cell_size_m, int window_cells,
                   int window_px, int disparities)
    : limits{of_terrain},
      cell_m{static_cast<float>(cell_size_m)},
      cx_px{static_cast<float>(level_rig.cx_px)},
      columns{level_rig.width_px},
      rows{level_rig.height_px},
      last_place{static_cast<float>(Rings::last_place(disparities))},
      cells{window_cells},
      reach{std::max(2, static_cast<int>(std::lround(plane_reach * limits.height_m / cell_m)))},
      tall_reach{std::max(1, static_cast<int>(std::lround(tall_reach_m / cell_m)))},
      lost_rows{0.5f * static_cast<float>(window_px)},
      most{std::min(limits.height_m, highest_m) * per_m},
      camera{level_rig, {}},
      places{{}, {}, 1} {}

// Behind the range at which two rows are a cell apart, cells have gaps.
void LowModel::begin(const TerrainCamera& of_frame, const GridInVehicle& window, float checked_m) {
  camera = of_frame;
  places = CellPlaces{window, {0, 0}, 1};
  const float sampled_m{std::sqrt(cell_m * camera.height_m / camera.tangent_per_v)};
  end_m = std::max(std::min(checked_m, sampled_m), cell_m);
  const float lowest{camera.tangent(cx_px, static_cast<float>(rows - 1))};
  near_m = lowest > 0 ? camera.height_m / lowest : 0;
  least_px = camera.focal_baseline_pxm / end_m;
  most_px = camera.focal_baseline_pxm / cell_m;
  const GridGeometry& grid{window.grid};
  cos_yaw = static_cast<float>(window.cos_yaw / grid.cell_size_m);
  sin_yaw = static_cast<float>(window.sin_yaw / grid.cell_size_m);
  sin_per_px = sin_yaw / camera.focal_px;
  cos_per_px = cos_yaw / camera.focal_px;
  origin_east = static_cast<float>((-window.cos_yaw * window.x_m - window.sin_yaw * window.y_m - grid.x_min_m) /
                                   grid.cell_size_m);
  origin_north =
      static_cast<float>((window.sin_yaw * window.x_m - window.cos_yaw * window.y_m - grid.y_min_m) / grid.cell_size_m);
  const float over_m{std::max(camera.height_m - limits.rays_from_m - limits.step_m, 0.0f)};
  const float row{over_m / end_m - limits.slope - camera.tangent(cx_px, 0)};
  first_row = static_cast<int>(std::clamp(row / camera.tangent_per_v, 0.0f, static_cast<float>(rows)));
}

LowObstacleFinder::LowObstacleFinder(const Rig& level_rig, int window_cells)
    : samples_{level_rig.width_px, level_rig.height_px},
      read_(static_cast<std::size_t>(level_rig.height_px)),
      sorted_(samples_.size()),
      ranges_{window_cells, window_cells},
      level_m_{window_cells, window_cells},
      top_m_{window_cells, window_cells},
      noise_m_{window_cells, window_cells},
      weights_{window_cells, window_cells},
      moments_{window_cells, window_cells},
      sums_(static_cast<std::size_t>(window_cells)),
      planes_{window_cells, window_cells},
      seen_{window_cells, window_cells} {
  found_.reserve(std::min(seen_.size(), samples_.size()));
}

std::span<std::int16_t> LowObstacleFinder::heights_of(int ix, int iy) {
  const Range range{ranges_(ix, iy)};
  return std::span{sorted_}.subspan(static_cast<std::size_t>(range.begin),
                                    static_cast<std::size_t>(range.end - range.begin));
}

// Three loops, of which the second one becomes vectors.
LowObstacleFinder::RowRead LowObstacleFinder::read_row(View<const float> obstacle, View<const float> road, int v) {
  const LowModel model{*model_};  // members might change with each store
  const LowModel::Row in_row{model.row(v)};
  const int step{in_row.step};
  const float* const of_obstacles{obstacle.row(v)};
  const float* const of_road{road.row(v)};
  std::array<float, read_columns> columns;
  std::array<float, read_columns> disparities;
  std::array<float, read_columns> heights;
  std::array<float, read_columns> easts;
  std::array<float, read_columns> norths;
  Sample* const samples{samples_.row(v)};
  const auto add = [](int cell, Range& range) { range = {std::min(range.begin, cell), std::max(range.end, cell)}; };
  Range columns_read{seen_.width(), -1};  // first and last
  Range rows_read{columns_read};
  int count{0};
  for (int first{0}; first < obstacle.width; first += read_columns * step) {
    const int end{std::min(first + read_columns * step, obstacle.width)};
    std::size_t read{0};
    for (int u{first}; u < end; u += step) {
      const float disparity{std::max(of_obstacles[u], of_road[u])};
      columns[read] = static_cast<float>(u);
      disparities[read] = disparity;
      read += model.is_in_range(disparity) ? 1 : 0;
    }
    for (std::size_t i{0}; i < read; ++i) {
      const LowModel::Place place{model.place(in_row, columns[i], disparities[i])};
      heights[i] = place.height;
      easts[i] = place.east;
      norths[i] = place.north;
    }
    for (std::size_t i{0}; i < read; ++i) {
      const int ix{static_cast<int>(easts[i])};
      const int iy{static_cast<int>(norths[i])};
      if (!model.is_sample(ix, iy, heights[i])) continue;
      add(ix, columns_read);
      add(iy, rows_read);
      samples[count++] = {iy * seen_.width() + ix, static_cast<std::int16_t>(heights[i])};
    }
  }
  return {count, {columns_read.begin, columns_read.end + 1}, {rows_read.begin, rows_read.end + 1}};
}

void LowObstacleFinder::sort_samples() {
  const int first_row{model_->first_row};
  const int cells{seen_.width()};
  columns_ = rows_ = {cells, 0};
  const auto add = [](Range range, Range& sum) {
    sum = {std::min(sum.begin, range.begin), std::max(sum.end, range.end)};
  };
  for (int v{first_row}; v < samples_.height(); ++v) {
    add(read_[static_cast<std::size_t>(v)].columns, columns_);
    add(read_[static_cast<std::size_t>(v)].rows, rows_);
  }
  if (rows_.end == 0) columns_ = rows_ = {0, 0};
  const auto for_samples = [&](const auto& work) {
    for (int v{first_row}; v < samples_.height(); ++v) {
      const Sample* const row{samples_.row(v)};
      for (int i{0}; i < read_[static_cast<std::size_t>(v)].count; ++i) work(row[i], ranges_.data()[row[i].cell]);
    }
  };
  const auto for_ranges_of_cells = [&](const auto& work) {
    for (int iy{rows_.begin}; iy < rows_.end; ++iy)
      std::for_each(&ranges_(columns_.begin, iy), &ranges_(columns_.begin, iy) + (columns_.end - columns_.begin), work);
  };
  for_ranges_of_cells([](Range& range) { range = {0, 0}; });
  for_samples([](const Sample&, Range& range) { ++range.end; });
  int begin{0};
  for_ranges_of_cells([&](Range& range) {
    const int count{range.end};
    range = {begin, begin};
    begin += count;
  });
  for_samples([&](const Sample& sample, Range& range) { sorted_[static_cast<std::size_t>(range.end++)] = sample.z; });
}

// The upper decile is behind the others afterwards.
void LowObstacleFinder::set_levels(std::span<const float> noise_px, int iy) {
  for (int ix{columns_.begin}; ix < columns_.end; ++ix) {
    const std::span<std::int16_t> heights{heights_of(ix, iy)};
    level_m_(ix, iy) = LowModel::none_m;
    planes_(ix, iy).z = LowModel::none_m;
    if (heights.empty()) continue;
    const auto top = heights.end() - LowModel::decile_of(static_cast<int>(heights.size()));
    const auto middle = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2);
    std::nth_element(heights.begin(), top, heights.end());
    if (middle < top) std::nth_element(heights.begin(), middle, top);
    level_m_(ix, iy) = LowModel::height_m(*middle);
    top_m_(ix, iy) = LowModel::height_m(*top);
    noise_m_(ix, iy) = model_->noise_m(model_->places.x_of(ix, iy), noise_px.data());
  }
}

// Weights of the cells' levels, and their sums along the row.
void LowObstacleFinder::sum_along(int iy, int pass) {
  const LowModel& model{*model_};
  const int reach{model.reach};
  const float* const levels{level_m_.row(iy)};
  const float* const noises{noise_m_.row(iy)};
  const LowPlane* const planes{planes_.row(iy)};
  Weight* const weights{weights_.row(iy)};
  RowMoments* const moments{moments_.row(iy)};
  RowMoments sum{};
  for (int ix{columns_.begin}; ix < columns_.end + reach; ++ix) {
    const int removed{ix - 2 * reach - 1};
    if (removed >= columns_.begin && weights[removed].n != 0) sum.add(weights[removed], removed, -1);
    if (ix < columns_.end) {
      const float level{levels[ix]};
      Weight& weight{weights[ix]};
      weight = {0, 0};
      if (!std::isnan(level)) {
        weight = model.weighted<double>(pass, model.places.x_of(ix, iy), level, planes[ix], noises[ix]);
        sum.add(weight, ix, 1);
      }
    }
    const int middle{ix - reach};
    if (middle >= columns_.begin) moments[middle] = sum;
  }
}

void LowObstacleFinder::fit_planes() {
  const int reach{model_->reach};
  std::fill_n(sums_.begin(), columns_.end, Moments{});
  for (int iy{rows_.begin - reach}; iy < rows_.end; ++iy) {
    const int added{iy + reach};
    const int removed{iy - reach - 1};
    for (int ix{columns_.begin}; ix < columns_.end; ++ix) {
      Moments& sum{sums_[static_cast<std::size_t>(ix)]};
      if (added >= rows_.begin && added < rows_.end) sum.add(moments_(ix, added), added, 1);
      if (removed >= rows_.begin) sum.add(moments_(ix, removed), removed, -1);
      if (iy < rows_.begin || std::isnan(level_m_(ix, iy))) continue;
      planes_(ix, iy) = LowModel::plane_of(sum, ix, iy, planes_(ix, iy).z);
    }
  }
}

void LowObstacleFinder::compare(int iy) {
  for (int ix{columns_.begin}; ix < columns_.end; ++ix) {
    LowSeen& seen{seen_(ix, iy)};
    seen = {};
    const LowPlane& plane{planes_(ix, iy)};
    if (std::isnan(plane.z)) continue;
    const LowModel::Limits limits{model_->limits_of(plane, model_->places.x_of(ix, iy), noise_m_(ix, iy))};
    std::span<const std::int16_t> heights{heights_of(ix, iy)};
    const int samples{static_cast<int>(heights.size())};
    const auto is_over = [&](float height_m) { return LowModel::is_over(limits, top_m_(ix, iy), height_m); };
    const auto higher = [&](float height_m) {
      const float limit{LowModel::over(limits, height_m)};
      return static_cast<int>(
          std::ranges::count_if(heights, [limit](std::int16_t z) { return static_cast<float>(z) > limit; }));
    };
    const bool may_be_obstacle{is_over(limits.matched_m) && is_over(LowModel::depths * depth_around(ix, iy))};
    const int raised{may_be_obstacle ? higher(LowModel::raised_share * limits.matched_m) : 0};
    if (!is_over(limits.least_m)) heights = heights.last(static_cast<std::size_t>(LowModel::decile_of(samples)));
    const int high{higher(limits.least_m)};
    const int tall{high > 1 ? higher(model_->limits.rays_from_m) : 0};
    seen = model_->seen(limits, top_m_(ix, iy), samples, raised, high, tall);
  }
}

float LowObstacleFinder::depth_around(int ix, int iy) const {
  const int reach{model_->reach};
  float depth_m{0};
  for (int y{std::max(iy - reach, rows_.begin)}; y <= std::min(iy + reach, rows_.end - 1); ++y) {
    for (int x{std::max(ix - reach, columns_.begin)}; x <= std::min(ix + reach, columns_.end - 1); ++x)
      depth_m = std::max(depth_m, planes_(x, y).z - level_m_(x, y));  // not of cells without a plane: NaN
  }
  return depth_m;
}

bool LowObstacleFinder::is_small(int ix, int iy) const {
  int raised{0};
  for (int y{std::max(iy - 1, rows_.begin)}; y <= std::min(iy + 1, rows_.end - 1); ++y) {
    for (int x{std::max(ix - 1, columns_.begin)}; x <= std::min(ix + 1, columns_.end - 1); ++x)
      raised += seen_(x, y).raised;
  }
  return model_->is_small(model_->places.x_of(ix, iy), raised);
}

void LowObstacleFinder::mark_beside_tall(int ix, int iy) {
  const int reach{model_->tall_reach};
  for (int y{std::max(iy - reach, rows_.begin)}; y <= std::min(iy + reach, rows_.end - 1); ++y) {
    for (int x{std::max(ix - reach, columns_.begin)}; x <= std::min(ix + reach, columns_.end - 1); ++x)
      seen_(x, y).is_beside_tall = true;
  }
}

void LowObstacleFinder::check() {
  for_cells([this](int ix, int iy) {
    if (seen_(ix, iy).is_tall) mark_beside_tall(ix, iy);
  });
  found_.clear();
  for_cells([this](int ix, int iy) {
    const LowSeen& seen{seen_(ix, iy)};
    if (seen.count == 0 || (LowModel::is_obstacle(seen, seen.is_beside_tall) && is_small(ix, iy))) return;
    found_.push_back(LowModel::cell(ix, iy, seen, seen.is_beside_tall, noise_m_(ix, iy)));
  });
}

void LowObstacles::remember(const LowObstacles& of) {
  for (const LowCell& cell : of.seen_) {
    if (cell.is_beside_tall)
      memory_.clear(cell.ix, cell.iy);
    else
      memory_.add(cell.ix, cell.iy, cell.height, model_.limits.step_m / 8 / cell.noise_m, cell.count);
  }
}

// Rays and the filter decide about tall things that they see: these may move, and the matcher smears them.
void LowObstacles::remember_bars(const LowObstacles& of, View<const float> occupancy) {
  const auto is_in_view = [&model = of.model_](int ix, int iy) { return model.is_in_view(ix, iy); };
  memory_.pass_bars(is_in_view);
  for (const LowCell& cell : of.seen_) {
    if (!cell.is_tall && !memory_.has_tall(cell.ix, cell.iy)) continue;
    if (is_near_occupied(occupancy, cell.ix, cell.iy))
      memory_.clear_tall(cell.ix, cell.iy);
    else if (cell.is_tall && is_in_view(cell.ix, cell.iy))
      memory_.add_tall(cell.ix, cell.iy);
  }
}

}  // namespace stereogrid
