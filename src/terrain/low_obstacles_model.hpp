// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "geometry/grid_in_vehicle.hpp"
#include "host_device.hpp"
#include "numbers.hpp"
#include "terrain/height_memory.hpp"
#include "terrain/model.hpp"
#include "terrain/rings.hpp"

namespace stereogrid {

/// Weight of a cell, and the same times its level in 1/4096 m.
template <class Number>
struct LowWeight {
  Number n;
  Number z;
};

/// Sums of a weighted fit z = g + a·x + b·y along a row of the window; x in cells, z in 1/4096 m. All are whole and
/// below 2^53, so that they are exact in both kinds of numbers, and do not depend on the order.
template <class Number>
struct LowRowMoments {
  Number n, x, xx, z, xz;

  STEREOGRID_HD void add(const LowWeight<Number>& of, Number at_x, Number sign) {
    const LowWeight<Number> more{sign * of.n, sign * of.z};
    n += more.n;
    x += more.n * at_x;
    xx += more.n * at_x * at_x;
    z += more.z;
    xz += more.z * at_x;
  }
};

template <class Number>
struct LowMoments {
  LowRowMoments<Number> along;
  Number y, xy, yy, yz;

  STEREOGRID_HD void add(const LowRowMoments<Number>& of, Number at_y, Number sign) {
    along.n += sign * of.n;
    along.x += sign * of.x;
    along.xx += sign * of.xx;
    along.z += sign * of.z;
    along.xz += sign * of.xz;
    const Number times_y{sign * at_y};
    y += times_y * of.n;
    xy += times_y * of.x;
    yy += times_y * at_y * of.n;
    yz += times_y * of.z;
  }
};

/// Ground around a cell.
struct LowPlane {
  float z;     ///< at the middle of the cell, m; NaN: none
  float east;  ///< rise, m per cell
  float north;
  float fall;  ///< depth below that of the pass before, m; NaN: none
};

/// Result of the samples of a cell.
struct LowSeen {
  int count;   ///< samples, up to HeightMemory::samples_enough; 0: none, or wrong ones
  int raised;  ///< samples of what may be an obstacle
  bool is_high;
  bool is_tall;         ///< it has samples at the height of what rays show
  bool is_beside_tall;  ///< it or a neighbour is; on the CPU
  float height;         ///< upper decile over the plane, in units of what the matcher leaves of a step
};

/// A cell of the window whose samples count.
struct LowCell {
  std::uint16_t ix;
  std::uint16_t iy;
  float height;        ///< see LowSeen
  float noise_m;       ///< standard deviation of a sample's height
  std::uint8_t count;  ///< see LowSeen
  bool is_high;        ///< something is higher than the ground around
  bool is_tall;        ///< see LowSeen
  bool is_beside_tall;
};

/// A frame's low obstacles in the cells of a window: geometry, limits and formulas, for CPU and GPU.
struct LowModel {
  static constexpr float none_m{std::numeric_limits<float>::quiet_NaN()};
  static constexpr float per_m{4096};        ///< unit of heights
  static constexpr float highest_m{7.9f};    ///< heights in that unit have 16 bits
  static constexpr float columns_enough{4};  ///< columns of a cell that are read, at least
  static constexpr float full_weight{64};    ///< weight of a cell that is on the plane
  static constexpr int plane_passes{3};

  // Shares were chosen on flat floors, rubble, the course and random layouts of seeds 401 to 440 and 701 to 708.

