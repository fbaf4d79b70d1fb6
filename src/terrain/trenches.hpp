// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <optional>
#include <vector>

#include "host_device.hpp"
#include "stereogrid/image.hpp"
#include "terrain/model.hpp"
#include "terrain/samples.hpp"

namespace stereogrid {

/// Trench of which only the upper part of the far wall is visible, or an edge with lower ground behind it.
struct Trench {
  float edge_x;  ///< last visible ground, m
  float wall_x;  ///< far wall or lower ground, m
  float fall_m;  ///< visible part of the wall, or the fall to the lower ground
  int row;       ///< row of the edge
  float gain;    ///< over ground without it
  float rest_px;
  int chain{1};  ///< number of sectors that have found it

  /// The chain is wide enough to extend it, and to ignore the noise of one sector.
  bool is_sure{false};

  friend bool operator==(const Trench&, const Trench&) = default;
};

// Model of the search, for CPU and GPU. Numbers were chosen on random layouts (seeds 401 to 480) and on recorded
// drives, where few matches may look like a trench.
constexpr float ground_growth_min{0.5f};  ///< growth of the disparity per row around it, relative to level ground
constexpr float rows_seen_min{0.8f};
constexpr float rest_floor_px{0.08f};  ///< noise of the mean of sectors
/// Largest rest of lower ground in a sector, chosen on random layouts: the edge of 36 needs it, and at 0.13 the valley
/// of 411 has one.
constexpr float rest_lower_px{1.5f * rest_floor_px};
constexpr float rest_alone_px{0.1f};  ///< largest rest without a long chain
constexpr float lower_slope{1.3f};    ///< least tangent of the line of sight to lower ground, relative to drop_slope
constexpr int sectors_beside{3};
constexpr int chain_rows{3};    ///< rows between the edges of a chain
constexpr int chain_reach{10};  ///< sectors from one trench of a chain to the next
constexpr int extension_reach{4};
constexpr std::array wall_rows_tried{0, 6, 7, 8, 10, 12, 14, 17, 20, 24};
constexpr int trench_shapes{static_cast<int>(wall_rows_tried.size())};

/// Mean disparity of a sector and its neighbours in a row, from at least half of them; 0: none. `count`: those with
/// one.
STEREOGRID_HD inline float mean_of_sectors(float sum, float count) {
  return count > sectors_beside ? sum / count : 0.0f;
}

/// Line with a fall, d = at_edge + growth·k − fall·shape(k), through a sector's rows k around an edge.
struct TrenchFit {
  float at_edge{0};
  float growth{0};
  float fall{0};
  float rest_px{0};
  float gain{0};  ///< over the line alone
};

/// Sums of a least-squares fit; row 0 of `x`: constant, 1: row, 2: shape.
struct TrenchSums {
  std::array<std::array<float, 3>, 3> xx{};
  std::array<float, 3> xy{};
  float yy{0};

  // Without loops: g++ would store numbers one by one and load two at once, which stalls.
  STEREOGRID_HD void add(float row, float shape, float y) {
    xx[0][0] += 1;
    xx[1][0] += row;
    xx[1][1] += row * row;
    xx[2][0] += shape;
    xx[2][1] += shape * row;
    xx[2][2] += shape * shape;
    xy[0] += y;
    xy[1] += row * y;
    xy[2] += shape * y;
    yy += y * y;
  }
  // By Cholesky's decomposition; the squared rest falls by beta² with each unknown.
  [[nodiscard]] STEREOGRID_HD TrenchFit fitted() const {
    std::array<std::array<float, 3>, 3> l{};
    std::array<float, 3> beta{};
    for (std::size_t i{0}; i < 3; ++i) {
      for (std::size_t j{0}; j <= i; ++j) {
        float rest{xx[i][j]};
        for (std::size_t k{0}; k < j; ++k) rest -= l[i][k] * l[j][k];
        l[i][j] = i == j ? std::sqrt(std::max(rest, 1e-6f)) : rest / l[j][j];
      }
      float rest{xy[i]};
      for (std::size_t k{0}; k < i; ++k) rest -= l[i][k] * beta[k];
      beta[i] = rest / l[i][i];
    }
    const float fall{beta[2] / l[2][2]};
    const float growth{(beta[1] - l[2][1] * fall) / l[1][1]};
    const float rows{xx[0][0]};
    const float squares{std::max(yy - beta[0] * beta[0] - beta[1] * beta[1] - beta[2] * beta[2], 0.0f)};
    return {(beta[0] - l[1][0] * growth - l[2][0] * fall) / l[0][0], growth, -fall, std::sqrt(squares / rows),
            beta[2] * beta[2] / (squares / rows + rest_floor_px * rest_floor_px)};
  }
};

/// Place where most of a fall must be seen.
struct TrenchProbe {
  int place;
  float along;  ///< place relative to the last one
  float fall;
};

/// Fall of the disparity below the ground's line at a far wall, in growths of the disparity per row, after the
/// matcher's smear. Without wall_rows: 1 on lower ground. The last row is the lowest one.
struct TrenchShape {
  static constexpr int rows_max{24 + 2 * 42 + 1};  // highest wall, and the ground around it by the largest window

