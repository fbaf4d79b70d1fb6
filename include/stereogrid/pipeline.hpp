// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
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

/// Where the work is done. `automatic`: on a GPU where there is one that can be used, else on the CPU.
enum class BackEnd { cpu, reference, cuda, automatic };

/// How a pipeline works, beside its configuration and its rig.
struct PipelineOptions {
  BackEnd back_end{BackEnd::cpu};
  /// Which GPU `cuda` and `automatic` take, counted from 0 as CUDA does. It is left as the current one of the thread
  /// that calls.
  int device{0};
  int threads{0};  ///< 0: all cores; at most 1024
  /// false: results come without FrameResult::stages (empty). They are quicker to copy then, and a GPU need not hand
  /// them over.
  bool stages{true};
  /// Of FrameResult::predictions, s: more than 0, at most 10 000; long before that everything is forgotten. A GPU does
  /// not predict: `automatic` takes the CPU then, and `cuda` is refused.
  std::vector<double> horizons_s{};
  /// Pixels of the left camera's image that show the vehicle itself, its bonnet for instance: 0. They have no disparity
  /// and say nothing of the street; what is seen through them alone stays unknown. Of the camera's size, as the images
  /// come, be it pitched or not; any other number: the pixel is used. Empty: all are.
  Image<std::uint8_t> mask{};
  /// The rig's camera_height_m, camera_pitch_rad and camera_roll_rad were measured: they are never replaced. Ground in
  /// view that contradicts them is reported as FrameStatus::extrinsics_disagree. false: they are assumed, and replaced
  /// by those that the first frames show (Pipeline::process).
  bool extrinsics_given{true};
  /// Where the vehicle is in the world at the first frame, m and rad, for a run that goes on in the world of another
  /// one: finite, and within 1e9 m of the origin.
  Pose2 start{};
  /// The world is that in which the frames' poses are: the first pose says where the vehicle is in it, `start` does not
  /// count. For programs that share a frame with others, such as ROS's odom. Where poses jump the vehicle does not, as
  /// otherwise.
  bool in_world_of_poses{false};
};

/// Bytes that a pipeline holds.
struct MemoryUse {
  std::size_t host_bytes{0};    ///< images, tables, working memory, the result; what is pinned for a GPU, too
  std::size_t device_bytes{0};  ///< of a GPU's own memory
};

/// Stereo frames in, occupancy grids out (T-ITS 2012, with the Bayesian Occupancy Filter and obstacle tracks behind
/// it).
///
/// Not thread-safe: one pipeline serves one camera, one frame after the other. process(), reset(), save_state() and
/// load_state() throw std::logic_error while another thread is in one of them. One that has been moved from can only be
/// assigned to or destroyed; its methods throw std::logic_error.
class STEREOGRID_EXPORT Pipeline {
 public:
  /// Allocates everything. Throws ConfigError with every problem of `config` and `rig` (see their `problems`) and of
  /// `options`, DeviceError where BackEnd::cuda cannot work: no library, no GPU of that number, too old a driver, too
  /// little memory, and std::bad_alloc where the CPU's memory does not do.
  Pipeline(const Config& config, const Rig& rig, const PipelineOptions& options = {});
  Pipeline(Pipeline&&) noexcept;
  Pipeline& operator=(Pipeline&&) noexcept;
  ~Pipeline();

  /// Takes the next frame. Frames may be missing, the time between two is taken from their stamps. Where they are more
  /// than motion.gap_max_s apart, or the clock has stepped back, the pipeline begins afresh as with reset(), and the
  /// result's status and warnings say so.
  ///
  /// Ground that does not lie where the extrinsics have it, in the first frames or later, makes a frame
  /// FrameStatus::road_unknown. Without PipelineOptions::extrinsics_given the extrinsics are searched in the first
  /// frames: 0.2 to 4 m above the ground, pitch −10° to 35°, roll up to ±10°. Once three frames agree, a warning of the
  /// third has the estimate, next_rig() the rig with it, and the next frame is a first one of that rig, in
  /// the same world. Extrinsics that have explained three frames are replaced only after the vehicle has travelled four
  /// camera heights over ground that shows others, in front of the camera as well as farther away. A replacement
  /// allocates all stages anew; after std::bad_alloc or DeviceError the pipeline is unchanged. ground.estimate off
  /// disables it.
  ///
  /// Throws InputError when the frame cannot be used: it does not fit the rig, has the stamp of the frame before, a
  /// pose that is not finite or farther than 1e9 m from its origin, other grids that are none. The pipeline's state is
  /// then unchanged.
  ///
  /// The result is the pipeline's own and changes with the next call.
  const FrameResult& process(const StereoFrame& frame);

  /// The same into a result of the caller's, which is replaced and never read: keep it, move it on or exchange it for
  /// another one between frames. Its memory is used again; nothing is allocated where it comes from this pipeline.
  /// After an InputError it is as it was, after a DeviceError undefined.
  void process(const StereoFrame& frame, FrameResult& into);

  /// The next frame is a first one, whatever its stamp: filter, tracks, followed points, ground and row offsets begin
  /// as at construction, but for a mounting that has been found. The world goes on: ids of obstacles are not used
  /// again, the vehicle's place follows the poses from where they had it, without a look at how fast it would have
  /// moved, and stays where it is without poses.
  void reset();

  /// The configuration with every "automatic" value resolved.
  [[nodiscard]] const Config& config() const;
  /// As given. A frame's rig is FrameResult::rig.
  [[nodiscard]] const Rig& rig() const;
  /// Rig of the next frame: rig(), or with extrinsics that process() has found or load_state() has restored.
  [[nodiscard]] const Rig& next_rig() const;
  [[nodiscard]] GridGeometry vehicle_grid() const;
  /// Size of the world-aligned window: its nx, ny and cell_size_m are constant, its origin follows the car.
  [[nodiscard]] GridGeometry world_grid() const;
  [[nodiscard]] int threads() const;
  /// Memory allocated by the constructor. process() does not allocate on the CPU, unless there are far more obstacles
  /// or tracked features than a street has. Part of it lies untouched for long, which the system then need not back.
  /// Excludes memory of oneTBB, the CUDA driver and the reference back end.
  [[nodiscard]] MemoryUse memory_use() const;
  /// Where the work is done: cpu, reference or cuda.
  [[nodiscard]] BackEnd back_end() const;
  /// Why `automatic` did not take the GPU; empty: it did, or was not asked to.
  [[nodiscard]] const std::string& why_not_cuda() const;

  /// What the pipeline remembers between two frames, as bytes, a mounting that has been found among it: a pipeline of
  /// the same configuration, rig, mask and back end that loads it goes on exactly as this one would. For the same
  /// version of the library on machines of one kind; the checksum tells damage, not forgery.
  [[nodiscard]] std::vector<std::byte> save_state() const;
  /// Throws InputError: no saved state, damaged, or of another configuration, rig, mask, back end or version; nothing
  /// has changed then.
  void load_state(std::span<const std::byte> saved);

 private:
  struct STEREOGRID_HIDDEN Implementation;
  /// Throws std::logic_error: moved from.
  [[nodiscard]] STEREOGRID_HIDDEN Implementation& implementation() const;
  std::unique_ptr<Implementation> implementation_;
};

/// Version of the library, "major.minor.patch".
[[nodiscard]] STEREOGRID_EXPORT std::string_view version();

/// The instruction set that the CPU back end uses on this machine, e.g. "x86-64-v3".
[[nodiscard]] STEREOGRID_EXPORT std::string_view simd_target();

}  // namespace stereogrid
