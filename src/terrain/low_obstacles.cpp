// SPDX-License-Identifier: Apache-2.0
#include "terrain/low_obstacles.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace stereogrid {
namespace {

constexpr float none_m{std::numeric_limits<float>::quiet_NaN()};
constexpr float per_m{4096};        ///< unit of heights
constexpr float highest_m{7.9f};    ///< heights in that unit have 16 bits
constexpr int read_columns{32};     ///< columns that are read together
constexpr float columns_enough{4};  ///< columns of a cell that are read, at least
constexpr float full_weight{64};    ///< weight of a cell that is on the plane

// Shares were chosen on single kinds of terrain, random layouts of seeds 701 to 708, and the recordings.

/// Half the side of the square whose cells the plane goes through, in heights of the vehicle.
constexpr float plane_reach{0.6f};
/// The matcher's window lowers small stones of a step's height to this share.
constexpr float matched_share{0.7f};
constexpr float matched_mean{0.53f};  ///< the same of its mean over frames
/// Standard deviations of a sample's height that are noise.
constexpr float sigmas{2.5f};
/// Highest levels of ground over the plane, as a share of a step and in standard deviations.
constexpr float plane_share{0.1f};
constexpr float plane_sigmas{0.5f};
/// Least height of an obstacle relative to the depth of the lowest level around it: errors are on both sides.
constexpr float depths{2};
/// Distance around tall obstacles: a walker moves as far in a frame, and the matcher smears as far.
constexpr float tall_reach_m{0.2f};

// Limits of heights in units of what the matcher leaves of a step.
constexpr float height_min{-2};
constexpr float height_max{6};

/// Samples of a cell that are its upper decile.
std::ptrdiff_t decile_of(std::size_t samples) {
  return static_cast<std::ptrdiff_t>((samples + 9) / 10);
}

}  // namespace

void LowObstacles::RowMoments::add(const Weight& of, double at_x, double sign) {
  const Weight more{sign * of.n, sign * of.z};
  n += more.n;
  x += more.n * at_x;
  xx += more.n * at_x * at_x;
  z += more.z;
  xz += more.z * at_x;
}

void LowObstacles::Moments::add(const RowMoments& of, double at_y, double sign) {
  along.n += sign * of.n;
  along.x += sign * of.x;
  along.xx += sign * of.xx;
  along.z += sign * of.z;
  along.xz += sign * of.xz;
  const double times_y{sign * at_y};
  y += times_y * of.n;
  xy += times_y * of.x;
  yy += times_y * at_y * of.n;
  yz += times_y * of.z;
}

LowObstacles::LowObstacles(const Rig& level_rig, const TerrainLimits& limits, double cell_m, int window_cells,
                           int window_px)
    : limits_{limits},
      cell_m_{static_cast<float>(cell_m)},
      cx_px_{static_cast<float>(level_rig.cx_px)},
      reach_{std::max(2, static_cast<int>(std::lround(plane_reach * limits.height_m / cell_m_)))},
      lost_rows_{0.5f * static_cast<float>(window_px)},
      camera_{level_rig, {}},
      places_{{}, {}, 1},
      samples_{level_rig.width_px, level_rig.height_px},
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
      seen_{window_cells, window_cells},
      memory_{window_cells} {}

std::span<std::int16_t> LowObstacles::heights_of(int ix, int iy) {
  const Range range{ranges_(ix, iy)};
  return std::span{sorted_}.subspan(static_cast<std::size_t>(range.begin),
                                    static_cast<std::size_t>(range.end - range.begin));
}

// Behind the range at which two rows are a cell apart, cells have gaps. Returns the first row with ground, or with the
// lowest part of tall things on it.
int LowObstacles::begin(const Terrain& terrain, const GridInVehicle& window) {
  const TerrainCamera& camera{terrain.camera()};
  camera_ = camera;
  places_ = CellPlaces{window, {0, 0}, 1};
  const float sampled_m{std::sqrt(cell_m_ * camera.height_m / camera.tangent_per_v)};
  end_m_ = std::max(std::min(terrain.checked_m(), sampled_m), cell_m_);
  const GridGeometry& grid{window.grid};
  cos_ = static_cast<float>(window.cos_yaw / grid.cell_size_m);
  sin_ = static_cast<float>(window.sin_yaw / grid.cell_size_m);
  origin_east_ = static_cast<float>((-window.cos_yaw * window.x_m - window.sin_yaw * window.y_m - grid.x_min_m) /
                                    grid.cell_size_m);
  origin_north_ =
      static_cast<float>((window.sin_yaw * window.x_m - window.cos_yaw * window.y_m - grid.y_min_m) / grid.cell_size_m);
  const float over_m{std::max(camera.height_m - limits_.rays_from_m - limits_.step_m, 0.0f)};
  const float row{over_m / end_m_ - limits_.slope - camera.tangent(cx_px_, 0)};
  return static_cast<int>(std::clamp(row / camera.tangent_per_v, 0.0f, static_cast<float>(samples_.height())));
}

