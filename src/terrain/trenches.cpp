// SPDX-License-Identifier: Apache-2.0
#include "terrain/trenches.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <utility>

#include "memory_bytes.hpp"

namespace stereogrid {
namespace {

// Chosen on random layouts (seeds 401 to 480) and on recorded drives, where few matches may look like a trench.
constexpr int sectors_beside{3};
constexpr std::array wall_rows_tried{0, 6, 7, 8, 10, 12, 14, 17, 20, 24};
constexpr float ground_growth_min{0.5f};  ///< growth of the disparity per row around it, relative to level ground
constexpr float rows_seen_min{0.8f};
constexpr float rest_floor_px{0.08f};  ///< noise of the mean of sectors
constexpr float rest_alone_px{0.1f};   ///< largest rest without a long chain
constexpr float lower_slope{1.3f};     ///< least tangent of the line of sight to lower ground, relative to drop_slope
constexpr int chain_reach{10};         ///< sectors from one trench of a chain to the next
constexpr int chain_rows{3};           ///< rows between their edges
constexpr int sure_sectors{9};         ///< least length of a long chain, which is as wide as the vehicle is high
constexpr int extension_reach{4};

/// Sums of a least-squares fit; row 0 of `x`: constant, 1: row, 2: shape.
struct Sums {
  std::array<std::array<float, 3>, 3> xx{};
  std::array<float, 3> xy{};
  float yy{0};

  // Without loops: g++ would store numbers one by one and load two at once, which stalls.
  void add(float row, float shape, float y) {
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
};

// By Cholesky's decomposition; the squared rest falls by beta² with each unknown.
TrenchFit fitted(const Sums& sums) {
  std::array<std::array<float, 3>, 3> l{};
  std::array<float, 3> beta{};
  for (std::size_t i{0}; i < 3; ++i) {
    for (std::size_t j{0}; j <= i; ++j) {
      float rest{sums.xx[i][j]};
      for (std::size_t k{0}; k < j; ++k) rest -= l[i][k] * l[j][k];
      l[i][j] = i == j ? std::sqrt(std::max(rest, 1e-6f)) : rest / l[j][j];
    }
    float rest{sums.xy[i]};
    for (std::size_t k{0}; k < i; ++k) rest -= l[i][k] * beta[k];
    beta[i] = rest / l[i][i];
  }
  const float fall{beta[2] / l[2][2]};
  const float growth{(beta[1] - l[2][1] * fall) / l[1][1]};
  const float rows{sums.xx[0][0]};
  const float squares{std::max(sums.yy - beta[0] * beta[0] - beta[1] * beta[1] - beta[2] * beta[2], 0.0f)};
  return {(beta[0] - l[1][0] * growth - l[2][0] * fall) / l[0][0], growth, -fall, std::sqrt(squares / rows),
          beta[2] * beta[2] / (squares / rows + rest_floor_px * rest_floor_px)};
}

// Mean disparity of a sector and its neighbours by row, from at least half of them; 0: none.
void write_means(const TerrainSamples& samples, int sector, float* mean) {
  constexpr int block_rows{64};
  const SectorRows rows{samples.rows(sector)};
  for (int begin{rows.first_row}; begin < rows.end_row; begin += block_rows) {
    const int end{std::min(begin + block_rows, rows.end_row)};
    std::array<float, block_rows> sum{};
    std::array<float, block_rows> count{};
    for (int i{-sectors_beside}; i <= sectors_beside; ++i) {
      const float* const disparity{samples.rows(std::clamp(sector + i, 0, samples.sectors() - 1)).disparity + begin};
      for (std::size_t k{0}; k < static_cast<std::size_t>(end - begin); ++k) {
        sum[k] += disparity[k];
        count[k] += static_cast<float>(disparity[k] > 0);
      }
    }
    for (int v{begin}; v < end; ++v) {
      const auto k = static_cast<std::size_t>(v - begin);
      mean[v] = count[k] > sectors_beside ? sum[k] / count[k] : 0.0f;
    }
  }
}

// Fit of a shape, its element `edge_place` in the row of `edge`; without enough rows: no gain.
TrenchFit fit_of(const float* edge, const std::vector<float>& fall, int edge_place) {
  const float* const d{edge - edge_place};
  Sums sums;
  for (std::size_t i{0}; i < fall.size(); ++i) {
    if (d[i] > 0) sums.add(static_cast<float>(i) - static_cast<float>(edge_place), fall[i], d[i] - *edge);
  }
  return sums.xx[0][0] < rows_seen_min * static_cast<float>(fall.size()) ? TrenchFit{} : fitted(sums);
}

}  // namespace

/// Bounds of a fit, and the sector that is searched.
struct TrenchFilter::Search {
  float fall_min;  ///< measured fall of the disparity, relative to that of an upright wall
  float fall_max;
  float wall_gain;   ///< least decrease of the squared differences by a wall, in squared noises
  float lower_gain;  ///< by lower ground
  float rest_px;     ///< largest root mean square difference from the best shape
  float rest_share;  ///< the same, relative to the jump at the edge; the larger bound counts
  const TerrainCamera* camera{nullptr};
  const TerrainLimits* limits{nullptr};
  SectorRows rows{};
  const float* disparity{nullptr};
  float growth{0};  ///< growth of the disparity per row on level ground

