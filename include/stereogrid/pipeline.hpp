// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "stereogrid/camera.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/export.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/image.hpp"
#include "stereogrid/result.hpp"

namespace stereogrid {

/// Back end of the computation. `automatic`: a GPU if a usable one is available, else the CPU, which also continues
/// with FrameStatus::gpu_lost where the GPU fails later.
enum class BackEnd { cpu, reference, cuda, automatic };

/// Options of a pipeline beside its configuration and its rig.
struct PipelineOptions {
  BackEnd back_end{BackEnd::cpu};
  /// Index of the GPU for `cuda` and `automatic`, as numbered by CUDA. It stays the current device of the calling
  /// thread.
  int device{0};
  int threads{0};  ///< 0: all cores; at most 1024
  /// false: results have no FrameResult::stages (empty). Copies are faster then, and a GPU skips their download.
  bool stages{true};
  /// Horizons of FrameResult::predictions, s: more than 0, at most 10 000. Not supported on a GPU: `automatic` uses the
  /// CPU, and `cuda` is rejected.
  std::vector<double> horizons_s{};
  /// Mask of the vehicle itself, such as its bonnet: 0 for pixels of the left camera's image that show it, any other
  /// value for used pixels. Masked pixels have no disparity; cells seen through them alone stay unknown. Size of the
  /// recorded image, before levelling. Empty: all pixels are used. Of several cameras the first one's.
  Image<std::uint8_t> mask{};
  /// Masks of the cameras after the first, in their order; cameras without one use all pixels.
  std::vector<Image<std::uint8_t>> other_masks{};
  /// Names of several cameras, in warnings and FrameResult::camera_name: a letter, then letters, digits and _, all
  /// different. Empty: camera0, camera1 …
  std::vector<std::string> camera_names{};
  /// true: camera_height_m, camera_pitch_rad and camera_roll_rad of the rig were measured and are never replaced.
  /// Visible ground that contradicts them is reported as FrameStatus::extrinsics_disagree. false: they are assumed, and
  /// replaced by an estimate from the first frames (Pipeline::process).
  bool extrinsics_given{true};
  /// Pose of the vehicle in the world at the first frame, m and rad, to continue in the world of another run: finite,
  /// and within 1e9 m of the origin.
  Pose2 start{};
  /// Use the pose frame as the world frame, such as ROS's odom; `start` is ignored. At pose jumps the vehicle does not
  /// jump.
  bool in_world_of_poses{false};
  /// Called by process() in its thread, once a frame, when the grids are final and before obstacles are tracked:
  /// `obstacles` is empty, `timing_ms` incomplete, and FrameStatus::too_close and warnings without a status may follow.
  /// A frame that is computed again, with estimated extrinsics or after the loss of a GPU, has it at the end. Counts in
  /// StageTimes::total. Must not throw, nor call the pipeline.
  std::function<void(const FrameResult&)> on_grids{};
};

/// Memory of a pipeline, bytes.
struct MemoryUse {
  std::size_t host_bytes{0};    ///< images, tables, working memory, the result, and memory pinned for a GPU
  std::size_t device_bytes{0};  ///< device memory of a GPU
};

/// FrameImages in the memory of a pipeline's GPU. Luma planes of NV12 are such images. Pitches are at least the width.
struct DeviceImages {
  View<const std::uint8_t, Device> left{};
  View<const std::uint8_t, Device> right{};
  View<const float, Device> disparity{};
  std::uintptr_t stream{0};  ///< the cudaStream_t that writes them; 0: CUDA's default stream
};

/// Grids of a pipeline's last frame in the memory of its GPU, without gaps, [iy][ix]. `vehicle` and `world` are 8
/// layers each: occupancy, velocity_x, velocity_y, age_s, velocity_xx, velocity_xy, velocity_yy, moving, as in
/// GridLayers.
struct DeviceGrids {
  const float* observed;
  const float* vehicle;
  const float* world;
};

/// Computes occupancy grids and obstacle tracks from stereo frames (T-ITS 2012, with the Bayesian Occupancy Filter).
///
/// Not thread-safe: one pipeline serves the cameras of one vehicle, one frame after the other. process(), reset(),
/// save_state() and load_state() throw std::logic_error while another thread is in one of them. A moved-from pipeline
/// can only be assigned to or destroyed; its methods throw std::logic_error.
class STEREOGRID_EXPORT Pipeline {
 public:
  /// Allocates all memory. Throws ConfigError with every problem of `config`, `rig` (see their `problems`) and
  /// `options`. Throws DeviceError if BackEnd::cuda is not usable: no library, no such GPU, old driver, too little
  /// memory; also if the system has too few threads. Throws std::bad_alloc if there is too little memory for the CPU.
  Pipeline(const Config& config, const Rig& rig, const PipelineOptions& options = {});
  /// Several stereo pairs, 1 to 8, with one window, filter and list of obstacles. Rig::camera_x_m, camera_y_m and
  /// camera_yaw_rad place them; grid.rear_m extends the grid behind the vehicle's origin.
  Pipeline(const Config& config, std::span<const Rig> rigs, const PipelineOptions& options = {});
  Pipeline(Pipeline&&) noexcept;
  Pipeline& operator=(Pipeline&&) noexcept;
  ~Pipeline();

