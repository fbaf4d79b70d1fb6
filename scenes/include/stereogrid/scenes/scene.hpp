// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "stereogrid/export.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/truth.hpp"

namespace stereogrid::scenes {

/// Which scene, seen by which camera. 0 where marked: take the default.
///
/// Default camera: images narrower than 1000 px have f = 410 px · width/512, 0.22 m baseline and 1.25 m height; wider
/// ones are like KITTI's: f = 721.5 px · width/1242, 0.54 m, 1.65 m. The centre is (width/2, height/2).
struct SceneOptions {
  std::string name;
  int frames{0};  ///< 0: as many as the scene was made for
  std::uint64_t seed{1};
  int width_px{512};
  int height_px{320};
  double focal_px{0};         ///< 0: default camera
  double baseline_m{0};       ///< 0: default camera
  double camera_height_m{0};  ///< 0: default camera
  double camera_pitch_rad{0};
  double camera_roll_rad{0};  ///< positive: right side down
  double rate_hz{10};
  double noise_grey{2.5};  ///< standard deviation of the sensor noise, each camera and frame its own
  double gain{1.05};       ///< brightness of the right camera relative to the left one
  /// "car", or "robot": 0.35 m high, baseline 0.09 m, truth for a vehicle 0.5 m high that climbs 0.03 m, on cells of
  /// 0.05 m. parse_scene pitches a robot's camera by 8° unless the text says otherwise.
  std::string camera{"car"};
  double pitch_noise_rad{0};  ///< standard deviations of what the suspension does to the camera in each frame
  double roll_noise_rad{0};
  double height_noise_m{0};
  // Scenes of uneven ground: "pallet", "step", "table", "terrain" and "course". 0: default of the scene or the kind.
  std::string kind{"flat"};  ///< kind of "terrain": terrain_kinds(), or "random"
  double edge_m{0};          ///< distance from the vehicle to the obstacle or edge in the last frame
  double rise_m{0};          ///< height of the obstacle or of the ground beyond the edge; negative: it falls
  double incline_deg{90};    ///< slope of a "step"; 90: vertical
  double slope_deg{0};       ///< slope of the ground; negative: falling
  double span_m{0};          ///< length of the feature in driving direction
  int steps{0};              ///< steps that the rise is divided into
  double skew_deg{0};        ///< heading of the vehicle against the normal of an edge
  double speed_mps{-1};      ///< speed in "terrain" and "course"; negative: default of the scene
  int cameras{1};            ///< 1 to 8, from the one ahead to the left
  double turn_deg{0};        ///< from each camera to the next; 0: evenly around
  double ring_m{0.5};        ///< distance of several cameras from the vehicle's origin, each in its direction
};

/// The built-in scenes, in alphabetical order.
[[nodiscard]] STEREOGRID_EXPORT std::vector<std::string> scene_names();

/// Layouts of the scene "terrain", in alphabetical order.
[[nodiscard]] STEREOGRID_EXPORT std::vector<std::string> terrain_kinds();

/// Reads "scene:street?frames=60&seed=3&width=1242&height=375", with or without "scene:". Keys: frames, seed, width,
/// height, focal (px), baseline (m), camera_height (m), pitch_deg, roll_deg, rate (Hz), noise (grey levels), gain,
/// camera, pitch_noise_deg, roll_noise_deg, height_noise (m); of uneven ground: kind, at or edge (m), rise or depth
/// (m), incline_deg, slope_deg, span (m), steps, skew_deg, speed (m/s); of several cameras: cameras, turn_deg, ring
/// (m). Throws InputError, with the known scenes or keys and their ranges.
[[nodiscard]] STEREOGRID_EXPORT SceneOptions parse_scene(std::string_view text);

/// A ray-cast street scene with exact truth. World frame: the vehicle frame of the start. The same options give the
/// same images on every machine and any number of threads.
class STEREOGRID_EXPORT Scene : public FrameSource {
 public:
  /// `threads` 0: all cores. Throws InputError for an unknown scene or values out of range.
  explicit Scene(SceneOptions options, int threads = 0);
  ~Scene() override;

  [[nodiscard]] const Rig& rig() const override;
  [[nodiscard]] std::span<const Rig> rigs() const override;
  [[nodiscard]] std::size_t size() const override;
  [[nodiscard]] std::string name(std::size_t index) const override;
  /// Renders the images of all cameras. Throws InputError beyond the last frame.
  [[nodiscard]] StereoFrame load(std::size_t index) const override;
  /// The same instant, seen by a vehicle that is elsewhere than the scene's motion has it.
  [[nodiscard]] StereoFrame load(std::size_t index, const Pose2& world_from_vehicle) const;

  /// With every default filled in.
  [[nodiscard]] const SceneOptions& options() const;
  /// Images of the first camera; cells as any camera sees them.
  [[nodiscard]] FrameTruth truth(std::size_t index) const;
  [[nodiscard]] TruthGrid truth_grid() const;

 private:
  struct STEREOGRID_HIDDEN Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace stereogrid::scenes
