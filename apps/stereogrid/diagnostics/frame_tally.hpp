// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "input.hpp"
#include "stereogrid/camera.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/io/run_folder/frame_lines.hpp"
#include "stereogrid/result.hpp"

namespace stereogrid::app {

/// Number of frames after a pair that does not match in which the other image of its instant is searched.
constexpr std::size_t most_late{5};

/// Number of frames that have something in common, and the first of them.
struct FrameCount {
  std::size_t frames{0};
  io::FrameSummary first{};

  void add(const io::FrameSummary& frame) {
    if (frames++ == 0) first = frame;
  }
};

/// True where the images match and show the road plane.
[[nodiscard]] bool shows_road(const io::FrameSummary& frame);

/// Counts of what the frames of an input report. Its size does not depend on the number of frames.
struct FrameTally {
  std::size_t frames{0};
  FrameCount unknown;  ///< no cell of the observed grid is known
  std::array<FrameCount, names_of(FrameStatus{}).size()> flags;
  FrameCount without_road;                  ///< matched, but the road plane was not measured
  FrameCount unequal_exposure;              ///< one image is brighter than the other
  std::map<int, std::size_t> road_pitches;  ///< number of frames with each measured pitch, in 1e-4 rad

  void add(const io::FrameSummary& frame);
  [[nodiscard]] const FrameCount& with(FrameStatus flag) const { return flags[static_cast<std::size_t>(flag)]; }
};

/// The input and the pipeline whose frames were counted.
struct TallyContext {
  const Input& input;  ///< may lack a source
  const Config& config;
  Rig source_rig;  ///< rig of the input
  Rig used;        ///< Pipeline::next_rig() after the last frame
  /// Loads a frame that was counted; none where it is not available any more.
  std::function<std::optional<StereoFrame>(std::size_t index)> frame_at;
};

struct Findings {
  std::vector<std::string> texts;
  bool are_sides_swapped{false};
};

/// Describes in plain text what is wrong with the frames, in how many of them, and the remedy. The first frames with
/// few matches and without a road are examined for the reason. `info`, `run` and `live` all print these texts.
[[nodiscard]] Findings findings_of(const FrameTally& tally, const TallyContext& context);

/// True if one of the images is black or without texture.
[[nodiscard]] bool is_without_texture(const StereoFrame& frame);

/// Message if the road is found when the rig is rotated by 180° about its optical axis.
[[nodiscard]] std::optional<std::string> fault_if_upside_down(const StereoFrame& frame, const TallyContext& context);

/// Message if one plane fills the view, like the ground below a camera pitched down by more than 45°, or that is
/// higher than extrinsics are estimated.
[[nodiscard]] std::optional<std::string> fault_of_view(const StereoFrame& frame, const TallyContext& context);

/// Message where the farthest points of the pair have negative disparities: upside down, or shifted; none: they have
/// not.
[[nodiscard]] std::optional<std::string> fault_of_shift(const StereoFrame& frame, const TallyContext& context);

/// Message where planes are clearly flatter if the depths of a recording are taken as Euclidean distances from the
/// camera's centre.
[[nodiscard]] std::optional<std::string> fault_of_distances(const StereoFrame& frame, const TallyContext& context);

/// Message where matched corners of a rectified pair lie on different rows.
[[nodiscard]] std::optional<std::string> fault_of_residual(const StereoFrame& frame);

/// Texts of fault_of_shift() and fault_of_distances(), for the first frame of an input.
[[nodiscard]] std::vector<std::string> faults_of_frame(const StereoFrame& frame, const TallyContext& context);

/// Message where the road is found with external disparities or depths in another unit; "": with none.
[[nodiscard]] std::string fault_of_scale(const StereoFrame& frame, const TallyContext& context);

/// Reason for the few matches of a pair, and its remedy.
struct PairFault {
  std::string text;
  bool is_swapped{false};
};

/// A frame of the input; none beyond its end, and where it cannot be loaded.
[[nodiscard]] std::optional<StereoFrame> loaded(const FrameSource& source, std::size_t index);

/// Finds the fault of a pair that hardly matches: no texture, sides swapped, images of different instants, vertical
/// misalignment, images rectified twice, upside down, disparities beyond the search range. The text is empty if none of
/// them is found. Frames after it are those of the input's source, or else of `frame_at`.
[[nodiscard]] PairFault fault_of_pair(const TallyContext& context, const StereoFrame& frame);

/// Compares the observed grids of several cameras where their views overlap.
class PlaceCheck {
 public:
  /// `every`: only frames whose number is a multiple of it, 20 at most.
  explicit PlaceCheck(int every) : every_{every} {}

  void add(const FrameResult& result);
  /// Texts for pairs of cameras whose grids agree clearly better with one of them turned.
  [[nodiscard]] std::vector<std::string> findings() const;

 private:
  static constexpr int turns_{33};  ///< from −8° to 8° in steps of half a degree
  /// Sums over cells that both cameras observe.
  struct Agreement {
    double product{0};  ///< product of both log odds
    double first{0};    ///< squares of the first camera's; likewise the second's
    double second{0};
    int cells{0};
    int obstacles{0};  ///< number of cells that are occupied in both

    [[nodiscard]] double correlation() const;
  };
  using Turned = std::array<Agreement, turns_>;

  static void compare(const Image<float>& first, const Image<float>& second, const GridGeometry& grid,
                      const Pose2& place, Turned& turned);

  int every_;
  int seen_{0};
  int frames_{0};
  std::vector<std::string> names_;
  std::map<std::pair<std::size_t, std::size_t>, Turned> pairs_;  // cameras whose views overlap enough
};

/// Motion of the vehicle frame between two frames, by the images and by the poses that came with them.
struct MotionPair {
  Pose2 seen;
  Pose2 external;
};

/// Describes how given poses contradict the motion in the images, and the place of the camera that they would fit;
/// empty: they agree, or nothing is known.
[[nodiscard]] std::optional<std::string> contradiction_of(std::span<const MotionPair> steps);

/// The same of an input with poses of its own, by visual odometry over some frames in the middle of it.
[[nodiscard]] std::optional<std::string> contradiction_of_poses(const Input& input);

}  // namespace stereogrid::app
