// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "filter/joint/active_blocks.hpp"
#include "filter/joint/evidence.hpp"
#include "filter/joint/moving_blocks.hpp"
#include "filter/model.hpp"
#include "geometry/window.hpp"
#include "memory_bytes.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/result.hpp"

namespace stereogrid {

class Cpu;
struct Reference;

/// Velocities of the filter's lattice along an axis, m/s, ascending; the middle one is 0.
std::vector<double> velocity_axis(const FilterConfig& config);

/// Velocities of the filter's lattice, world axes, y-major; the middle one is standstill.
std::vector<Point2> velocity_lattice(const FilterConfig& config);

/// Constants of a configuration for all steps. Built once.
struct FilterTables {
  explicit FilterTables(const FilterConfig& config);

  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_of(lattice, axis_mps, likelihood); }

  std::vector<Point2> lattice;
  std::vector<float> axis_mps;    ///< its velocities along either axis
  std::vector<float> likelihood;  ///< see `tempered`
  float each_moving;              ///< see FilterStep
  MovingFrom moving_from;         ///< likewise
};

/// Working memory of a step on the CPU: what prediction reads of the step before.
struct FilterWorkspace {
  FilterWorkspace(int cells, std::size_t velocities, FilterModel model);

  [[nodiscard]] std::size_t memory_bytes() const {
    return memory_bytes_of(from, gained, standing, still_occupied, even, spread, moving, active);
  }

  std::vector<Antecedents> from;  ///< by velocity
  Image<float> gained;            ///< by cell: gain of each moving velocity by noise
  Image<float> standing;          ///< standing mass after the noise
  Image<float> still_occupied;    ///< tay2008
  // joint
  Image<float> even;            ///< mass of each moving velocity after the noise, where they are alike
  Image<float> spread;          ///< `even`, shifted along x by each of the lattice's velocities: the sum
  std::vector<CellBox> moving;  ///< by block of the last state: its moving cells
  ActiveBlocks active;
};

/// Blocks of a window that can have masses at a time; without a prior for standstill all.
int block_capacity(int cells, const FilterConfig& config);

/// Information about all cells of a block after a step of FilterModel::joint.
enum class BlockKind : std::uint8_t {
  any,
  even,    ///< no velocity information: the mean velocity is 0, its variance the same in all directions
  unseen,  ///< the same, and unseen_cell: the step has not had to work on it
};

/// State of the filter for each cell.
struct FilterState {
  FilterState(int cells, const FilterConfig& config);

  template <class State>
  void exchange(State& state) {
    state(geometry, velocity, standing, blocks, occupancy, age_s);
    if constexpr (requires { state.require(true); }) invalidate_kinds();
  }

  /// joint: see cell_formulas.hpp.
  [[nodiscard]] bool is_as_unseen(const FilterStep& step, int x, int y) const {
    return stereogrid::is_as_unseen(step, occupancy(x, y), standing(x, y), age_s(x, y));
  }
  /// joint: the cells of a block that move, if it is followed. `step`, `scroll`: those of the next step.
  [[nodiscard]] CellBox moving_cells(const FilterStep& step, Scroll scroll, int block) const {
    const CellBox cells{blocks.layout().cells_of(block)};
    if (!is_followed(step, cells, scroll.x, scroll.y)) return {0, 0, -1, -1};
    return stereogrid::moving_cells(cells, [&](int x, int y) {
      return is_moving(step.moving_from, occupancy(x, y), standing(x, y)) && !is_as_unseen(step, x, y);
    });
  }

  void invalidate_kinds() { std::fill(kinds.begin(), kinds.end(), BlockKind::any); }
  /// The cell has been changed, other than by a step.
  void invalidate_kind(int x, int y) {
    kinds[static_cast<std::size_t>(blocks.layout().block_of(x, y))] = BlockKind::any;
  }
  [[nodiscard]] bool is_unseen(int block) const { return kinds[static_cast<std::size_t>(block)] == BlockKind::unseen; }

