// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>

#include "filter/filter.hpp"
#include "filter/held_cell.hpp"
#include "filter/joint/evidence.hpp"
#include "images/row_alignment/row_alignment.hpp"
#include "matching/checks/mask.hpp"
#include "matching/matches.hpp"
#include "pipeline/saved_state.hpp"
#include "stereogrid/pipeline.hpp"
#include "terrain/rules.hpp"

namespace stereogrid {

class Cpu;

/// Input of the frame pipeline: level images of the rig's size.
struct LevelFrame {
  View<const std::uint8_t> left;
  View<const std::uint8_t> right;
  View<const float> disparity;  ///< external disparities; empty: match both images
  Pose2 world_from_vehicle;
  double dt_s{0};
  std::span<const ObservedGrid> other_grids;
  CameraView view{};
  bool restarts{false};         ///< clock leap: no state is used
  double disparity_step_px{0};  ///< external disparities: step_of

  [[nodiscard]] bool is_given() const { return !disparity.empty(); }
};

/// Constant settings of a back end.
struct StagesOptions {
  bool stage_images{true};             ///< fill FrameResult::stages
  bool predictions{false};             ///< predict() will be called
  const FrameResult* reused{nullptr};  ///< result that only the pipeline writes: constant parts are not written again
};

/// The stages of a frame on one back end, and the buffers between them. FramePipeline calls them in order. A device
/// enqueues the work of a stage and returns; the functions that return results wait for it.
class Stages {
 public:
  Stages() = default;
  Stages(const Stages&) = delete;
  Stages& operator=(const Stages&) = delete;
  virtual ~Stages() = default;

  /// Pixels without disparities in all frames. Before the first frame; `mask` must outlive the stages.
  virtual void set_mask(const PixelMask& mask) = 0;

  /// Starts a frame. `window`: the filter's grid. The first frame resets the filter. The images of `frame` and `result`
  /// must stay valid until finish().
  virtual void begin(const LevelFrame& frame, const GridGeometry& window, bool is_first, FrameResult& result) = 0;
  /// Disparities of obstacles and road (III-C). `expected`: plane of the road hypothesis; `previous`: plane of the
  /// frame before, for estimate_ground().
  virtual void match(const Ground& expected, const Ground& previous, const RowAlignment& rows) = 0;
  /// Road plane of the matches.
  virtual void estimate_ground() = 0;
  /// Replaces the estimated plane for the rest of the frame.
  virtual void set_ground(const Ground& ground) = 0;
  /// Terrain rules of the frame's stereo grids; valid until finish(). Without a call: none. External disparities are
  /// split again, by their surfaces on the relief.
  virtual void set_rules(const TerrainRules& rules) = 0;
  /// Blur of the obstacles (blur_of) in observe().
  virtual void set_blur(float blur_px) = 0;
  /// Occupancy of the vehicle's grid and of the window, fused with the frame's other grids. `is_usable` false: unknown.
  /// `held`: cells of the window that stay occupied, each once, at most held_cells_max; valid until finish().
  virtual void observe(bool is_usable, std::span<const HeldCell> held) = 0;
  /// One step of the filter, from the state before the frame, and its layers in the vehicle's grid. `velocities`: one
  /// per cell, by ascending cell; valid until finish().
  virtual void filter(std::span<const VelocityEvidence> velocities) = 0;
  /// Fills the result's grids, densities, times of the stages and, with StagesOptions::stage_images, stages.
  virtual void finish() = 0;
  /// Fills result.predictions, after finish().
  virtual void predict(const Pose2& /*world_from_vehicle*/, FrameResult& /*result*/) {}

  /// True: the calls above enqueue and return.
  [[nodiscard]] virtual bool is_asynchronous() const { return false; }
  /// Plane from estimate_ground().
  virtual Ground ground() = 0;
  /// True: the matches put the road outside the gate around `previous`.
  virtual bool is_lost() = 0;
  /// Valid at the pixels of MatchLattice only.
  virtual const Matches& matches_on_lattice() = 0;
  /// (H, W) px, 0 = none.
  virtual View<const float> obstacle_disparity() = 0;
  virtual View<const float> road_disparity() = 0;

  [[nodiscard]] virtual MemoryUse memory_use() const = 0;
  /// State of the filter.
  virtual void save(StateWriter& state) = 0;
  virtual void load(StateReader& state) = 0;
};

std::unique_ptr<Stages> cpu_stages(const Config& config, const Rig& level_rig, Cpu& cpu, const StagesOptions& options);
std::unique_ptr<Stages> reference_stages(const Config& config, const Rig& level_rig, Cpu& cpu,
                                         const StagesOptions& options);

}  // namespace stereogrid