// Three loops, of which the second one becomes vectors.
LowObstacles::RowRead LowObstacles::read_row(View<const float> obstacle, View<const float> road, int v) {
  const TerrainCamera camera{camera_};  // members might change with each store
  const auto cells = static_cast<unsigned>(seen_.width());
  const float ahead{camera.tangent(cx_px_, static_cast<float>(v))};
  const int step{column_step(ahead > 0 ? camera.height_m / ahead : end_m_)};
  const float* const of_obstacles{obstacle.row(v)};
  const float* const of_road{road.row(v)};
  std::array<float, read_columns> columns;
  std::array<float, read_columns> disparities;
  std::array<float, read_columns> heights;
  std::array<float, read_columns> easts;
  std::array<float, read_columns> norths;
  Sample* const samples{samples_.row(v)};
  const float most{std::min(limits_.height_m, highest_m) * per_m};
  const float tangent{camera.tangent(0, static_cast<float>(v))};
  const float least_px{camera.focal_baseline_pxm / end_m_};
  const float most_px{camera.focal_baseline_pxm / cell_m_};  // cells whose middle is behind the camera have no samples
  const float sin_per_px{sin_ / camera.focal_px};
  const float cos_per_px{cos_ / camera.focal_px};
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
      read += disparity >= least_px && disparity <= most_px ? 1 : 0;
    }
    for (std::size_t i{0}; i < read; ++i) {
      const float x{camera.focal_baseline_pxm / disparities[i]};
      const float left_px{cx_px_ - columns[i]};
      heights[i] = per_m * (camera.height_m - (tangent + camera.tangent_per_u * columns[i]) * x);
      easts[i] = origin_east_ + (cos_ + sin_per_px * left_px) * x;
      norths[i] = origin_north_ + (cos_per_px * left_px - sin_) * x;
    }
    for (std::size_t i{0}; i < read; ++i) {
      const int ix{static_cast<int>(easts[i])};
      const int iy{static_cast<int>(norths[i])};
      if (static_cast<unsigned>(ix) >= cells || static_cast<unsigned>(iy) >= cells || !(std::abs(heights[i]) < most))
        continue;
      add(ix, columns_read);
      add(iy, rows_read);
      samples[count++] = {iy * seen_.width() + ix, static_cast<std::int16_t>(heights[i])};
    }
  }
  return {count, {columns_read.begin, columns_read.end + 1}, {rows_read.begin, rows_read.end + 1}};
}

void LowObstacles::sort_samples(int first_row) {
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
void LowObstacles::set_levels(const Terrain& terrain, int iy) {
  for (int ix{columns_.begin}; ix < columns_.end; ++ix) {
    const std::span<std::int16_t> heights{heights_of(ix, iy)};
    level_m_(ix, iy) = none_m;
    planes_(ix, iy).z = none_m;
    if (heights.empty()) continue;
    const auto top = heights.end() - decile_of(heights.size());
    const auto middle = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2);
    std::nth_element(heights.begin(), top, heights.end());
    if (middle < top) std::nth_element(heights.begin(), middle, top);
    level_m_(ix, iy) = static_cast<float>(*middle) / per_m;
    top_m_(ix, iy) = static_cast<float>(*top) / per_m;
    const float x{places_.x_of(ix, iy)};
    noise_m_(ix, iy) = camera_.elevation_sigma(camera_.height_m, x, terrain.sigma_px(x));
  }
}