  /// Processes the next frame. Frames may be missing; stamps give the time between frames. After a gap of more than
  /// motion.gap_max_s, or a step back of the clock, the pipeline resets as by reset(), with a status and a warning in
  /// the result.
  ///
  /// Ground that contradicts the extrinsics makes a frame FrameStatus::road_unknown. Without
  /// PipelineOptions::extrinsics_given the extrinsics are estimated: 0.12 to 4.5 m above the ground, pitch −12° to 45°,
  /// roll up to ±12°. A larger roll is named in a warning. Until a frame determines them, or three agree, frames are
  /// road_unknown. That frame is processed
  /// with them and has a warning with the estimate, and next_rig() returns the rig with it. Extrinsics that three
  /// frames have confirmed are replaced only after the vehicle has travelled four camera heights over ground that
  /// another plane explains better. A replacement allocates all stages again. Disabled without ground.estimate.
  ///
  /// With several cameras a frame is that of one of them, with those of the others in StereoFrame::others, which a
  /// pipeline of one rig ignores. A camera without a frame observes nothing. The newest stamp is the time of the
  /// result, whose vehicle frame is that of the newest frame; its other grids are used. Poses compensate the motion
  /// from the other stamps to it. Calls are in the order of their newest stamps. The observed grids are fused by the
  /// mean log odds of those that see a cell. A leap of a camera's own clock resets that camera, with a status.
  ///
  /// Throws InputError for an invalid frame: it does not fit the rig, has the stamp of the frame before, a pose that is
  /// not finite or farther than 1e9 m from the origin, or invalid other grids. The state is then unchanged.
  ///
  /// After any other exception, such as std::bad_alloc or DeviceError, the frame counts as not processed: it may be
  /// given again. Clock and world are those before it. If the stages had begun the frame, the state is that after
  /// reset().
  ///
  /// Returns a result owned by the pipeline, valid until the next call.
  const FrameResult& process(const StereoFrame& frame);

  /// Writes the result to `into`, which is replaced and never read. Its memory is reused; nothing is allocated if it
  /// was filled by this pipeline before. Unchanged after InputError, undefined after any other exception.
  void process(const StereoFrame& frame, FrameResult& into);
  /// Reads `images` in place of those of `frame`, without a copy. Their memory must not change during the call. Throws
  /// InputError also for images without pixels and for rows that overlap.
  void process(const StereoFrame& frame, const FrameImages& images, FrameResult& into);

  /// process() with images in the memory of the pipeline's GPU. They are copied to the host, once, where tracking,
  /// terrain and obstacles read them; waits for that. Frames of other cameras are in the host's memory. Throws
  /// ConfigError unless back_end() is cuda. DeviceError does not make `automatic` continue on the CPU during the copy.
  void process_from_device(const StereoFrame& frame, const DeviceImages& images, FrameResult& into);
  /// The grids of the last frame where the GPU has left them, equal to those of its result. Nothing is copied, and
  /// there is nothing to wait for. The memory belongs to the pipeline and is valid until its next call. Throws
  /// ConfigError unless back_end() is cuda, InputError before a frame.
  [[nodiscard]] DeviceGrids device_grids();

  /// Resets the state: the next frame counts as a first one, whatever its stamp. Filter, tracks, features, ground and
  /// row offsets restart as at construction; estimated extrinsics are kept. The world frame continues: ids are not
  /// reused. The vehicle's pose continues from the poses without a check for jumps, and is unchanged without poses.
  void reset();

  /// Configuration with all "automatic" values resolved.
  [[nodiscard]] const Config& config() const;
  /// Rig of the constructor, of several cameras the first. A frame's rig is FrameResult::rig.
  [[nodiscard]] const Rig& rig() const;
  [[nodiscard]] std::span<const Rig> rigs() const;
  /// Names of several cameras; empty: one camera.
  [[nodiscard]] const std::vector<std::string>& camera_names() const;
  /// Rig of a camera's next frame: rigs()[camera], or with extrinsics that were estimated or restored by load_state().
  [[nodiscard]] const Rig& next_rig(int camera = 0) const;
  [[nodiscard]] GridGeometry vehicle_grid() const;
  /// Size of the world-aligned window: its nx, ny and cell_size_m are constant, its origin follows the vehicle.
  [[nodiscard]] GridGeometry world_grid() const;
  [[nodiscard]] int threads() const;
  /// Memory allocated by the constructor. process() does not allocate on the CPU, except for pixels to
  /// ignore (StereoFrame::labels) and far more obstacles or tracked features than on usual streets. Part of it stays
  /// untouched for a long time and may have no physical memory. Excludes memory of oneTBB, the CUDA driver and the
  /// reference back end.
  [[nodiscard]] MemoryUse memory_use() const;
  /// Back end in use: cpu, reference or cuda.
  [[nodiscard]] BackEnd back_end() const;
  /// Reason why `automatic` did not use the GPU; empty if it did, or was not set.
  [[nodiscard]] const std::string& why_not_cuda() const;

  /// State between two frames as bytes, including estimated extrinsics. A pipeline of the same configuration, rig, mask
  /// and back end that loads it continues with the same results. Valid for the same version of the library on machines
  /// of one kind; the checksum detects damage, not forgery.
  [[nodiscard]] std::vector<std::byte> save_state() const;
  /// Loads a state into stages that it allocates. Throws InputError: no saved state, damaged, or of another
  /// configuration, rig, mask, back end or version. After any exception, std::bad_alloc and DeviceError included, the
  /// state is unchanged.
  void load_state(std::span<const std::byte> saved);

 private:
  struct STEREOGRID_HIDDEN Implementation;
  /// Throws std::logic_error for a moved-from pipeline.
  [[nodiscard]] STEREOGRID_HIDDEN Implementation& implementation() const;
  std::unique_ptr<Implementation> implementation_;
};

/// Version of the library, "major.minor.patch".
[[nodiscard]] STEREOGRID_EXPORT std::string_view version();

/// Instruction set of the CPU back end on this machine, e.g. "x86-64-v3".
[[nodiscard]] STEREOGRID_EXPORT std::string_view simd_target();

}  // namespace stereogrid
