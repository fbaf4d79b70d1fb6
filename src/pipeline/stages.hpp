// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <variant>

#include "filter/filter.hpp"
#include "filter/joint/evidence.hpp"
#include "fusion/model.hpp"
#include "geometry/grid_in_vehicle.hpp"
#include "geometry/matches.hpp"
#include "images/row_alignment/row_alignment.hpp"
#include "matching/checks/mask.hpp"
#include "memory_bytes.hpp"
#include "obstacles/segmentation/columns.hpp"
#include "pipeline/saved_state.hpp"
#include "stereogrid/pipeline.hpp"
#include "terrain/frame_terrain.hpp"
#include "terrain/low_obstacles_model.hpp"
#include "terrain/rules.hpp"
#include "terrain/walk.hpp"

namespace stereogrid {

/// Milliseconds since the last call.
class Stopwatch {
 public:
  double lap() {
    const auto now{std::chrono::steady_clock::now()};
    return std::chrono::duration<double, std::milli>(now - std::exchange(last_, now)).count();
  }

 private:
  std::chrono::steady_clock::time_point last_{std::chrono::steady_clock::now()};
};

/// Adds the milliseconds of its lifetime to a sum.
class ScopedTimer {
 public:
  explicit ScopedTimer(double& sum_ms) : sum_ms_{sum_ms} {}
  ScopedTimer(const ScopedTimer&) = delete;
  ScopedTimer& operator=(const ScopedTimer&) = delete;
  ~ScopedTimer() { sum_ms_ += watch_.lap(); }

 private:
  double& sum_ms_;
  Stopwatch watch_;
};

class Cpu;

/// A camera's part of a frame: level images of its rig's size.
struct LevelFrame {
  View<const std::uint8_t> left;
  View<const std::uint8_t> right;
  View<const float> disparity;  ///< external disparities; empty: match both images
  Pose2 world_from_camera;      ///< frame on the ground below the camera, x along its optical axis
  double dt_s{0};               ///< since the camera's frame before; 0: none
  int camera{0};
  bool restarts{false};         ///< no state of the camera is used
  double disparity_step_px{0};  ///< external disparities: step_of

  [[nodiscard]] bool has_external_disparity() const { return !disparity.empty(); }
};

/// Input of the frame pipeline: frames of one or more cameras, and the vehicle at the time of the newest.
struct FrameSet {
  std::span<const LevelFrame> cameras;  ///< at most one of each camera, ascending
  Pose2 world_from_vehicle;
  double dt_s{0};  ///< since the frame before
  std::span<const ObservedGrid> other_grids{};
  std::span<const CameraView> views{};  ///< views of `cameras`; empty: unknown
  bool restarts{false};                 ///< clock leap: no state is used
};

/// Grids of a frame, and where they lie for a camera.
struct FrameGrids {
  const FrameSet& frame;
  GridGeometry window;         ///< the filter's grid, world axes
  GridInVehicle vehicle;       ///< the vehicle's grid in the vehicle frame
  GridInVehicle window_cells;  ///< the window in the vehicle frame
  GridInVehicle seen_vehicle;  ///< the vehicle's grid in the frame of the camera
  GridInVehicle seen_window;   ///< the window in the frame of the camera
  bool is_first;               ///< the filter begins with this frame
};

/// Ground that a frame is matched on.
struct MatchGround {
  Ground plane;                          ///< plane of the road hypothesis
  const Relief<Host>* surface{nullptr};  ///< local ground over the plane, by which external disparities are split
};

/// Input of a frame's grids beside its matches.
struct Evidence {
  bool is_usable{true};  ///< false: both grids are unknown
  Ground ground{};       ///< plane under the observed grids
  TerrainRules rules{};  ///< empty: none
  float blur_px{0};      ///< see blur_of
};

/// Input of a step of the filter beside the observed window.
struct FilterEvidence {
  std::span<const VelocityEvidence> velocities{};  ///< at most one per cell, by ascending cell
  /// Cells of the window that stay occupied, at most retained_cells_max; each once with one camera.
  std::span<const RetainedCell> held{};
};

/// Last step of a frame's grids, after the filter.
struct FinalStep {
  bool is_corrected;          ///< correct_by_frame
  bool is_widened;            ///< likewise
  bool is_completed;          ///< complete_unobserved
  GridBounds<Host> bounds{};  ///< for bound_cell(), whose witnesses are in the result
};

class Stages;

/// A camera's observed grids after observe(): in its stages, and in its result where those work in the host's memory.
struct CameraGrids {
  Stages* stages;
  const FrameResult* result;
};

/// Calls work(begin, end) on disjoint parts of [0, count).
using ForRanges = std::function<void(int count, const std::function<void(int begin, int end)>& work)>;

/// Constant settings of a back end.
struct StagesOptions {
  bool stage_images{true};             ///< fill FrameResult::stages
  bool predictions{false};             ///< fill FrameResult::predictions
  const FrameResult* reused{nullptr};  ///< result that only the pipeline writes: constant parts are not written again
  PixelMask mask{};                    ///< pixels without disparities in all frames
  bool filters{true};                  ///< false: the stages of a further camera, which has no filter
  /// Threads of copies to and from pinned memory; by default the caller's.
  ForRanges copy{[](int count, const auto& work) { work(0, count); }};
};

using StateArchive = std::variant<StateWriter*, StateReader*>;

/// The stages of a frame on one back end, and the buffers between them. FramePipeline calls them in order. A device
/// enqueues the work of a stage and returns; read(), filtered() and publish() wait for it. What a call is given stays
/// valid until publish().
class Stages {
 public:
  explicit Stages(PixelMask mask) : mask_{std::move(mask)} {}
  Stages(const Stages&) = delete;
  Stages& operator=(const Stages&) = delete;
  virtual ~Stages() = default;