  int wall_rows;
  int edge_place;  ///< row of the edge
  int rows;
  std::array<float, rows_max> fall{};
  std::array<TrenchProbe, 3> probes{};

  /// Fit around an edge with the mean disparity *edge; without enough rows: no gain. `kink`: growth of the fall per
  /// row, relative to that at the edge.
  [[nodiscard]] STEREOGRID_HD TrenchFit fit(const float* edge, float kink) const {
    const float* const d{edge - edge_place};
    TrenchSums sums;
    for (int i{0}; i < rows; ++i) {
      const auto row = static_cast<float>(i - edge_place);
      if (d[i] > 0) sums.add(row, fall[static_cast<std::size_t>(i)] * (1 + kink * row), d[i] - *edge);
    }
    return sums.xx[0][0] < rows_seen_min * static_cast<float>(rows) ? TrenchFit{} : sums.fitted();
  }
};

/// Condition for a fit, by which most of the work is saved: at a wall's edge, before it and in the middle of the wall
/// the disparities are below the line through the first and the last one, most of the shape's fall.
struct TrenchCheck {
  int last;
  float rise_min;
  float fall_min;
  std::array<TrenchProbe, 3> probes;

  /// `d`: the shape's first row.
  [[nodiscard]] STEREOGRID_HD int is_likely(const float* d) const {
    const float rise{d[last] - d[0]};
    int is_likely{(d[0] > 0) & (rise >= rise_min)};
    for (const TrenchProbe& one : probes) {
      const float there{d[one.place]};
      is_likely &= (there > 0) & (d[0] + one.along * rise - there >= fall_min * one.fall);
    }
    return is_likely;
  }
};

/// Bounds of a fit.
struct TrenchBounds {
  float fall_min;  ///< measured fall of the disparity, relative to that of an upright wall
  float fall_max;
  float wall_gain;      ///< least decrease of the squared differences by a wall, in squared noises
  float lower_gain;     ///< by lower ground
  float rest_px;        ///< largest root mean square difference from the best shape of a wall
  float rest_share;     ///< the same, relative to the jump at the edge; the larger bound counts
  float lower_rest_px;  ///< the same of lower ground
};
/// Bounds of a sector alone, and of one beside a long chain.
STEREOGRID_HD constexpr TrenchBounds alone_bounds() {
  return {0.7f, 1.6f, 130, 70, rest_alone_px, 0.05f, rest_lower_px};
}
STEREOGRID_HD constexpr TrenchBounds extension_bounds() {
  return {0.55f, 2.2f, 60, 40, 0.15f, 0.1f, 0.15f};
}

/// A sector of a frame that is searched.
struct TrenchSearch {
  STEREOGRID_HD TrenchSearch(const SampledGround& sampled, int sector, const TrenchBounds& fit_bounds, int ground_rows,
                             const float* mean_disparity)
      : bounds{fit_bounds},
        ground{sampled},
        tangent_at_row_0{ground.tangent_at_row_0(sector)},
        growth{ground.camera.level_growth(ground.camera.height_m)},
        margin{ground_rows},
        disparity{mean_disparity} {}

  TrenchBounds bounds;
  SampledGround ground;
  float tangent_at_row_0;
  float growth;            ///< growth of the disparity per row on level ground
  int margin;              ///< rows of ground on both sides
  const float* disparity;  ///< mean over neighbouring sectors, by row

