// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>
#include <variant>

#include "filter/filter.hpp"
#include "filter/joint/evidence.hpp"
#include "fusion/model.hpp"
#include "geometry/grid_in_vehicle.hpp"
#include "geometry/matches.hpp"
#include "ground/plane_numbers.hpp"
#include "images/row_alignment/row_alignment.hpp"
#include "matching/checks/mask.hpp"
#include "memory_bytes.hpp"
#include "pipeline/saved_state.hpp"
#include "stereogrid/pipeline.hpp"
#include "terrain/rules.hpp"

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

  [[nodiscard]] bool has_external_disparity() const { return !disparity.empty(); }
};

/// Grids of a frame, and where they lie for its camera.
struct FrameGrids {
  GridGeometry window;          ///< the filter's grid, world axes
  GridInVehicle vehicle_cells;  ///< the vehicle's grid in the vehicle frame
  GridInVehicle window_cells;   ///< the window in the vehicle frame
  bool is_first;                ///< the filter begins with this frame
};

/// Ground that a frame is matched on.
struct MatchGround {
  Ground plane;                          ///< plane of the road hypothesis
  const Relief<Host>* surface{nullptr};  ///< local ground over the plane, by which external disparities are split
};

/// The last matches, as the host reads them. Valid until the frame is matched again.
struct HostMatches {
  const Matches& lattice;      ///< valid at the pixels of MatchLattice only
  View<const float> obstacle;  ///< (H, W) px, 0 = none
  View<const float> road;
};

/// Input of a frame's grids beside its matches.
struct Evidence {
  bool is_usable{true};  ///< false: both grids are unknown, but for the frame's other grids and `held`
  Ground ground{};       ///< plane under the observed grids
  TerrainRules rules{};  ///< empty: none
  float blur_px{0};      ///< see blur_of
  std::span<const RetainedCell>
      held{};  ///< cells of the window that stay occupied, each once, at most retained_cells_max
};

/// Constant settings of a back end.
struct StagesOptions {
  bool stage_images{true};             ///< fill FrameResult::stages
  bool predictions{false};             ///< fill FrameResult::predictions
  const FrameResult* reused{nullptr};  ///< result that only the pipeline writes: constant parts are not written again
  PixelMask mask{};                    ///< pixels without disparities in all frames
};

using StateArchive = std::variant<StateWriter*, StateReader*>;

/// The stages of a frame on one back end, and the buffers between them. FramePipeline calls them in order. A device
/// enqueues the work of a stage and returns; read() and publish() wait for it. What a call is given stays valid until
/// publish().
class Stages {
 public:
  /// `is_asynchronous`: calls enqueue and return.
  Stages(PixelMask mask, bool is_asynchronous) : mask_{std::move(mask)}, is_asynchronous_{is_asynchronous} {}
  Stages(const Stages&) = delete;
  Stages& operator=(const Stages&) = delete;
  virtual ~Stages() = default;

  /// Disparities of obstacles and road (III-C), or external ones split into both. Once or more in a frame.
  virtual void match(const LevelFrame& frame, const FrameGrids& grids, const RowAlignment& rows,
                     const MatchGround& ground) = 0;
  /// Waits for match(). Any thread may call this.
  virtual const HostMatches& read() = 0;
  /// Occupancy of the vehicle's grid and of the window (IV, V-A), fused with the frame's other grids.
  virtual void observe(const LevelFrame& frame, const FrameGrids& grids, const Evidence& evidence,
                       FrameResult& result) = 0;
  /// One step of the filter (V-B), from the state before the frame, and its layers in the vehicle's grid. `velocities`:
  /// at most one per cell, by ascending cell.
  virtual void filter(const LevelFrame& frame, const FrameGrids& grids, std::span<const VelocityEvidence> velocities,
                      FrameResult& result) = 0;
  /// Ends the frame: completes the result's grids, predictions, densities, times of the stages and, with
  /// StagesOptions::stage_images, stages.
  virtual void publish(const LevelFrame& frame, FrameResult& result) = 0;
  /// State of the filter between two frames.
  virtual void exchange(StateArchive archive) = 0;

  /// Replaces the pixels without disparities, before match(). Nothing of a frame may be in work.
  virtual void set_mask(PixelMask mask) { mask_ = std::move(mask); }

  /// Runs host work while the stages work: on the CPU on other threads, on a device after the calls have been enqueued.
  /// Returns the result of the host work.
  template <class Threads, class StageCalls, class HostWork>
  auto both(Threads& cpu, const StageCalls& stage_calls, const HostWork& host_work) const {
    if (is_asynchronous_) {
      stage_calls();
      return host_work();
    }
    std::invoke_result_t<HostWork> made{};
    cpu.together(stage_calls, [&] { made = host_work(); });
    return made;
  }
  [[nodiscard]] const PixelMask& mask() const { return mask_; }
  [[nodiscard]] MemoryUse memory_use() const { return memory_; }

 protected:
  /// At the end of a constructor: all is allocated there. Without the mask.
  void set_memory_use(const MemoryUse& memory) {
    memory_ = {memory.host_bytes + memory_bytes_of(mask_), memory.device_bytes};
  }

 private:
  PixelMask mask_;
  bool is_asynchronous_;
  MemoryUse memory_;
};

std::unique_ptr<Stages> cpu_stages(const Config& config, const Rig& level_rig, Cpu& cpu, const StagesOptions& options);
std::unique_ptr<Stages> reference_stages(const Config& config, const Rig& level_rig, Cpu& cpu,
                                         const StagesOptions& options);

}  // namespace stereogrid
