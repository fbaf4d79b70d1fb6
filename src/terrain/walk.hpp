// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "host_device.hpp"
#include "memory_bytes.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/image.hpp"
#include "terrain/gaps.hpp"
#include "terrain/model.hpp"
#include "terrain/rings.hpp"
#include "terrain/samples.hpp"
#include "terrain/trenches.hpp"

namespace stereogrid {

struct PolarCell {
  float elevation_m{std::numeric_limits<float>::quiet_NaN()};  ///< elevation of ground, or of an obstacle's top
  float slope{0};                                              ///< slope of the ground, tangent
  TerrainClass kind{TerrainClass::unknown};
  bool is_firm{false};  ///< no gap between the footprint and this ground

  [[nodiscard]] STEREOGRID_HD bool is_ground() const { return kind == TerrainClass::drivable; }
};

/// Ground that a sector's walk continues from.
struct WalkState {
  float x{0};  ///< place of the last ground, m
  float z{0};
  float slope{0};          ///< slope of the ground there, tangent
  float reached{0};        ///< ground is interpolated up to here, m
  int missing{0};          ///< rings without ground since
  bool is_alive{true};     ///< the ground is connected with the vehicle's footprint
  bool is_blocked{false};  ///< an obstacle ended the walk
  bool is_firm{true};      ///< no gap between the footprint and the ground
  float before_z{0};       ///< elevation of the ground before the bridge to this one; x = reached: there is one
  float foot_x{0};         ///< last ground from which it has not risen more steeply than the steepest slope, m
  float foot_z{0};

  [[nodiscard]] STEREOGRID_HD float elevation(float at_x) const { return z + slope * (at_x - x); }
};

struct SectorWalk {
  int lost{0};            ///< ring at which the walk first lost the ground
  WalkState state{};      ///< behind the last ring that was walked
  int blocked{no_ring};   ///< ring of the obstacle that the walk met last
  int foot{no_ring};      ///< first ring of that obstacle
  int end{no_ring};       ///< ring of an edge behind which the ground is hidden
  int end_seen{no_ring};  ///< last ring of the mark: `end`, or that of a trench's wall
  int landing{no_ring};   ///< ring of the first visible surface behind it
  GapKind end_kind{GapKind::unknown};
  float end_fall_m{0};       ///< visible fall of the surface behind the edge
  int end_confirmations{0};  ///< number of the six neighbours that must confirm the edge
  std::optional<Trench> trench{};
  int block_confirmations{0};      ///< number of neighbours that must confirm `blocked`
  bool is_block_confirmed{false};  ///< enough neighbours confirm `blocked`
  bool has_taken{false};           ///< see take_over()
};

/// Input of a frame's walks, for CPU and GPU. The arrays lie where the code runs.
struct WalkInput {
  TerrainCamera camera;
  TerrainLimits limits;
  RingTable rings;
  const SectorRows* rows;  ///< by sector
  int sectors;
  const float* sigma_px;  ///< by ring
  int checked_rings;      ///< rings whose noise is low enough for edges and obstacles
  float window_rows;      ///< rows over which the matcher smears a jump
  FirstGround prior{};
};

/// Ground and obstacle samples of a ring, relative to an expected elevation.
struct RingSamples {
  int ground{0};
  float ground_z{0};  ///< sum
  int above{0};
  float top{-1e3f};         ///< highest sample of an obstacle
  bool is_standing{false};  ///< the obstacle begins near the ground
};

/// One ring of a sector. `z` and `slope` describe the surface expected at the ring's middle.
struct RingView {
  static constexpr float ground_share{0.25f};  ///< share of the rows in which a surface is visible

  STEREOGRID_HD RingView(const WalkInput& input, const SectorRows& sector, int index)
      : in{&input},
        rows{sector},
        ring{index},
        begin_m{input.rings.begin_m(index)},
        end_m{input.rings.end_m(index)},
        x{input.rings.middle_m(index)},
        sigma_px{input.sigma_px[index]} {}