  [[nodiscard]] std::size_t memory_bytes() const {
    return memory_bytes_of(velocity, standing, blocks, space, occupancy, age_s, kinds);
  }

  GridGeometry geometry;               ///< geometry of the last step; nx = 0: no step yet
  std::vector<Image<float>> velocity;  ///< tay2008: [k], P(v_k)
  Image<float> standing;               ///< joint: P(occupied, standstill)
  MovingBlocks blocks;                 ///< joint: P(occupied, v_k), where not all moving velocities are alike
  FilterWorkspace space;               ///< for the step that writes into this state
  Image<float> occupancy;              ///< P(occupied)
  Image<float> age_s;
  std::vector<BlockKind> kinds;  ///< joint: of each block
};

/// P(occupied, v_k) (joint) or P(v_k) (tay2008).
float mass_of(const FilterState& state, std::size_t k, int x, int y);

/// From where the observed grid has been seen.
struct CameraView {
  Pose2 camera{};   ///< in the frame of the window
  double left{-1};  ///< field of view to the left, per metre ahead; negative: unknown
  double right{-1};
  /// Displacement of a point in the image by the vehicle's motion since the last step, times the square of its
  /// distance. Infinite: unknown.
  double parallax_px_m2{std::numeric_limits<double>::infinity()};
  /// Disparity of a point times its distance. Infinite: unknown.
  double focal_baseline_pxm{std::numeric_limits<double>::infinity()};
  double nearest_m{0};   ///< distance ahead from which on the image shows obstacles of the least height
  double baseline_m{0};  ///< to the right camera

  /// Change of a point's disparity after which the matching errors are independent.
  static constexpr double new_view_px{0.5};
  /// Similarity of the view of a point to that of the step before, from 0 to 1. docs/method.md §8.3.
  [[nodiscard]] double repeated(Point2 at) const {
    const double dx{at.x - camera.x_m};
    const double dy{at.y - camera.y_m};
    return std::max(0.0, 1 - parallax_px_m2 / new_view_px / (dx * dx + dy * dy));
  }
};

/// Input of one step beside the observation.
struct FilterInput {
  const FilterConfig& config;
  const FilterTables& tables;
  GridGeometry geometry;  ///< present window
  double dt_s;            ///< since the last step
  CameraView view{};
  /// joint, CPU: of the blocks as the layers have them before the step; null: unknown.
  const std::vector<BlockKind>* kinds_before{nullptr};
  std::span<const CameraView> other_views{};  ///< views of the frame's other cameras, fewer than cameras_max
};

/// Evidence begin … end − 1, weighed together.
struct EvidenceRange {
  int begin;
  int end;
};

/// Working memory of `weigh_velocities` on the CPU.
struct WeighingWorkspace {
  WeighingWorkspace(int cells, const FilterTables& tables, int threads);

  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_of(ranges, masses, starts); }

  std::vector<EvidenceRange> ranges;
  std::vector<std::vector<float>> masses;  ///< by part of the work: [velocity][cell of a range], and two for each v_x
  std::vector<std::uint8_t> starts;        ///< by evidence: starts a moving cell whose block has no masses yet
};

/// One step of the Bayesian Occupancy Filter: `before` moved on by dt and into the window's new place, then updated
/// with the observed grid (P(T_X) at the window's cells, 0.5 = nothing seen), into `after`. All `layers` are filled.
/// docs/method.md §8.6 (tay2008) and §8.7 (joint).
void filter(Cpu& cpu, const FilterInput& input, View<const float> observed, const FilterState& before,
            FilterState& after, GridLayers& layers);
void filter(Reference& reference, const FilterInput& input, View<const float> observed, const FilterState& before,
            FilterState& after, GridLayers& layers);

/// Updates a state of FilterModel::joint with measured velocities, and its layers of motion. `evidence`: by ascending
/// cell, one for a cell.
void weigh_velocities(Cpu& cpu, std::span<const VelocityEvidence> evidence, const FilterTables& tables,
                      WeighingWorkspace& space, FilterState& state, GridLayers& layers);
