// SPDX-License-Identifier: Apache-2.0
#pragma once

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

/// The whole pipeline on a built-in scene.
struct Drive {
  explicit Drive(const char* scene_text, const Config& config = preset("default"), int threads = 2,
                 BackEnd back_end = BackEnd::cpu)
      : scene{scenes::parse_scene(scene_text), 2},
        pipeline{config, scene.rig(), {.back_end = back_end, .threads = threads}} {}

  const FrameResult& step(std::size_t index) { return pipeline.process(scene.load(index)); }

  scenes::Scene scene;
  Pipeline pipeline;
};

}  // namespace stereogrid::test
