// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "stereogrid/camera.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/level_mapping.hpp"
#include "stereogrid/result.hpp"

namespace stereogrid::app {

/// Finds what of a camera's image shows the vehicle itself: at the lower edge, and at the same distance, off the road,
/// in every frame, or with the same texture, while the vehicle moves past all else. Only frames count in which poses
/// and images agree that it has moved: what merely stands still before a vehicle that stands is never taken for a part
/// of it.
class OwnVehicle {
 public:
  explicit OwnVehicle(const Rig& rig) { begin(rig); }

  /// Adds the next frame and its result. Another rig than that of the frame before restarts the search.
  void add(const StereoFrame& frame, const FrameResult& result);

  /// True if there are enough observations for a result.
  [[nodiscard]] bool is_sure() const;
  [[nodiscard]] std::size_t frames() const { return frames_; }
  [[nodiscard]] double travelled_m() const { return travelled_m_; }

  /// PipelineOptions::mask, with a margin of `margin_px` above the outline; empty: none found, or uncertain.
  [[nodiscard]] Image<std::uint8_t> mask(int margin_px) const;

 private:
  /// A place of the level image that is looked at.
  struct Place {
    int level_u;
    int level_v;
    int camera_u;
    int camera_v;
    int gradient;              ///< last counted frame
    std::vector<float> seen;   ///< disparities there, of the frames that count
    std::size_t off_the_road;  ///< frames in which it was near by and above the road
    std::size_t changed;       ///< frames in which it looked different than in the frame before
    std::size_t textured;      ///< frames in which it had texture
  };
  /// `steady`: of the vehicle, by its disparity; `still`: by its texture.
  enum class Verdict { steady, still, street, unknown };
  /// Upper end of the vehicle in a column of samples, its evidence by disparities, and the lowest sample that shows the
  /// street.
  struct Column {
    int top;
    int steady;
    int lowest_street;
  };

  void begin(const Rig& rig);
  [[nodiscard]] bool has_moved(const StereoFrame& frame) const;
  void count(const StereoFrame& frame, const FrameResult& result);
  [[nodiscard]] Verdict verdict_of(const Place& place) const;
  [[nodiscard]] Column look_up(int column) const;
  [[nodiscard]] std::vector<int> outline() const;

  Rig rig_;
  LevelMapping mapping_{rig_};
  int across_{0};
  int down_{0};
  std::vector<Place> places_;  ///< row by row
  bool has_frame_{false};
  Pose2 last_pose_;
  std::size_t frames_{0};
  double travelled_m_{0};
};

}  // namespace stereogrid::app