  /// Disparities of obstacles and road (III-C), or external ones split into both. Once or more in a frame.
  virtual void match(const LevelFrame& frame, const FrameGrids& grids, const RowAlignment& rows,
                     const MatchGround& ground) = 0;
  /// Waits for match(): disparities, valid at the pixels of MatchLattice only, until the frame is matched again. Any
  /// thread may call this.
  virtual const Matches& read() = 0;
  /// Begins the walk over the ground in the last matches, for GroundModel::terrain, and before a second match on a
  /// surface: a device works on it while the host continues. Returns the noise of its samples by ring, px.
  virtual const float* begin_walk(const WalkFrame& frame) = 0;
  /// Begins the search for low obstacles in the last matches, under the same conditions: a device works on it while the
  /// host continues. `noise_px`: see Terrain::noise_px().
  virtual void begin_low_obstacles(const LowModel& model, std::span<const float> noise_px) = 0;
  /// Walk, relief, cells and rules of the ground, after FrameTerrain::set_noise(), and low obstacles. A device works on
  /// it, and keeps what observe() needs, while the host continues.
  virtual void find_ground(FrameTerrain& terrain, FrameResult& result) = 0;
  /// Waits for it: they are set, in the terrain and in the result. May run beside find_nodes().
  virtual void finish_ground(FrameTerrain& terrain, FrameResult& result) = 0;
  /// Occupancy of the vehicle's grid and of the window (IV, V-A) by this camera.
  virtual void observe(const FrameGrids& grids, const Evidence& evidence, FrameResult& result) = 0;
  /// Nodes of the obstacles in the last matches. A device has counted them on the ground of the last observe(), and
  /// sets `relief` to that. Valid until the next observe(). Another thread than that of observe() may call this.
  virtual std::span<const ColumnNode> find_nodes(const Ground& ground, Relief<Host>& relief) = 0;
  /// Fuses the observed grids of several cameras, all of this back end, by CameraPool: input of filter(). These are the
  /// stages with the filter, and may be of a camera without a frame.
  virtual void fuse_cameras(std::span<const CameraGrids> cameras, FrameResult& result) = 0;
  /// Fuses the observed grids with the frame's other grids. Then one step of the filter (V-B), from the state before
  /// the frame, and its layers in the vehicle's grid.
  virtual void filter(const FrameGrids& grids, const FilterEvidence& evidence, FrameResult& result) = 0;
  /// Waits for filter(): occupancy of the window, valid until finish().
  virtual View<const float> filtered(const FrameResult& result) = 0;
  /// Makes the grids final.
  virtual void finish(const FrameGrids& grids, const FinalStep& step, FrameResult& result) = 0;
  /// Ends the frame: completes the result's grids, predictions and times of the stages.
  virtual void publish(const FrameGrids& grids, FrameResult& result) = 0;
  /// After publish(): densities of the camera's matches, with StagesOptions::stage_images stages, and of several
  /// cameras its own observed grid.
  virtual void publish_matches(FrameResult& result) = 0;
  /// Between frames: copies images from the device's memory to `into`. Throws ConfigError: there is no device.
  virtual void fetch(const DeviceImages& images, StereoFrame& into) = 0;
  /// Between frames: grids of the last one in the device's memory. Throws ConfigError: there is no device.
  virtual DeviceGrids device_grids() = 0;
  /// State of the filter between two frames.
  virtual void exchange(StateArchive archive) = 0;

  /// Replaces the pixels without disparities, before match(). Nothing of a frame may be in work.
  virtual void set_mask(PixelMask mask) { mask_ = std::move(mask); }

  [[nodiscard]] const PixelMask& mask() const { return mask_; }
  [[nodiscard]] MemoryUse memory_use() const { return memory_; }

 protected:
  /// At the end of a constructor: all is allocated there. Without the mask.
  void set_memory_use(const MemoryUse& memory) {
    memory_ = {memory.host_bytes + memory_bytes_of(mask_), memory.device_bytes};
  }

 private:
  PixelMask mask_;
  MemoryUse memory_;
};

std::unique_ptr<Stages> cpu_stages(const Config& config, const Rig& level_rig, Cpu& cpu, const StagesOptions& options);
std::unique_ptr<Stages> reference_stages(const Config& config, const Rig& level_rig, Cpu& cpu,
                                         const StagesOptions& options);

}  // namespace stereogrid