  /// Jump of the disparity in a row to ground that is a step lower (4).
  [[nodiscard]] float step_px(int row) const {
    return disparity[row] * limits->step_m / (camera->height_m + limits->step_m);
  }
};

// Most of the fall is there; lower ground falls in the rows of the matcher's window.
bool TrenchFilter::is_lower(const Search& search, int edge) const {
  constexpr float share{0.6f};
  const int half{std::min(margin_, 5)};  // within the shape
  const float* const d{search.disparity + edge};
  const float level_px{static_cast<float>(2 * half) * search.growth};
  return d[-half] > 0 && d[half] - d[-half] > level_px + share * search.step_px(edge);
}

// At a wall's edge, before it and in the middle of the wall the disparities are below the line through the first and
// the last one. Sets `bit` of the edges where most of that fall is there, in a loop that g++ turns into vectors.
void TrenchFilter::Shape::mark_likely(const Search& search, int first, int end, int bit, int* likely) const {
  const float* const d{search.disparity + first - edge_place};
  const auto last = static_cast<std::ptrdiff_t>(fall.size() - 1);
  const float rise_min{static_cast<float>(last) * ground_growth_min * search.growth};
  const float least{0.8f * search.fall_min * search.growth};
  const std::array<Probe, 3> probe{probes};
  for (std::ptrdiff_t i{0}; i < end - first; ++i) {
    const float rise{d[i + last] - d[i]};
    int is_likely{(d[i] > 0) & (rise >= rise_min)};
    for (const Probe& one : probe) {
      const float there{d[i + one.place]};
      is_likely &= (there > 0) & (d[i] + one.along * rise - there >= least * one.fall);
    }
    likely[i] |= is_likely * bit;
  }
}

TrenchFilter::TrenchFilter(int height_px, int sectors, int window_rows)
    : disparity_{height_px, sectors}, margin_{window_rows + 1}, found_(static_cast<std::size_t>(sectors)) {
  for (const int wall_rows : wall_rows_tried) {
    Shape shape{wall_rows, wall_rows + margin_};
    shape.fall.resize(static_cast<std::size_t>(wall_rows + 2 * margin_ + 1));
    for (std::size_t i{0}; i < shape.fall.size(); ++i) {
      const int above{shape.edge_place - static_cast<int>(i)};  // rows above the edge
      float sum{0};
      for (int row{above - window_rows / 2}; row <= above + window_rows / 2; ++row) {
        if (wall_rows == 0) sum += row == 0 ? 0.5f : static_cast<float>(row > 0);
        if (row >= 0 && row <= wall_rows) sum += static_cast<float>(wall_rows - row);
      }
      shape.fall[i] = sum / static_cast<float>(window_rows);
    }
    const float last{static_cast<float>(shape.fall.size() - 1)};
    const std::size_t edge{(shape.fall.size() - 1 + static_cast<std::size_t>(wall_rows)) / 2};
    std::ranges::transform(std::array{edge, edge + 2, edge - static_cast<std::size_t>(wall_rows) / 2},
                           shape.probes.begin(), [&](std::size_t place) {
                             return Probe{place, static_cast<float>(place) / last, shape.fall[place]};
                           });
    shapes_.push_back(std::move(shape));
  }
}

void TrenchFilter::find(const TerrainCamera& camera, const TerrainLimits& limits, const TerrainSamples& samples,
                        int sector) {
  Search search{0.7f, 1.6f, 130, 70, rest_alone_px, 0.05f};
  place(search, camera, limits, samples, sector);
  at(sector) = best(search, search.rows.end_row, search.rows.first_row);
}

void TrenchFilter::find_between(const TerrainCamera& camera, const TerrainLimits& limits, const TerrainSamples& samples,
                                int sector) {
  at(sector).reset();
  for (const int side : {-1, 1}) {
    const Trench* const other{beside(sector, side, step - 1, no_row)};
    if (other == nullptr) continue;
    Search search{0.7f, 1.6f, 130, 70, rest_alone_px, 0.05f};
    place(search, camera, limits, samples, sector);
    const std::optional<Trench> found{best(search, other->row + chain_rows, other->row - chain_rows)};
    if (found && (!at(sector) || found->gain > at(sector)->gain)) at(sector) = found;
  }
}

void TrenchFilter::connect(const TerrainCamera& camera, const TerrainLimits& limits, const TerrainSamples& samples) {
  const int sectors{disparity_.height()};
  for (int sector{0}; sector < sectors; ++sector) {
    std::optional<Trench>& trench{at(sector)};
    const Trench* const last{trench ? beside(sector, -1, chain_reach, trench->row) : nullptr};
    if (last != nullptr) trench->chain = last->chain + 1;
  }
  for (int sector{sectors - 1}; sector >= 0; --sector) {
    std::optional<Trench>& trench{at(sector)};
    if (!trench) continue;
    Trench* const last{beside(sector, -1, chain_reach, trench->row)};
    if (last != nullptr) last->chain = std::max(last->chain, trench->chain);
    const float width_m{static_cast<float>(trench->chain * sector_px) * trench->edge_x / camera.focal_px};
    trench->is_sure = trench->chain >= sure_sectors && width_m >= limits.height_m;
    if (!trench->is_sure && trench->rest_px > rest_alone_px) trench.reset();
  }
  Search search{0.55f, 2.2f, 60, 40, 0.15f, 0.1f};
  const auto extend = [&](int sector, int side) {
    if (at(sector)) return;
    const Trench* const other{beside(sector, -side, extension_reach, no_row)};
    if (other == nullptr || !other->is_sure) return;
    place(search, camera, limits, samples, sector);
    at(sector) = best(search, other->row + chain_rows, other->row - chain_rows);
    if (at(sector)) at(sector)->is_sure = true;
  };
  for (int sector{0}; sector < sectors; ++sector) extend(sector, 1);
  for (int sector{sectors - 1}; sector >= 0; --sector) extend(sector, -1);
}

void TrenchFilter::place(Search& search, const TerrainCamera& camera, const TerrainLimits& limits,
                         const TerrainSamples& samples, int sector) {
  write_means(samples, sector, disparity_.row(sector));
  search.camera = &camera;
  search.limits = &limits;
  search.rows = samples.rows(sector);
  search.disparity = disparity_.row(sector);
  search.growth = camera.level_growth(camera.height_m);
}

Trench* TrenchFilter::beside(int sector, int side, int reach, int row) {
  for (int offset{1}; offset <= reach; ++offset) {
    const int there{sector + side * offset};
    if (there < 0 || there >= disparity_.height()) break;
    std::optional<Trench>& trench{at(there)};
    if (trench && (row == no_row || std::abs(trench->row - row) <= chain_rows)) return &*trench;
  }
  return nullptr;
}

std::optional<Trench> TrenchFilter::best(const Search& search, int lowest, int highest) const {
  std::optional<Trench> found;
  const auto take = [&found](const std::optional<Trench>& trench) {
    if (trench && (!found || trench->gain > found->gain)) found = trench;
  };
  const int end{std::min(lowest + 1, search.rows.end_row - margin_)};
  int first{std::max(highest, search.rows.first_row + 1)};
  while (first < end && search.rows.tangent(static_cast<float>(first)) < search.limits->drop_slope) ++first;
  std::array<int, 64> likely;  // shapes by bits; most of the work is saved by them
  const int rows{static_cast<int>(likely.size())};
  for (int edge_end{end}; edge_end > first; edge_end -= rows) {
    const int begin{std::max(first, edge_end - rows)};
    likely = {};
    for (std::size_t k{1}; k < shapes_.size(); ++k) {
      const int from{std::max(begin, search.rows.first_row + shapes_[k].edge_place)};
      if (from < edge_end) shapes_[k].mark_likely(search, from, edge_end, 1 << k, &likely[from - begin]);
    }
    for (int edge{edge_end - 1}; edge >= begin; --edge) {
      if (!(search.disparity[edge] > 0)) continue;
      if (edge - margin_ >= search.rows.first_row && is_lower(search, edge))
        take(lower_ground(search, shapes_[0], edge));
      for (auto left = static_cast<unsigned>(likely[edge - begin]); left != 0; left &= left - 1) {
        take(wall(search, shapes_[static_cast<std::size_t>(std::countr_zero(left))], edge));
      }
    }
  }
  return found;
}

std::optional<Trench> TrenchFilter::wall(const Search& search, const Shape& shape, int edge) const {
  const auto rows = static_cast<float>(shape.wall_rows);
  const TrenchFit fit{fit_of(search.disparity + edge, shape.fall, shape.edge_place)};
  if (!is_within(search, fit, search.wall_gain, fit.fall * rows) || fit.fall < search.fall_min * search.growth ||
      fit.fall > search.fall_max * search.growth)
    return {};
  const float edge_px{search.disparity[edge] + fit.at_edge};
  const float wall_x{search.camera->range(std::max(edge_px - fit.growth * rows, 1.0f))};
  return Trench{
      search.camera->range(edge_px), wall_x, rows * search.camera->tangent_per_v * wall_x, edge, fit.gain, fit.rest_px};
}

// Ground lower by more than a step is farther by d·D/(h + D) (4).
std::optional<Trench> TrenchFilter::lower_ground(const Search& search, const Shape& shape, int edge) const {
  if (search.rows.tangent(static_cast<float>(edge)) < lower_slope * search.limits->drop_slope) return {};
  const TrenchFit fit{fit_of(search.disparity + edge, shape.fall, shape.edge_place)};
  if (!is_within(search, fit, search.lower_gain, 0) || fit.fall < search.step_px(edge)) return {};
  const float edge_px{search.disparity[edge] + fit.at_edge};
  const float behind_px{std::max(edge_px - fit.fall, 1.0f)};
  return Trench{search.camera->range(edge_px),
                search.camera->range(behind_px),
                search.camera->height_m * fit.fall / behind_px,
                edge,
                fit.gain,
                fit.rest_px};
}

bool TrenchFilter::is_within(const Search& search, const TrenchFit& fit, float gain, float jump_px) {
  return fit.gain > gain && fit.growth > ground_growth_min * search.growth &&
         fit.rest_px < std::max(search.rest_px, search.rest_share * jump_px);
}

std::size_t TrenchFilter::memory_bytes() const {
  std::size_t bytes{memory_bytes_of(disparity_, found_)};
  for (const Shape& shape : shapes_) bytes += sizeof(Shape) + memory_bytes_of(shape.fall);
  return bytes;
}

}  // namespace stereogrid