  /// The line of sight falls as steeply as ground must be seen.
  [[nodiscard]] STEREOGRID_HD bool is_near(int row) const { return !(tangent(row) < ground.limits.drop_slope); }
  /// First row of an edge with a shape.
  [[nodiscard]] STEREOGRID_HD int first_edge(const TrenchShape& shape) const {
    return ground.first_row + shape.edge_place;
  }
  /// Jump of the disparity in a row to ground that is a step lower (4).
  [[nodiscard]] STEREOGRID_HD float step_px(int row) const {
    return disparity[row] * ground.limits.step_m / (ground.camera.height_m + ground.limits.step_m);
  }
  [[nodiscard]] STEREOGRID_HD TrenchCheck check(const TrenchShape& shape) const {
    return {shape.rows - 1, static_cast<float>(shape.rows - 1) * ground_growth_min * growth,
            0.8f * bounds.fall_min * growth, shape.probes};
  }
  // Most of the fall is there; lower ground falls in the rows of the matcher's window.
  [[nodiscard]] STEREOGRID_HD bool is_lower(int edge) const {
    constexpr float share{0.6f};
    const int half{std::min(margin, 5)};  // within the shape
    if (edge - margin < ground.first_row) return false;
    const float* const d{disparity + edge};
    const float level_px{static_cast<float>(2 * half) * growth};
    return d[-half] > 0 && d[half] - d[-half] > level_px + share * step_px(edge);
  }
  /// A trench with a shape's wall; without wall_rows: an edge with lower ground.
  [[nodiscard]] STEREOGRID_HD std::optional<Trench> at(const TrenchShape& shape, int edge) const {
    return shape.wall_rows > 0 ? wall(shape, edge) : lower_ground(shape, edge);
  }

 private:
  [[nodiscard]] STEREOGRID_HD float tangent(int row) const {
    return tangent_at_row_0 + ground.camera.tangent_per_v * static_cast<float>(row);
  }
  [[nodiscard]] STEREOGRID_HD std::optional<Trench> wall(const TrenchShape& shape, int edge) const {
    const auto rows = static_cast<float>(shape.wall_rows);
    const TrenchFit fit{shape.fit(disparity + edge, 0)};
    if (!is_within(fit, bounds.wall_gain, std::max(bounds.rest_px, bounds.rest_share * fit.fall * rows)) ||
        fit.fall < bounds.fall_min * growth || fit.fall > bounds.fall_max * growth)
      return {};
    const TerrainCamera& camera{ground.camera};
    const float edge_px{disparity[edge] + fit.at_edge};
    const float wall_x{camera.range(std::max(edge_px - fit.growth * rows, 1.0f))};
    const float edge_x{camera.range(edge_px)};
    const float widest{wall_x - edge_x + 2 * camera.range_sigma(edge_x, block_sigma_px)};
    if (widest < static_cast<float>(crossed_ditch) * ground.limits.step_m) return {};
    return Trench{edge_x, wall_x, rows * camera.tangent_per_v * wall_x, edge, fit.gain, fit.rest_px};
  }
  // Disparities of ground that is lower by more than a step are lower by the share D/(h + D), in each row (4).
  [[nodiscard]] STEREOGRID_HD std::optional<Trench> lower_ground(const TrenchShape& shape, int edge) const {
    if (tangent(edge) < lower_slope * ground.limits.drop_slope) return {};
    const TrenchFit fit{shape.fit(disparity + edge, growth / disparity[edge])};
    if (!is_within(fit, bounds.lower_gain, bounds.lower_rest_px) || fit.fall < step_px(edge)) return {};
    const TerrainCamera& camera{ground.camera};
    const float edge_px{disparity[edge] + fit.at_edge};
    const float behind_px{std::max(edge_px - fit.fall, 1.0f)};
    return Trench{camera.range(edge_px),
                  camera.range(behind_px),
                  camera.height_m * fit.fall / behind_px,
                  edge,
                  fit.gain,
                  fit.rest_px};
  }
  [[nodiscard]] STEREOGRID_HD bool is_within(const TrenchFit& fit, float gain, float rest_px) const {
    return fit.gain > gain && fit.growth > ground_growth_min * growth && fit.rest_px < rest_px;
  }
};

/// Chains of trenches in neighbouring sectors, for CPU and GPU.
struct TrenchChains {
  std::optional<Trench>* found;  ///< by sector
  int sectors;