  /// Half the side of the square whose cells the plane goes through, in heights of the vehicle.
  static constexpr float plane_reach{0.6f};
  /// The matcher's window lowers small stones of a step's height to this share.
  static constexpr float matched_share{0.75f};
  static constexpr float matched_mean{0.53f};  ///< the same of its mean over frames
  /// Standard deviations of a sample's height that are noise.
  static constexpr float sigmas{2.5f};
  /// Highest levels of ground over the plane, as a share of a step and in standard deviations.
  static constexpr float plane_share{0.1f};
  static constexpr float plane_sigmas{0.5f};
  static constexpr float plane_below{2};  ///< lowest ones of the last pass below it, relative to these
  /// A plane that has fallen by more standard deviations than that was lifted by stones, which may be more than half of
  /// the cells; one that has fallen by more than that share of a step lies between both sides of an edge.
  static constexpr float lifted_sigmas{1.5f};
  static constexpr float lifted_share{0.5f};
  /// Least height of an obstacle relative to the depth of the lowest level around it: errors are on both sides.
  static constexpr float depths{1.75f};
  /// Samples over this share of what the matcher leaves of a step are those of an obstacle's face and top,
  static constexpr float raised_share{0.5f};
  static constexpr float raised_faces{2};  ///< and are as many as such faces have
  /// Distance around tall obstacles: a walker moves as far in a frame, and the matcher smears as far.
  static constexpr float tall_reach_m{0.2f};

  // Limits of heights in units of what the matcher leaves of a step.
  static constexpr float height_min{-2};
  static constexpr float height_max{6};

  /// A row of the image.
  struct Row {
    float tangent;  ///< tangent of the line of sight of its first pixel
    int step;       ///< columns between samples
  };
  /// A pixel over the frame's plane.
  struct Place {
    float height;  ///< 1/4096 m
    float east;    ///< in the window, cells
    float north;
  };
  /// Limits in a cell with a plane.
  struct Limits {
    float x;  ///< range, m
    float ground_m;
    float matched_m;  ///< height that the matcher leaves of a step
    float least_m;    ///< height over the ground of an obstacle
  };

  LowModel(const Rig& level_rig, const TerrainLimits& of_terrain, double cell_size_m, int window_cells, int window_px,
           int disparities);

  /// Sets the frame. `checked_m`: range up to which its noise allows to find them.
  void begin(const TerrainCamera& of_frame, const GridInVehicle& window, float checked_m);

  [[nodiscard]] STEREOGRID_HD Row row(int v) const {
    const float ahead{camera.tangent(cx_px, static_cast<float>(v))};
    return {camera.tangent(0, static_cast<float>(v)), column_step(ahead > 0 ? camera.height_m / ahead : end_m)};
  }
  [[nodiscard]] STEREOGRID_HD bool is_in_range(float disparity) const {
    return disparity >= least_px && disparity <= most_px;
  }
  [[nodiscard]] STEREOGRID_HD Place place(const Row& of, float column, float disparity) const {
    const float x{camera.focal_baseline_pxm / disparity};
    const float left_px{cx_px - column};
    return {per_m * (camera.height_m - (of.tangent + camera.tangent_per_u * column) * x),
            origin_east + (cos_yaw + sin_per_px * left_px) * x, origin_north + (cos_per_px * left_px - sin_yaw) * x};
  }
  [[nodiscard]] STEREOGRID_HD bool is_sample(int ix, int iy, float height) const {
    return static_cast<unsigned>(ix) < static_cast<unsigned>(cells) &&
           static_cast<unsigned>(iy) < static_cast<unsigned>(cells) && std::abs(height) < most;
  }
  /// Samples of a cell that are its upper decile.
  [[nodiscard]] STEREOGRID_HD static int decile_of(int samples) { return (samples + 9) / 10; }

  [[nodiscard]] STEREOGRID_HD static float height_m(std::int16_t sample) { return static_cast<float>(sample) / per_m; }

