// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <mutex>

#include "stereogrid/scenes/scene.hpp"
#include "support.hpp"

namespace stereogrid::test {

/// The default preset with 10 × 8 m, which is quicker.
inline Config small_grid() {
  Config config{preset("default")};
  config.grid.length_m = 10;
  config.grid.width_m = 8;
  return config;
}

/// A built-in scene. Each frame is rendered once for all tests of a program.
class Scene : public scenes::Scene {
 public:
  explicit Scene(std::string text) : scenes::Scene{scenes::parse_scene(text), 2}, text_{std::move(text)} {}

  using scenes::Scene::load;
  StereoFrame load(std::size_t index) const override {
    static std::mutex mutex;
    static std::map<std::pair<std::string, std::size_t>, StereoFrame> rendered;
    const std::lock_guard lock{mutex};
    const auto [frame, is_new] = rendered.try_emplace({text_, index});
    if (is_new) frame->second = scenes::Scene::load(index);
    return frame->second;
  }

 private:
  std::string text_;
};

/// A frame with the exact disparities in place of the right image.
inline StereoFrame given_frame(const Scene& scene, std::size_t index) {
  StereoFrame frame{scene.load(index)};
  frame.right = {};
  frame.disparity = scene.truth(index).disparity;
  return frame;
}

/// Largest P(occupied) within `reach_m` of a place.
inline float highest_near(const Image<float>& cells, const GridGeometry& grid, Point2 place, double reach_m = 0.6) {
  float highest{0};
  for (const auto [ix, iy] : raster(cells)) {
    const Point2 at{grid.centre(ix, iy)};
    if (std::hypot(at.x - place.x, at.y - place.y) < reach_m) highest = std::max(highest, cells(ix, iy));
  }
  return highest;
}

/// The whole pipeline on a built-in scene.
struct Drive {
  explicit Drive(const char* scene_text, const Config& config = preset("default"), int threads = 2,
                 BackEnd back_end = BackEnd::cpu)
      : scene{scene_text}, pipeline{config, scene.rig(), {.back_end = back_end, .threads = threads}} {}

  const FrameResult& step(std::size_t index) { return pipeline.process(scene.load(index)); }

  Scene scene;
  Pipeline pipeline;
};

}  // namespace stereogrid::test