// Weights of the cells' levels, and their sums along the row. At first levels near the frame's plane count, then those
// near the plane of the pass before, without cells over it: a field of stones, or a kerb, would raise the plane.
void LowObstacles::sum_along(int iy, int pass) {
  const auto weight_of = [&](int ix, float level) {
    if (pass == 0) {
      const float share{level / (3 * limits_.step_m + 0.15f * places_.x_of(ix, iy))};
      return 1 / (1 + share * share * share * share);
    }
    const float over{level - planes_(ix, iy).z};
    const float lowest{-2 * std::max(matched_share * limits_.step_m, sigmas * noise_m_(ix, iy))};
    const float highest{std::max(plane_share * limits_.step_m, plane_sigmas * noise_m_(ix, iy))};
    return over > lowest && over < highest ? 1.0f : 0.02f;
  };
  RowMoments sum{};
  for (int ix{columns_.begin}; ix < columns_.end + reach_; ++ix) {
    const int removed{ix - 2 * reach_ - 1};
    if (removed >= columns_.begin && weights_(removed, iy).n != 0) sum.add(weights_(removed, iy), removed, -1);
    if (ix < columns_.end) {
      const float level{level_m_(ix, iy)};
      Weight& weight{weights_(ix, iy)};
      weight = {0, 0};
      if (!std::isnan(level)) {
        weight.n = static_cast<int>(weight_of(ix, level) * full_weight + 0.5f);
        weight.z = weight.n * level * per_m;
        sum.add(weight, ix, 1);
      }
    }
    const int middle{ix - reach_};
    if (middle >= columns_.begin) moments_(middle, iy) = sum;
  }
}

void LowObstacles::fit_planes() {
  std::fill_n(sums_.begin(), columns_.end, Moments{});
  for (int iy{rows_.begin - reach_}; iy < rows_.end; ++iy) {
    const int added{iy + reach_};
    const int removed{iy - reach_ - 1};
    for (int ix{columns_.begin}; ix < columns_.end; ++ix) {
      Moments& sum{sums_[static_cast<std::size_t>(ix)]};
      if (added >= rows_.begin && added < rows_.end) sum.add(moments_(ix, added), added, 1);
      if (removed >= rows_.begin) sum.add(moments_(ix, removed), removed, -1);
      if (iy < rows_.begin || std::isnan(level_m_(ix, iy))) continue;
      Plane& plane{planes_(ix, iy)};
      plane = {none_m, 0, 0};
      if (sum.along.n < 3 * full_weight) continue;
      const double n{sum.along.n};
      const double x{sum.along.x / n};
      const double y{sum.y / n};
      const double z{sum.along.z / n};
      const double xx{sum.along.xx - n * x * x};
      const double xy{sum.xy - n * x * y};
      const double yy{sum.yy - n * y * y};
      const double xz{sum.along.xz - n * x * z};
      const double yz{sum.yz - n * y * z};
      const double det{xx * yy - xy * xy};
      double east{0};
      double north{0};
      if (det > 0.05 * xx * yy && xx > n && yy > n) {
        east = (xz * yy - yz * xy) / det;
        north = (yz * xx - xz * xy) / det;
      }
      const double here{z + east * (ix - x) + north * (iy - y)};
      plane = {static_cast<float>(here / per_m), static_cast<float>(east / per_m), static_cast<float>(north / per_m)};
    }
  }
}

// Heights over the plane in the middle of the cell.
void LowObstacles::compare(int iy) {
  for (int ix{columns_.begin}; ix < columns_.end; ++ix) {
    Seen& seen{seen_(ix, iy)};
    seen = {};
    const Plane& plane{planes_(ix, iy)};
    if (std::isnan(plane.z)) continue;
    const float rise_m{std::sqrt(plane.east * plane.east + plane.north * plane.north)};
    const float x{places_.x_of(ix, iy)};
    const float noise{noise_m_(ix, iy)};
    const float ground_m{plane.z + plane_sigmas * noise};  // levels left out lower the plane
    const float range_noise{noise * x / camera_.height_m};
    const float row_m{camera_.tangent_per_v * x};
    const float matched_m{matched_step_m(row_m)};
    float least{std::max({matched_share * limits_.step_m, matched_m, sigmas * noise,
                          2 * std::min(rise_m / cell_m_, limits_.slope) * range_noise})};
    std::span<const std::int16_t> heights{heights_of(ix, iy)};
    seen.count =
        std::min(static_cast<int>(heights.size()) * column_step(x) / column_step(end_m_), HeightMemory::samples_enough);
    if (top_m_(ix, iy) - ground_m <= least)
      heights = heights.last(static_cast<std::size_t>(decile_of(heights.size())));
    else
      least = std::max(least, depths * depth_around(ix, iy));
    const auto higher = [&](float height_m) {
      const float limit{(ground_m + height_m) * per_m};
      return static_cast<int>(
          std::ranges::count_if(heights, [limit](std::int16_t z) { return static_cast<float>(z) > limit; }));
    };
    seen.high = higher(least);
    seen.is_high = static_cast<float>(seen.high) >= std::max(3.0f, 0.1f * face_samples(x));
    seen.is_tall = seen.high > 1 && higher(limits_.rays_from_m) > 1;
    seen.height = std::clamp((top_m_(ix, iy) - ground_m) / matched_m, height_min, height_max);
  }
}

