// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "input.hpp"
#include "stereogrid/evaluation/labels.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/io/frame_queue.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/odometry.hpp"

namespace stereogrid::app {

/// Sees to the poses before the pipeline: leaves the input's own, takes them away, or finds them by visual odometry.
/// Takes the frames in their order, on whatever thread.
class PoseStage {
 public:
  /// Keeps the state of the odometry after every frame for which `is_kept` returns true, for take_state().
  PoseStage(PoseSource poses, const Rig& rig, const Image<std::uint8_t>& mask,
            std::function<bool(std::size_t index)> is_kept = {});

  /// Restores a state, before the first frame. Throws InputError if the state does not fit.
  void load(const OdometryState& state);

  struct Placed {
    std::optional<std::string> warning{};
    std::optional<PoseCovariances> covariances{};  ///< none: the pose came with the input
  };
  /// Throws InputError where the frame does not fit the rig.
  Placed place(StereoFrame& frame);
  void place(io::QueuedFrame& queued);

  [[nodiscard]] bool takes_time() const { return odometry_.has_value(); }

  /// State of the odometry after a frame, once; none: poses came with the input, or the frame was not kept.
  [[nodiscard]] std::optional<OdometryState> take_state(std::size_t index);

 private:
  PoseSource poses_;
  Rig rig_;
  std::optional<VisualOdometry> odometry_;
  std::function<bool(std::size_t)> is_kept_;
  std::mutex mutex_;  // frames are placed on other threads than their states are taken on
  std::map<std::size_t, OdometryState> kept_;
};

/// The lidar sweeps of a recording, in the left camera's frame.
class Sweeps {
 public:
  /// `recording`: may be none, as of a scene; it must outlive this.
  explicit Sweeps(const io::Recording* recording) : recording_{recording} {}

  /// True if there are sweeps with a known position of the lidar.
  [[nodiscard]] bool exist() const;
  /// Throws InputError where they do not; `instead` is what would mend that a recording has none.
  void require(const std::string& instead) const;

  /// Points of a frame, in the sensor's order; empty: none. Throws InputError; DeviceError if a listed file cannot be
  /// read now.
  [[nodiscard]] std::vector<evaluation::CameraPoint> of(std::size_t index) const;
  /// Position of the lidar.
  [[nodiscard]] evaluation::CameraPoint lidar_in_camera() const;

 private:
  const io::Recording* recording_;
};

/// Beginning of the warnings of frames without a grid to fuse.
extern const char* const stereo_alone;

/// Sources of grids that --fuse fuses with the stereo pair's.
enum class FusedSource { none, lidar, grids, labels };
constexpr std::array<std::string_view, 4> names_of(FusedSource) {
  return {"none", "lidar", "grids", "labels"};
}
/// Throws ConfigError: no such source.
[[nodiscard]] FusedSource fused_source(const std::string& name);

/// Adds the grid of another source to frames, before the pipeline (--fuse).
class FusionStage {
 public:
  /// `grid`: geometry of the grids that are added. Throws InputError where the input lacks the source.
  FusionStage(FusedSource source, const Input& input, const GridGeometry& grid);

  /// Adds the grid that an inverse sensor model makes of the frame's sweep, the camera being mounted as `rig` says; or
  /// the grid of another program, or label_grid() of the frame. `index`: of the frame in the recording. Returns a
  /// warning where there is none: `stereo_alone` and the reason.
  [[nodiscard]] std::optional<std::string> add_grid(StereoFrame& frame, std::size_t index, const Rig& rig) const;

 private:
  [[nodiscard]] std::optional<ObservedGrid> grid_of(const StereoFrame& frame, std::size_t index, const Rig& rig) const;

  FusedSource source_;
  decltype(Input::grid_at) grid_at_;
  const io::Recording* recording_;
  Sweeps sweeps_;
  GridGeometry grid_;
};

}  // namespace stereogrid::app