  /// Sets the chains' lengths, and drops trenches that need a long one.
  STEREOGRID_HD void connect(const SampledGround& ground) const {
    for (int sector{0}; sector < sectors; ++sector) {
      std::optional<Trench>& trench{found[sector]};
      const Trench* const last{trench ? beside(sector, -1, chain_reach, trench->row) : nullptr};
      if (last != nullptr) trench->chain = last->chain + 1;
    }
    for (int sector{sectors - 1}; sector >= 0; --sector) {
      std::optional<Trench>& trench{found[sector]};
      if (!trench) continue;
      Trench* const last{beside(sector, -1, chain_reach, trench->row)};
      if (last != nullptr) last->chain = std::max(last->chain, trench->chain);
      const float width_m{static_cast<float>(trench->chain * sector_px) * trench->edge_x / ground.camera.focal_px};
      trench->is_sure = width_m >= ground.limits.height_m;
      if (!trench->is_sure && trench->rest_px > rest_alone_px) trench.reset();
    }
  }
  /// Trench of a long chain before a sector without one, towards `side`: it may extend to the sector. Null: none.
  [[nodiscard]] STEREOGRID_HD const Trench* extending(int sector, int side) const {
    if (found[sector]) return nullptr;
    const Trench* const other{beside(sector, -side, extension_reach, no_row)};
    return other != nullptr && other->is_sure ? other : nullptr;
  }

 private:
  /// Nearest trench to one side of a sector, with its edge near `row`; no_row: in any row.
  [[nodiscard]] STEREOGRID_HD Trench* beside(int sector, int side, int reach, int row) const {
    for (int offset{1}; offset <= reach; ++offset) {
      const int there{sector + side * offset};
      if (there < 0 || there >= sectors) break;
      std::optional<Trench>& trench{found[there]};
      if (trench && (row == no_row || std::abs(trench->row - row) <= chain_rows)) return &*trench;
    }
    return nullptr;
  }
};

/// Rows of ground on both sides of a trench, of a matcher that smears a jump over `window_rows`.
constexpr int trench_margin_of(int window_rows) {
  return window_rows + 1;
}
/// Shapes of that matcher, by wall_rows_tried.
std::vector<TrenchShape> trench_shapes_of(int window_rows);

/// Finds trenches by a matched filter over the rows of a sector (docs/terrain.md, "Trenches").
class TrenchFilter {
 public:
  /// Sectors from one that is searched to the next.
  static constexpr int step{3};

  /// `window_rows`: rows over which the matcher smears a jump.
  TrenchFilter(int height_px, int sectors, int window_rows);

  /// Begins a frame. `medians`: (row, sector), from ground.first_row on; valid until the end of connect().
  void begin(const SampledGround& ground, View<const float> medians);
  /// Finds the most certain trench of a sector.
  void find(int sector);
  /// Finds that of a sector between two that have been searched, near the rows of theirs: their mean disparities are
  /// mostly of the same sectors.
  void find_between(int sector);
  /// Finds those of all sectors; `for_ranges`: see Terrain::place().
  template <class ForRanges>
  void find_all(const ForRanges& for_ranges) {
    const auto for_sectors = [&](const auto& work) {
      for_ranges(disparity_.height(), [&](int first, int end) {
        for (int sector{first}; sector < end; ++sector) work(sector);
      });
    };
    for_sectors([&](int sector) {
      if (sector % step == 0) find(sector);
    });
    for_sectors([&](int sector) {
      if (sector % step != 0) find_between(sector);
    });
  }
  /// Extends long chains of trenches to sectors beside them.
  void connect();

  [[nodiscard]] const std::optional<Trench>& at(int sector) const { return found_[static_cast<std::size_t>(sector)]; }
  [[nodiscard]] std::size_t memory_bytes() const;

 private:
  [[nodiscard]] std::optional<Trench>& at(int sector) { return found_[static_cast<std::size_t>(sector)]; }
  [[nodiscard]] TrenchSearch search(int sector, const TrenchBounds& bounds);
  /// The most certain trench with its edge in rows `lowest` to `highest`, upwards.
  [[nodiscard]] std::optional<Trench> best(const TrenchSearch& search, int lowest, int highest) const;

  Image<float> disparity_;  ///< mean over neighbouring sectors, (row, sector)
  int margin_;              ///< rows of ground on both sides
  std::vector<TrenchShape> shapes_;
  std::vector<std::optional<Trench>> found_;  ///< by sector
  SampledGround ground_;
  View<const float> medians_{};
};

}  // namespace stereogrid