void weigh_velocities(Reference& reference, std::span<const VelocityEvidence> evidence, const FilterTables& tables,
                      WeighingWorkspace& space, FilterState& state, GridLayers& layers);
/// By the reference it needs none.
void weigh_velocities(Reference& reference, std::span<const VelocityEvidence> evidence, const FilterTables& tables,
                      FilterState& state, GridLayers& layers);

/// All cells unknown, at the window's place.
void reset(FilterState& state, const FilterConfig& config, const GridGeometry& geometry);

FilterStep step_of(const FilterInput& input);

/// Distributes standing mass over the moving velocities, if the evidence starts motion (`standing_before`).
void start_motion(const FilterTables& tables, const VelocityEvidence& one, FilterState& state);

/// Updates single cells of a joint state with measured velocities. In a block without masses the dynamic mass stays
/// spread evenly, unless a cell is found to move.
class CellWeigher {
 public:
  CellWeigher(const FilterTables& tables, FilterState& state, GridLayers& layers)
      : tables_{tables}, state_{state}, layers_{layers} {}

  /// False: the evidence starts a moving cell whose block has no masses. The block is marked.
  bool weigh(const VelocityEvidence& one, bool may_start);

 private:
  const FilterTables& tables_;
  FilterState& state_;
  GridLayers& layers_;
};

/// Assigns masses to the marked blocks while there is room: their cells' mass, spread evenly.
void allocate_marked_blocks(const FilterTables& tables, FilterState& state);

inline void write_velocity(const VelocityEstimate& velocity, int x, int y, GridLayers& layers) {
  layers.velocity_x(x, y) = velocity.x;
  layers.velocity_y(x, y) = velocity.y;
  layers.velocity_xx(x, y) = velocity.xx;
  layers.velocity_xy(x, y) = velocity.xy;
  layers.velocity_yy(x, y) = velocity.yy;
}

/// Layers of that size, all 0.
GridLayers grid_layers(const GridGeometry& geometry);

/// Number of cells of a row of the vehicle's grid that are resampled together.
constexpr int resampled_columns{16};

/// Classes of the layers' cells: isotropic cells stay so under rotation, and equal cells stay as they are.
struct KnownKinds {
  const std::vector<BlockKind>* blocks{nullptr};  ///< FilterState::kinds of the window; null: unknown
  /// By part of each row of the vehicle's layers, resampled_columns each; updated. Null: unknown.
  std::vector<BlockKind>* parts{nullptr};
};

/// Parts of a row of the vehicle's grid.
constexpr int resampled_parts(int columns) {
  return (columns + resampled_columns - 1) / resampled_columns;
}

/// The window's layers (`result.world`) as the car sees them, in the cells of `result.vehicle.geometry`:
/// occupancy and moving interpolated between cells; of the nearest cell velocity and covariance (turned into vehicle
/// axes) and age. Outside the window 0.5, inf and else 0.
void resample(const Pose2& world_from_vehicle, FrameResult& result);
/// The same on the CPU of the rows begin … end − 1. `kinds`: as far as they are known.
void resample_rows(const Pose2& world_from_vehicle, int begin, int end, KnownKinds kinds, FrameResult& result);

/// Completes the vehicle's cells of known occupancy whose nearest cell of the window has never been observed, in the
/// joint form. The age is the least of the four cells around. If none of them has been observed, the occupancy is at
/// most the moving mass, or ½. docs/method.md §8.8.
void complete_unobserved(const Pose2& world_from_vehicle, FrameResult& result);

/// `resample` of the occupancy alone.
void resample_occupancy(const GridLayers& world, const Pose2& world_from_vehicle, const GridGeometry& vehicle_grid,
                        Image<float>& occupancy);

/// Corrects the filtered occupancy in rows begin … end − 1 of `result.vehicle` by what the frame, `result.observed`,
/// shows around each cell. `is_widened`: matching windows have widened its obstacles. docs/method.md §8.8.
void correct_by_frame(const Pose2& world_from_vehicle, bool is_widened, int begin, int end, FrameResult& result);

}  // namespace stereogrid