  [[nodiscard]] STEREOGRID_HD bool is_checked() const { return ring < in->checked_rings; }
  /// Noise of the height over the surface, m.
  [[nodiscard]] STEREOGRID_HD float sigma(float z, float slope) const {
    return in->camera.height_sigma(in->camera.height_m - z, slope, x, sigma_px);
  }
  [[nodiscard]] STEREOGRID_HD float predicted_rows(float z, float slope) const {
    const float half_m{0.5f * slope * (end_m - begin_m)};
    const float h{in->camera.height_m - z};
    return ((h + half_m) / begin_m - (h - half_m) / end_m) / in->camera.tangent_per_v;
  }
  [[nodiscard]] STEREOGRID_HD bool is_upright(int v) const {
    return rows.upright != nullptr ? rows.upright[v] : rows.is_upright(v, in->camera, in->limits.slope);
  }
  [[nodiscard]] STEREOGRID_HD RingSamples gather(float z, float slope, float tolerance) const {
    RingSamples found;
    const float step{in->limits.step_m};
    const float like_slope{2 * in->limits.slope * in->camera.range_sigma(x, sigma_px)};  // (6)
    const float lowest_above{std::max(std::max(step, 2.5f * sigma(z, slope)), like_slope)};
    for (int v{rows.first[ring]}; v != no_row; v = rows.next[v]) {
      const float on_surface{rows.z[v] - slope * (rows.x[v] - x)};
      const float over{on_surface - z};
      if (std::abs(over) < tolerance && !(over > 0.3f * step && is_upright(v))) {
        ++found.ground;
        found.ground_z += on_surface;
      }
      if (over <= lowest_above || over > in->limits.height_m) continue;
      ++found.above;
      found.is_standing = found.is_standing || over < lowest_above + step;
      found.top = std::max(found.top, rows.z[v]);
    }
    return found;
  }
  [[nodiscard]] STEREOGRID_HD bool has_ground(const RingSamples& samples, float z, float slope) const {
    return samples.ground > 0 && static_cast<float>(samples.ground) >= ground_share * predicted_rows(z, slope);
  }
  /// An obstacle has 30 % of the rows of a level top or of a face of two thirds of a step, whichever has fewer.
  [[nodiscard]] STEREOGRID_HD bool has_obstacle(const RingSamples& samples, float z) const {
    const float step{in->limits.step_m};
    const float face_rows{step * 2 / 3 / (x * in->camera.tangent_per_v)};
    const float top_rows{(in->camera.height_m - z - step) * (end_m - begin_m) / (x * x * in->camera.tangent_per_v)};
    const float fewest{std::max(2.0f, 0.3f * std::min(face_rows, std::max(top_rows, 0.0f)))};
    return static_cast<float>(samples.above) >= fewest;
  }
  /// First row, upwards, with a sample behind the ring; no_row: fewer than half of the ground's rows have one.
  /// `z_near`, `z_far`: elevation of the ground at both ends.
  [[nodiscard]] STEREOGRID_HD int row_through(float z_near, float z_far) const {
    const float height{in->camera.height_m};
    const auto row_at = [&](float z, float at_x) {
      return ((height - z) / at_x - rows.tangent_at_row_0) / rows.tangent_per_v;
    };
    const int lowest{std::min(static_cast<int>(std::floor(row_at(z_near, begin_m))), rows.end_row - 1)};
    const int highest{std::max(static_cast<int>(std::ceil(row_at(z_far, end_m))), rows.first_row)};
    const float behind_m{end_m + 2.5f * in->camera.range_sigma(x, sigma_px)};
    int valid{0};
    int through{0};
    int first{no_row};
    for (int v{lowest}; v >= highest; --v) {
      if (!(rows.disparity[v] > 0)) continue;
      ++valid;
      if (rows.x[v] < behind_m) continue;
      ++through;
      if (first == no_row) first = v;
    }
    return 2 * through >= valid ? first : no_row;
  }

