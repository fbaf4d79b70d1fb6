// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "support.hpp"

namespace stereogrid::test {

/// Under sanitizers the plain loops take minutes; whatever decides about clocks, rigs and poses stands once for both.
inline std::vector<BackEnd> back_ends() {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return {BackEnd::cpu};
#else
  return {BackEnd::cpu, BackEnd::reference};
#endif
}

/// A camera of 128 × 80 px.
inline Rig small_rig() {
  return {128, 80, 100, 64, 40, 0.36, 1.2, 0, 0};
}

inline Config small_config() {
  Config config{preset("default")};
  config.grid = {12, 8, 0.5};
  config.matching.window_px = 5;
  config.matching.disparities = 16;
  config.matching.speckle_px = config.matching.road_speckle_px = 20;
  config.filter.speeds_mps = {1.25, 2.5};
  return config;
}

/// Columns by which the right image shows row v farther left: a wall 9 m away that stands on the road.
inline double wall_disparity_px(int v) {
  const Rig rig{small_rig()};
  return std::max(rig.focal_px * rig.baseline_m / 9, (v - rig.cy_px) * rig.baseline_m / rig.camera_height_m);
}

/// Statuses caused by the clock and the poses.
inline std::vector<FrameStatus> leaps_of(const FrameResult& result) {
  std::vector<FrameStatus> leaps;
  for (const FrameStatus status : result.status) {
    if (status <= FrameStatus::pose_jump) leaps.push_back(status);
  }
  return leaps;
}

/// Both images of that wall, wider than the camera's.
struct WallImages {
  static constexpr int columns{200};

  Texture texture{7};
  Image<std::uint8_t> left{
      textured_image(texture, columns, small_rig().height_px, [](int u, int) { return static_cast<double>(u); })};
  Image<std::uint8_t> right{
      textured_image(texture, columns, small_rig().height_px, [](int u, int v) { return u + wall_disparity_px(v); })};
};

inline Image<std::uint8_t> columns_from(const Image<std::uint8_t>& wide, int first) {
  Image<std::uint8_t> image{small_rig().width_px, small_rig().height_px};
  for (int v{0}; v < image.height(); ++v) std::copy_n(wide.row(v) + first, image.width(), image.row(v));
  return image;
}

/// A pipeline in front of that wall. Its texture moves by a pixel a frame, so that points are followed on it.
struct Wall {
  explicit Wall(BackEnd back_end, const Config& config = small_config(), const Rig& rig = small_rig())
      : Wall{PipelineOptions{.back_end = back_end, .threads = 2}, config, rig} {}
  explicit Wall(const PipelineOptions& options, const Config& config = small_config(), const Rig& rig = small_rig())
      : pipeline{config, rig, options} {}

  StereoFrame frame(std::int64_t stamp_ns) const {
    static const WallImages images;
    StereoFrame frame;
    frame.name = std::to_string(number);
    frame.index = number;
    frame.stamp_ns = stamp_ns;
    frame.left = columns_from(images.left, number);
    frame.right = columns_from(images.right, number);
    if (has_poses) frame.world_from_vehicle = Pose2{place_m, 3, 0};
    return frame;
  }

  const FrameResult& step(std::int64_t stamp_ns) {
    const StereoFrame next{frame(stamp_ns)};
    ++number;
    place_m += speed_mps / 10;
    return pipeline.process(next);
  }

  void remove_refused(int frames) {
    number -= frames;
    place_m -= frames * speed_mps / 10;
  }

  Pipeline pipeline;
  int number{0};  ///< number of the next frame, up to 72
  bool has_poses{false};
  double place_m{0};
  double speed_mps{0};
};

}  // namespace stereogrid::test