float LowObstacles::depth_around(int ix, int iy) const {
  float depth_m{0};
  for (int y{std::max(iy - reach_, rows_.begin)}; y <= std::min(iy + reach_, rows_.end - 1); ++y) {
    for (int x{std::max(ix - reach_, columns_.begin)}; x <= std::min(ix + reach_, columns_.end - 1); ++x)
      depth_m = std::max(depth_m, planes_(x, y).z - level_m_(x, y));  // not of cells without a plane: NaN
  }
  return depth_m;
}

float LowObstacles::matched_step_m(float row_m) const {
  return std::max(matched_mean * limits_.step_m, limits_.step_m - lost_rows_ * row_m);
}

int LowObstacles::column_step(float x) const {
  return std::max(static_cast<int>(camera_.focal_px * cell_m_ / (std::min(x, end_m_) * columns_enough)), 1);
}

float LowObstacles::face_samples(float x) const {
  const float row_m{camera_.tangent_per_v * x};
  return matched_step_m(row_m) * cell_m_ / (row_m * row_m * static_cast<float>(column_step(x)));
}

// Wrong matches are smaller than stones: the cell and those around it have as many high samples as the face of a step
// that is a cell wide.
bool LowObstacles::is_small(int ix, int iy) const {
  int high{0};
  for (int y{std::max(iy - 1, rows_.begin)}; y <= std::min(iy + 1, rows_.end - 1); ++y) {
    for (int x{std::max(ix - 1, columns_.begin)}; x <= std::min(ix + 1, columns_.end - 1); ++x)
      high += seen_(x, y).high;
  }
  return static_cast<float>(high) < face_samples(places_.x_of(ix, iy));
}

// Rays and the filter decide about tall things and the cells beside them, into which the matcher's window smears them.
void LowObstacles::leave_tall_obstacles(int ix, int iy) {
  const int reach{std::max(1, static_cast<int>(std::lround(tall_reach_m / cell_m_)))};
  for (int y{std::max(iy - reach, rows_.begin)}; y <= std::min(iy + reach, rows_.end - 1); ++y) {
    for (int x{std::max(ix - reach, columns_.begin)}; x <= std::min(ix + reach, columns_.end - 1); ++x) {
      seen_(x, y).is_beside_tall = true;
      seen_(x, y).is_high = false;
    }
  }
}

void LowObstacles::check() {
  for (int iy{rows_.begin}; iy < rows_.end; ++iy) {
    for (int ix{columns_.begin}; ix < columns_.end; ++ix) {
      Seen& seen{seen_(ix, iy)};
      if (seen.is_tall) leave_tall_obstacles(ix, iy);
      if ((seen.is_high || seen.height > HeightMemory::obstacle_height) && is_small(ix, iy)) seen.count = 0;
      seen.is_high = seen.is_high && seen.count > 0;
    }
  }
}

void LowObstacles::remember(const LowObstacles& of) {
  for (int iy{of.rows_.begin}; iy < of.rows_.end; ++iy) {
    for (int ix{of.columns_.begin}; ix < of.columns_.end; ++ix) {
      const Seen& seen{of.seen_(ix, iy)};
      if (seen.count == 0) continue;
      if (seen.is_beside_tall)
        memory_.clear(ix, iy);
      else
        memory_.add(ix, iy, seen.height, limits_.step_m / 8 / of.noise_m_(ix, iy), seen.count);
    }
  }
}

}  // namespace stereogrid