  const WalkInput* in;
  SectorRows rows;
  int ring;
  float begin_m;
  float end_m;
  float x;  ///< middle of the ring
  float sigma_px;
};

/// Number of rings, the first ones, whose noise is low enough for edges and obstacles.
STEREOGRID_HD inline int checked_rings_of(const SampledGround& ground, const RingTable& rings, const float* sigma_px) {
  constexpr float checked_sigmas{3};  // standard deviations of the elevation that must not exceed a step
  const TerrainCamera& camera{ground.camera};
  int ring{0};
  while (ring < rings.count() &&
         checked_sigmas * camera.elevation_sigma(camera.height_m, rings.middle_m(ring), sigma_px[ring]) <=
             ground.limits.step_m)
    ++ring;
  return ring;
}

/// A frame's ground before it is walked.
struct WalkFrame {
  SampledGround ground;
  RingTable rings;
  FirstGround prior;
};

/// A frame's ground by ring and sector.
template <class Space>
struct WalkedGround {
  View<const PolarCell, Space> cells;   ///< (ring, sector)
  View<const SectorWalk, Space> walks;  ///< (sector, 0)
  const float* sigma_px{nullptr};       ///< noise of disparities by ring, in the same memory
};

/// Walks from the vehicle outwards over the ground of a frame, on the CPU.
class SectorWalks {
 public:
  /// `rings`: Rings::capacity. `window_rows`: rows over which the matcher smears a jump.
  SectorWalks(const Rig& level_rig, int rings, int window_rows);

  /// Begins a frame: medians, places and noise of the samples. Returns the noise by ring, valid until the next frame.
  /// `obstacle`, `road`: (H, W) px, 0 = none. `for_ranges`(count, work): calls work(begin, end) on disjoint parts of
  /// [0, count).
  template <class ForRanges>
  const float* begin(const WalkFrame& frame, View<const float> obstacle, View<const float> road,
                     const ForRanges& for_ranges) {
    frame_ = frame;
    for_ranges(walks_.width(), [&](int first, int end) {
      find_medians(obstacle, road, first, end, frame.ground.first_row, medians_.view());
    });
    const SampleTable table{samples()};
    for_sectors(for_ranges, [&](int sector) { place(table, sector); });
    measure_noise(table);
    return sigma_px_.data();
  }
  /// Ground of the frame, valid until the next begin().
  template <class ForRanges>
  WalkedGround<Host> find(const ForRanges& for_ranges) {
    trenches_.begin(frame_.ground, medians_.view());
    trenches_.find_all(for_ranges);
    trenches_.connect();
    const WalkInput input{this->input()};
    for_sectors(for_ranges, [&](int sector) { walk(input, sector); });
    spread_ground(input);
    return {std::as_const(cells_).view(), std::as_const(walks_).view(), sigma_px_.data()};
  }
  [[nodiscard]] std::size_t memory_bytes() const {
    return memory_bytes_of(medians_, x_, z_, next_, first_, spread_, rows_, sigma_px_, trenches_, cells_, walks_,
                           reached_);
  }

 private:
  template <class ForRanges, class Work>
  void for_sectors(const ForRanges& for_ranges, const Work& work) const {
    for_ranges(walks_.width(), [&](int first, int end) {
      for (int sector{first}; sector < end; ++sector) work(sector);
    });
  }
  [[nodiscard]] SampleTable samples();
  [[nodiscard]] WalkInput input() const;
  void place(const SampleTable& table, int sector);
  void measure_noise(const SampleTable& table);
  void walk(const WalkInput& input, int sector);
  void spread_ground(const WalkInput& input);

  WalkFrame frame_;
  float window_rows_;
  Image<float> medians_;  // (row, sector)
  Image<float> x_;        // see SampleTable
  Image<float> z_;
  Image<std::int16_t> next_;
  Image<std::int16_t> first_;
  Image<RingSpread> spread_;
  std::vector<SectorRows> rows_;
  std::vector<float> sigma_px_;
  TrenchFilter trenches_;
  Image<PolarCell> cells_;
  Image<SectorWalk> walks_;
  Image<std::uint8_t> reached_;  // (sector, 0): a way leads there
};

/// Hides ground that no way as wide as the vehicle's height reaches from the footprint. `reached`: working memory,
/// (sector, 0).
void hide_unconnected(const WalkInput& input, View<PolarCell> cells, View<std::uint8_t> reached);

}  // namespace stereogrid