  /// Noise of heights x m ahead. `noise_px`: see Terrain::noise_px().
  [[nodiscard]] STEREOGRID_HD float noise_m(float x, const float* noise_px) const {
    const float place{Min(camera.focal_baseline_pxm / x * Rings::places_per_px, last_place)};
    return camera.elevation_sigma(camera.height_m, x, noise_px[static_cast<int>(Max(place, 0.0f))]);
  }
  /// Weight of a level. At first levels near the frame's plane count, then those near the plane of the pass before.
  /// Cells over it, as a kerb, would raise it, errors below it would lower it, unless it is still too high.
  [[nodiscard]] STEREOGRID_HD float weight_of(int pass, float x, float level, const LowPlane& plane,
                                              float noise) const {
    if (pass == 0) {
      const float share{level / (3 * limits.step_m + 0.15f * x)};
      return 1 / (1 + share * share * share * share);
    }
    const float over{level - plane.z};
    const bool is_lifted{plane.fall > lifted_sigmas * noise && plane.fall < lifted_share * limits.step_m};
    const float highest{Max(plane_share * limits.step_m, plane_sigmas * noise)};
    const float lowest{pass == plane_passes - 1 && !is_lifted
                           ? -plane_below * highest
                           : -2 * Max(matched_share * limits.step_m, sigmas * noise)};
    return over >= highest ? 0.0f : over > lowest ? 1.0f : 0.02f;
  }
  /// A level with its weight.
  template <class Number>
  [[nodiscard]] STEREOGRID_HD LowWeight<Number> weighted(int pass, float x, float level, const LowPlane& plane,
                                                         float noise) const {
    const auto n = static_cast<Number>(static_cast<int>(weight_of(pass, x, level, plane, noise) * full_weight + 0.5f));
    return {n, n * static_cast<Number>(level * per_m)};
  }
  /// `before_m`: height of the plane of the pass before; NaN: none.
  template <class Number>
  [[nodiscard]] STEREOGRID_HD static LowPlane plane_of(const LowMoments<Number>& sum, int ix, int iy, float before_m) {
    const auto n = static_cast<double>(sum.along.n);
    if (n < 3 * full_weight) return {none_m, 0, 0, none_m};
    const double x{static_cast<double>(sum.along.x) / n};
    const double y{static_cast<double>(sum.y) / n};
    const double z{static_cast<double>(sum.along.z) / n};
    const double xx{static_cast<double>(sum.along.xx) - n * x * x};
    const double xy{static_cast<double>(sum.xy) - n * x * y};
    const double yy{static_cast<double>(sum.yy) - n * y * y};
    const double xz{static_cast<double>(sum.along.xz) - n * x * z};
    const double yz{static_cast<double>(sum.yz) - n * y * z};
    const double det{xx * yy - xy * xy};
    double east{0};
    double north{0};
    if (det > 0.05 * xx * yy && xx > n && yy > n) {
      east = (xz * yy - yz * xy) / det;
      north = (yz * xx - xz * xy) / det;
    }
    const double here{z + east * (ix - x) + north * (iy - y)};
    const auto here_m = static_cast<float>(here / per_m);
    return {here_m, static_cast<float>(east / per_m), static_cast<float>(north / per_m), before_m - here_m};
  }
  /// Heights over the plane in the middle of the cell.
  [[nodiscard]] STEREOGRID_HD Limits limits_of(const LowPlane& plane, float x, float noise) const {
    const float rise_m{std::sqrt(plane.east * plane.east + plane.north * plane.north)};
    const float range_noise{noise * x / camera.height_m};
    const float matched_m{matched_step_m(camera.tangent_per_v * x)};
    return {x, plane.z, matched_m,
            Max(Max(Max(matched_share * limits.step_m, matched_m), sigmas * noise),
                2 * Min(rise_m / cell_m, limits.slope) * range_noise)};
  }
  /// True: the upper decile is higher than that over the ground.
  [[nodiscard]] STEREOGRID_HD static bool is_over(const Limits& of, float top_m, float height_m) {
    return top_m - of.ground_m > height_m;
  }
  /// A height over the ground in units of samples.
  [[nodiscard]] STEREOGRID_HD static float over(const Limits& of, float height_m) {
    return (of.ground_m + height_m) * per_m;
  }
  /// `samples` of the cell; `raised` ones; `high` ones; `tall` ones: those over the height of what rays show.
  [[nodiscard]] STEREOGRID_HD LowSeen seen(const Limits& of, float top_m, int samples, int raised, int high,
                                           int tall) const {
    LowSeen seen{};
    seen.count = Min(samples * column_step(of.x) / column_step(end_m), HeightMemory::samples_enough);
    seen.raised = raised;
    seen.is_high = static_cast<float>(high) >= Max(3.0f, 0.1f * face_samples(of.x));
    seen.is_tall = high > 1 && tall > 1;
    seen.height = Min(Max((top_m - of.ground_m) / of.matched_m, height_min), height_max);
    return seen;
  }
  /// Wrong matches are smaller than stones. `raised`: samples of the cell and those around it.
  [[nodiscard]] STEREOGRID_HD bool is_small(float x, int raised) const {
    return static_cast<float>(raised) < raised_faces * face_samples(x);
  }
  /// Rays and the filter decide about tall things and the cells beside them, into which the matcher's window smears
  /// them.
  [[nodiscard]] STEREOGRID_HD static bool is_high(const LowSeen& seen, bool is_beside_tall) {
    return seen.is_high && !is_beside_tall;
  }
  /// True: the cell must not be small. Tall ones may: bars are.
  [[nodiscard]] STEREOGRID_HD static bool is_obstacle(const LowSeen& seen, bool is_beside_tall) {
    return is_high(seen, is_beside_tall) || (!seen.is_tall && seen.height > HeightMemory::obstacle_height);
  }
  [[nodiscard]] STEREOGRID_HD static LowCell cell(int ix, int iy, const LowSeen& seen, bool is_beside_tall,
                                                  float noise) {
    return {static_cast<std::uint16_t>(ix),        static_cast<std::uint16_t>(iy), seen.height,  noise,
            static_cast<std::uint8_t>(seen.count), is_high(seen, is_beside_tall),  seen.is_tall, is_beside_tall};
  }
  /// True: the camera sees ground in the cell if nothing is before it.
  [[nodiscard]] bool is_in_view(int ix, int iy) const {
    const float x{places.x_of(ix, iy)};
    const float u{cx_px - camera.focal_px * places.y_of(ix, iy) / x};
    return x >= near_m && x < end_m && u >= 0 && u < static_cast<float>(columns);
  }
  /// Height that the matcher leaves of a step, where a row of the image is row_m high.
  [[nodiscard]] STEREOGRID_HD float matched_step_m(float row_m) const {
    return Max(matched_mean * limits.step_m, limits.step_m - lost_rows * row_m);
  }
  /// Height over the ground of a mean height in memory, m: the matcher takes as much of a high face as of a step.
  [[nodiscard]] float height_of(float mean) const { return limits.step_m * (1 + matched_mean * (mean - 1)); }
  /// Columns between samples on ground x m ahead.
  [[nodiscard]] STEREOGRID_HD int column_step(float x) const {
    return Max(static_cast<int>(camera.focal_px * cell_m / (Min(x, end_m) * columns_enough)), 1);
  }
  /// Samples of the face of such a step that is a cell wide.
  [[nodiscard]] STEREOGRID_HD float face_samples(float x) const {
    const float row_m{camera.tangent_per_v * x};
    return matched_step_m(row_m) * cell_m / (row_m * row_m * static_cast<float>(column_step(x)));
  }
  TerrainLimits limits;
  float cell_m;
  float cx_px;
  int columns;       ///< width of the image
  int rows;          ///< height of the image
  float last_place;  ///< the last one in a table of noise
  int cells;         ///< side of the window
  int reach;         ///< cells on both sides of a plane's cell
  int tall_reach;    ///< cells around tall obstacles
  float lost_rows;   ///< rows of a face that the matcher's window takes
  float most;        ///< highest sample, 1/4096 m

  // Data of a frame.
  TerrainCamera camera;
  CellPlaces places;
  int first_row{0};  ///< the first one with ground, or with the lowest part of tall things on it
  float end_m{0};    ///< range of samples
  float near_m{0};   ///< nearest ground in view
  float least_px{0};
  float most_px{0};  ///< cells whose middle is behind the camera have no samples
  float origin_east{0};
  float origin_north{0};
  float cos_yaw{1};  ///< cosine of the window, times cells per m
  float sin_yaw{0};
  float sin_per_px{0};
  float cos_per_px{0};
};

}  // namespace stereogrid
